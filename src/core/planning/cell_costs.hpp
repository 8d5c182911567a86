// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <unordered_map>
#include <vector>

#include "voxnav/planning/a_star_config.hpp"
#include "voxnav/planning/occupancy_view.hpp"

namespace voxnav::planning {

/// Cost per metre of a cell in units of 1 / kUnitCost; 0 = may not be entered.
using CellCost = std::uint16_t;
constexpr CellCost kUnitCost = 256;
using CostBlock = std::array<CellCost, geometry::kBlockVolume>;

/// Turns states into costs, one block at a time: grows obstacles by the safety distance, applies the rule for
/// unknown cells and charges for lack of clearance. Distances run from a cell's centre to the nearest face of an
/// occupied voxel, so a lattice path that cuts no corner keeps the safety distance all along its edges.
class CellCosts {
 public:
  /// @param view must outlive this object
  CellCosts(const OccupancyView& view, const AStarConfig& config, const geometry::Vec3& start);

  void compute(const geometry::Index3& block, CostBlock* out);
  /// Raw state, from the cached block.
  State state(const geometry::Index3& voxel);
  bool is_inside(const geometry::Index3& voxel) const;
  std::size_t memory_bytes() const { return states_.size() * (sizeof(StateBlock) + 64); }

 private:
  /// Squared distances in voxels of a block's cells to the nearest voxel of one kind, cut off beyond the radius.
  using Distances = std::array<float, geometry::kBlockVolume>;

  const StateBlock* states_of(const geometry::Index3& block);
  template <class Select>
  bool distances(const geometry::Index3& block, Select select, Distances* out);
  CellCost cost_of(const geometry::Index3& voxel, State state, bool is_near_occupied, float distance_sq) const;
  bool is_near_start(const geometry::Index3& voxel) const;
  bool touches_start_range(const geometry::Index3& block) const;
  CellCost unknown_cost(const geometry::Index3& voxel) const;

  const OccupancyView& view_;
  AStarConfig config_;
  geometry::Vec3 start_;
  double resolution_m_;
  geometry::Index3 lowest_;  ///< first and last voxel inside the view's box
  geometry::Index3 highest_;
  float safety_sq_;  ///< squares of distances in voxels
  double safety_;
  double clearance_;
  float known_sq_ = 0.0F;       ///< cells nearer to unknown ones cost more near the start; 0 = none do
  int radius_;                  ///< voxels that the distances must see
  std::vector<float> weights_;  ///< squared face distance by axis offset
  std::vector<float> pass_a_, pass_b_;
  std::unordered_map<geometry::Index3, StateBlock, geometry::Index3Hash> states_;
};

}  // namespace voxnav::planning
