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

/// A block of a tower of blocks, with what holds for all of its columns.
struct TowerBlock {
  const ClearanceBlock* block;  ///< null where the field has none
  int lowest_z;
  bool touches_start_range;
  bool is_uniform;  ///< all of its known voxels cost the same
};

/// Costs of cells by the distances of a field, as CellCosts has them by the states of voxels.
class RunCosts {
 public:
  /// @throws std::invalid_argument if the field keeps too small a radius
  RunCosts(const ClearanceField& field, const PathPlannerConfig& config, const geometry::Vec3& start);

  /// Fills in the blocks of the heights of the bounds that hold column (x, y), lowest first.
  void find_tower(int x, int y, std::vector<TowerBlock>* tower) const;
  /// Calls fn(run) for the runs of column (x, y) in its tower, lowest first.
  template <class Fn>
  void for_each_run_of(const std::vector<TowerBlock>& tower, int x, int y, Fn fn) const;

  /// Whether all cells of a tower that may be entered are known and cost the same, and their heights fit one word: then
  /// plain_column() has its runs.
  bool is_plain(const std::vector<TowerBlock>& tower) const;
  /// The cells of a column that may be entered, the lowest height of the tower first.
  static std::uint64_t plain_column(const std::vector<TowerBlock>& tower, int column) {
    std::uint64_t out = 0;
    for (std::size_t i = 0; i < tower.size(); ++i) {
      const std::uint64_t bits = tower[i].block != nullptr ? tower[i].block->flyable[column] : std::uint16_t{0};
      out |= bits << (i * geometry::kBlockSide);
    }
    return out;
  }

  const ClearanceField::Impl& field() const { return field_; }
  /// Cost of a cell that may not be entered only because its centre is nearer than the safety distance: a path may lead
  /// through the rest of it. 0 for all other cells.
  CellCost gap_cost(const geometry::Index3& voxel) const;
  bool has_unit_costs() const { return has_unit_costs_; }

 private:
  CellCost cost_of(const ClearanceBlock* block, const geometry::Index3& voxel) const;
  std::uint16_t enterable(const TowerBlock& in, int x, int y) const {
    constexpr int kMask = geometry::kBlockSide - 1;
    if (!is_known_only_) return enterable_unknown(in, x, y);
    return in.block != nullptr ? in.block->flyable[column_at(x & kMask, y & kMask)] : std::uint16_t{0};
  }
  std::uint16_t enterable_unknown(const TowerBlock& in, int x, int y) const;
  /// The highest cell of a column, up to `high`, up to which all cost as much as the one at `low`.
  int last_alike(const TowerBlock& in, int column, int low, int high) const;
  bool is_near_start(const geometry::Index3& voxel) const;
  bool touches_start_range(const geometry::Index3& block) const;

  const ClearanceField::Impl& field_;
  PathPlannerConfig config_;
  geometry::Vec3 start_;
  bool has_start_rules_;
  bool is_known_only_;  ///< unknown cells may not be entered
  bool has_unit_costs_;
  double known_squared_ = 0.0;  ///< known_distance_m as squared distances are kept; 0 = the rule is off
  CellCost unknown_cost_;
  CellCost dearest_ = kUnitCost;
  std::vector<CellCost> extra_;  ///< cost of nearness by squared distance
};

template <class Fn>
void RunCosts::for_each_run_of(const std::vector<TowerBlock>& tower, int x, int y, Fn fn) const {
  constexpr int kMask = geometry::kBlockSide - 1;
  CellRun run{0, -1, 0};
  const auto add = [&](int low, int high, CellCost cost) {
    if (run.cost == cost && run.high + 1 == low) {
      run.high = high;
      return;
    }
    if (run.cost != 0) fn(run);
    run = {low, high, cost};
  };
  const int column = column_at(x & kMask, y & kMask);
  for (const TowerBlock& in : tower) {
    const std::uint16_t bits = enterable(in, x, y);
    if (bits == 0) continue;
    const bool is_plain = in.is_uniform && (in.block->unknown[column] & bits) == 0;
    for_each_run(bits, [&](int low, int high) {
      if (is_plain) return add(in.lowest_z + low, in.lowest_z + high, kUnitCost);
      for (int end = low; low <= high; low = end + 1) {
        end = last_alike(in, column, low, high);
        add(in.lowest_z + low, in.lowest_z + end, cost_of(in.block, {x, y, in.lowest_z + low}));
      }
    });
  }
  if (run.cost != 0) fn(run);
}

}  // namespace voxnav::planning
