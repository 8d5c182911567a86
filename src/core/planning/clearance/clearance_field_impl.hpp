// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "planning/clearance/clearance_blocks.hpp"
#include "voxnav/planning/clearance_field.hpp"
#include "voxnav/planning/fences.hpp"

namespace voxnav::planning {

/// The field as the planner reads it.
class ClearanceField::Impl {
 public:
  explicit Impl(const ClearanceFieldConfig& config) : config_(config) {}

  const ClearanceFieldConfig& config() const { return config_; }
  double resolution_m() const { return resolution_m_; }
  const ClearanceBlocks& blocks() const { return blocks_; }
  const VoxelBox& bounds() const { return bounds_; }
  /// The radius up to which distances to occupied voxels are kept, in voxels. Precondition: there was an update.
  double radius_voxels() const { return std::min(config_.radius_m / resolution_m_, 1.0 * kMaxReach); }
  /// The radius up to which distances to unknown voxels are kept.
  double unknown_radius_m() const { return std::max(config_.unknown_radius_m, config_.safety_distance_m); }
  /// The distance to be kept from the view's occupied voxels, which the view may have grown already.
  double clearance_m() const { return std::max(0.0, config_.safety_distance_m - grown_by_m_); }
  /// The block that holds a voxel; null if the field has none, and all of it is unknown, far from obstacles.
  const ClearanceBlock* block_of(const geometry::Index3& voxel) const;
  VoxelState state(const geometry::Index3& voxel) const;
  /// Returns whether a point [m] violates a fence of the view.
  bool is_fenced(const geometry::Vec3& point) const { return fences_ != nullptr && fences_->contact(point, 0.0); }
  std::uint32_t component(const geometry::Index3& voxel) const;
  /// Calls fn(box) for each run of occupied, or of unknown voxels in a column that touches a box of voxels, cut to that
  /// box.
  template <class Fn>
  void for_each_occupied(const VoxelBox& box, Fn fn) const {
    for_each_run_in(box, &ClearanceBlock::occupied, 0, fn);
  }
  template <class Fn>
  void for_each_unknown(const VoxelBox& box, Fn fn) const {
    for_each_run_in(box, &ClearanceBlock::unknown, kWholeColumn, fn);
  }
  std::size_t memory_bytes() const;

  ClearanceUpdate update(const OccupancyView& view, const std::vector<geometry::Index3>& candidates);
  /// The blocks that the field or a view may hold.
  std::vector<geometry::Index3> candidates(const OccupancyView& view) const;

 private:
  friend class FieldUpdate;

  /// @param absent  columns of blocks that the field does not hold
  template <class Fn>
  void for_each_run_in(const VoxelBox& box, BlockColumns ClearanceBlock::*kind, std::uint16_t absent, Fn fn) const;
  /// Numbers the connected parts of the whole field. O(parts and their contacts).
  void label_components();

  ClearanceFieldConfig config_;
  double resolution_m_ = 0.0;
  double grown_by_m_ = 0.0;
  VoxelBox bounds_;
  std::shared_ptr<const Fences> fences_;
  ClearanceBlocks blocks_;
  std::optional<SquaredDistanceTransform> occupied_transform_;
  std::optional<SquaredDistanceTransform> unknown_transform_;
  std::vector<std::uint32_t> labels_;  ///< of each part; the first one is what lies outside all blocks
};

template <class Fn>
void ClearanceField::Impl::for_each_run_in(const VoxelBox& box, BlockColumns ClearanceBlock::*kind,
                                           std::uint16_t absent, Fn fn) const {
  const geometry::Index3 low = geometry::block_of(box.low), high = geometry::block_of(box.high);
  for (int bz = low.z; bz <= high.z; ++bz) {
    for (int by = low.y; by <= high.y; ++by) {
      for (int bx = low.x; bx <= high.x; ++bx) {
        const geometry::Index3 index{bx, by, bz};
        const std::int32_t slot = blocks_.find(index);
        if (slot == ClearanceBlock::kNoSlot && absent == 0) continue;
        const BlockColumns* columns = slot == ClearanceBlock::kNoSlot ? nullptr : &(blocks_.at(slot).*kind);
        const VoxelBox part = part_in(box, index);
        const geometry::Index3 first = geometry::voxel_at(index, 0);
        const std::uint32_t heights = ((2u << part.high.z) - 1u) & ~((1u << part.low.z) - 1u);
        for (int y = part.low.y; y <= part.high.y; ++y) {
          for (int x = part.low.x; x <= part.high.x; ++x) {
            const std::uint32_t bits = (columns == nullptr ? absent : (*columns)[column_at(x, y)]) & heights;
            for_each_run(bits, [&](int z0, int z1) {
              fn(VoxelBox{first + geometry::Index3{x, y, z0}, first + geometry::Index3{x, y, z1}});
            });
          }
        }
      }
    }
  }
}

}  // namespace voxnav::planning
