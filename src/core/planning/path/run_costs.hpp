// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "planning/cell_costs.hpp"
#include "planning/clearance/clearance_field_impl.hpp"
#include "voxnav/planning/path_planner.hpp"

namespace voxnav::planning {

/// Cells on top of each other at equal cost, in one column.
struct CellRun {
  std::int32_t low;
  std::int32_t high;
  CellCost cost;  ///< never 0
};

/// Costs of cells by the distances of a field, as CellCosts has them by the states of voxels.
class RunCosts {
 public:
  /// @throws std::invalid_argument if the field keeps too small a radius
  RunCosts(const ClearanceField& field, const PathPlannerConfig& config, const geometry::Vec3& start);

  /// Calls fn(run) for the runs of column (x, y) in blocks of the heights of the bounds, lowest first. `tower` holds
  /// the blocks of that column from `lowest_block` on, null where the field has none.
  template <class Fn>
  void for_each_run_of(const std::vector<const ClearanceBlock*>& tower, int x, int y, Fn fn) const;

  int lowest_block() const { return field_.bounds().low.z >> geometry::kBlockShift; }
  int highest_block() const { return field_.bounds().high.z >> geometry::kBlockShift; }
  const ClearanceField::Impl& field() const { return field_; }
  /// Cost of a cell that may not be entered only because its centre is nearer than the safety distance: a path may lead
  /// through the rest of it. 0 for all other cells.
  CellCost gap_cost(const geometry::Index3& voxel) const;
  bool has_unit_costs() const { return has_unit_costs_; }

 private:
  CellCost cost_of(const ClearanceBlock* block, const geometry::Index3& voxel) const;
  std::uint16_t enterable(const ClearanceBlock* block, const geometry::Index3& lowest) const;
  bool is_near_start(const geometry::Index3& voxel) const;
  bool touches_start_range(const geometry::Index3& block) const;

  const ClearanceField::Impl& field_;
  PathPlannerConfig config_;
  geometry::Vec3 start_;
  bool has_start_rules_;
  bool has_unit_costs_;
  double known_squared_ = 0.0;  ///< known_distance_m as squared distances are kept; 0 = the rule is off
  CellCost unknown_cost_;
  CellCost dearest_ = kUnitCost;
  std::vector<CellCost> extra_;  ///< cost of nearness by squared distance
};

template <class Fn>
void RunCosts::for_each_run_of(const std::vector<const ClearanceBlock*>& tower, int x, int y, Fn fn) const {
  constexpr int kSide = geometry::kBlockSide;
  CellRun run{0, -1, 0};
  const auto add = [&](int low, int high, CellCost cost) {
    if (run.cost == cost && run.high + 1 == low) {
      run.high = high;
      return;
    }
    if (run.cost != 0) fn(run);
    run = {low, high, cost};
  };
  for (std::size_t i = 0; i < tower.size(); ++i) {
    const ClearanceBlock* block = tower[i];
    const geometry::Index3 lowest{x, y, (lowest_block() + static_cast<int>(i)) * kSide};
    const std::uint16_t bits = enterable(block, lowest);
    if (bits == 0) continue;
    const bool is_plain = block != nullptr && (extra_.empty() || block->to_occupied == nullptr) &&
                          !(has_start_rules_ && touches_start_range(geometry::block_of(lowest))) &&
                          (block->unknown[column_at(x & (kSide - 1), y & (kSide - 1))] & bits) == 0;
    for_each_run(bits, [&](int low, int high) {
      if (is_plain) return add(lowest.z + low, lowest.z + high, kUnitCost);
      for (int z = low; z <= high; ++z) {
        const geometry::Index3 voxel{x, y, lowest.z + z};
        add(voxel.z, voxel.z, cost_of(block, voxel));
      }
    });
  }
  if (run.cost != 0) fn(run);
}

}  // namespace voxnav::planning
