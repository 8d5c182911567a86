// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <unordered_map>
#include <vector>

#include "voxnav/planning/a_star.hpp"
#include "voxnav/planning/fences.hpp"
#include "voxnav/planning/occupancy_view.hpp"

namespace voxnav::planning {

/// Cost per metre of a cell in units of 1 / kUnitCost; 0 = the cell may not be entered.
using CellCost = std::uint16_t;
constexpr CellCost kUnitCost = 256;
using CostBlock = std::array<CellCost, geometry::kBlockVolume>;

/// Computes the costs of cells from the states of voxels, one block at a time: it grows obstacles by the safety
/// distance, applies the policy for unknown cells and adds a cost for low clearance. Distances are measured from a
/// cell's centre to the nearest face of an occupied voxel, so a path that cuts no corner keeps the safety distance all
/// along its edges.
class CellCosts {
 public:
  /// @param view   map, which must outlive this object
  /// @param start  start of the path, near which unknown_policy and known_distance_m have other rules
  CellCosts(const OccupancyView& view, const AStarConfig& config, const geometry::Vec3& start);

  void compute(const geometry::Index3& block, CostBlock* out);
  /// Returns the state of a voxel in the view, read through a cache of blocks.
  VoxelState state(const geometry::Index3& voxel);
  bool is_inside(const geometry::Index3& voxel) const;
  /// Returns whether a point [m] violates a fence of the view.
  bool is_fenced(const geometry::Vec3& point) const;
  bool is_fenced(const geometry::Index3& voxel) const { return is_fenced(geometry::center_of(voxel, resolution_m_)); }
  std::size_t memory_bytes() const { return states_.size() * (sizeof(StateBlock) + 64); }

 private:
  /// Squared distances [voxels] of a block's cells to the nearest voxel of one state, cut off beyond the radius.
  using Distances = std::array<float, geometry::kBlockVolume>;

  const StateBlock* states_of(const geometry::Index3& block);
  template <class Select>
  bool distances(const geometry::Index3& block, Select select, Distances* out);
  CellCost cost_of(const geometry::Index3& voxel, VoxelState state, bool is_near_occupied, float distance_sq) const;
  bool is_near_start(const geometry::Index3& voxel) const;
  bool touches_start_range(const geometry::Index3& block) const;
  CellCost unknown_cost(const geometry::Index3& voxel) const;

  const OccupancyView& view_;
  AStarConfig config_;
  geometry::Vec3 start_;
  std::shared_ptr<const Fences> fences_;
  double resolution_m_;
  geometry::Index3 lowest_;  ///< lowest and highest voxel inside the view's box
  geometry::Index3 highest_;
  float safety_sq_;  ///< squared safety distance [voxels]; the two below are distances in voxels
  double safety_;
  double clearance_;
  float known_sq_ = 0.0F;       ///< squared known_distance_m [voxels]; 0 = the rule is off
  int radius_;                  ///< radius of the distance transform [voxels]
  std::vector<float> weights_;  ///< squared distance to a voxel's face by offset on an axis
  std::vector<float> pass_a_, pass_b_;
  std::unordered_map<geometry::Index3, StateBlock, geometry::Index3Hash> states_;
};

}  // namespace voxnav::planning
