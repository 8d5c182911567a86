// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <set>

#include "planning/clearance/clearance_field_impl.hpp"

namespace voxnav::planning {

/// One update of a clearance field: notes which columns of which blocks each change can reach, then computes those
/// again, in the order of the blocks' indices.
class FieldUpdate {
 public:
  FieldUpdate(ClearanceField::Impl* field, const OccupancyView& view) : field_(*field), view_(view) {}

  ClearanceUpdate run(const std::vector<geometry::Index3>& candidates);

 private:
  /// What has to be computed again in a block.
  struct Work {
    ColumnRange to_occupied;
    ColumnRange to_unknown;
    ColumnRange flyable;
  };
  /// Columns and heights of a block in which voxels of one kind have changed.
  struct Change {
    ColumnRange columns;
    int low = 0;
    int high = 0;
  };

  void read_bounds();
  void read_block(const geometry::Index3& index);
  bool read_forbidden(const geometry::Index3& index, BlockColumns* hard, BlockColumns* soft) const;
  void forbid(ClearanceBlock* block, const BlockColumns& hard, const BlockColumns& soft);
  void insert_near_obstacles(const VoxelBox& old_bounds);
  std::int32_t insert(const geometry::Index3& index);
  static Change change_of(const BlockColumns& before, const BlockColumns& after);
  void spread(const geometry::Index3& index, const Change& change, ColumnRange Work::*kind);
  void check_memory() const;
  bool recompute(const geometry::Index3& index, const Work& work);
  void recompute_distances(ClearanceBlock* block, const Work& work);
  bool recompute_flyable(ClearanceBlock* block, const ColumnRange& range);
  bool drop_if_blank(const geometry::Index3& index);
  void label_again(const std::set<geometry::Index3>& touched);
  void meet_neighbours(std::int32_t slot);

  ClearanceField::Impl& field_;
  const OccupancyView& view_;
  ClearanceUpdate result_;
  std::map<geometry::Index3, Work> work_;
  bool has_new_bounds_ = false;
};

}  // namespace voxnav::planning
