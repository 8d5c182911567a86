// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <limits>

#include "planning/clearance/clearance_field_impl.hpp"

namespace voxnav::planning {

/// A ball around the start in which shortcuts keep a distance from unknown voxels, because what is flown next needs
/// known space around it. A distance of 0 asks for nothing.
struct KnownBall {
  geometry::Vec3 center = geometry::Vec3::Zero();
  double radius = 0.0;
  double distance = 0.0;
};

/// Whether segments keep a distance from all occupied voxels, exactly. Positions and distances are in voxel edges.
class SegmentClearance {
 public:
  SegmentClearance(const ClearanceField::Impl& field, double distance, const KnownBall& known = {})
      : field_(field), distance_(distance), radius_(field.radius_voxels()), known_(known) {}

  /// O(length * distance^2) at worst; parts that lie far from obstacles by the field's distances cost nothing more.
  bool is_clear(const geometry::Vec3& from, const geometry::Vec3& to) const;
  /// Whether the pieces of a segment that touch the ball keep its distance from all unknown voxels. O(length in the
  /// ball
  /// * distance^2).
  bool is_known(const geometry::Vec3& from, const geometry::Vec3& to) const;
  std::uint64_t num_checks() const { return num_checks_; }

 private:
  /// The distance from a voxel's centre to the nearest obstacle, or the least that it may be.
  struct Room {
    double distance;
    bool is_exact;
  };

  struct Piece {
    const geometry::Vec3& from;
    const geometry::Vec3& to;
  };

  Room room_at(const geometry::Index3& voxel) const;
  bool is_piece_clear(const geometry::Vec3& from, const geometry::Vec3& to, double half) const;
  /// Compares a short piece with the obstacles themselves.
  bool is_exactly_clear(const geometry::Vec3& from, const geometry::Vec3& to) const;
  bool is_clear_in(const ClearanceBlock& block, const VoxelBox& part, const Piece& piece) const;
  bool is_piece_known(const geometry::Vec3& from, const geometry::Vec3& to) const;

  const ClearanceField::Impl& field_;
  double distance_;
  double radius_;  ///< up to which the field keeps distances
  KnownBall known_;
  mutable std::uint64_t num_checks_ = 0;
  /// Blocks that were asked for not long ago: most voxels lie in one of those around the piece before.
  struct Recent {
    geometry::Index3 index{std::numeric_limits<std::int32_t>::min(), 0, 0};
    const ClearanceBlock* block = nullptr;
  };
  const ClearanceBlock* block_at(const geometry::Index3& index) const {
    Recent& recent = recent_[(index.x & 1) + 2 * (index.y & 1) + 4 * (index.z & 1)];
    if (recent.index != index) recent = {index, field_.block_of(geometry::voxel_at(index, 0))};
    return recent.block;
  }
  mutable std::array<Recent, 8> recent_;
};

/// Returns whether a segment comes nearer to a box than `distance`. The squared distance is convex and piecewise
/// quadratic along the segment: its least value is found exactly between the planes of the box's faces.
bool is_nearer(const geometry::Vec3& from, const geometry::Vec3& to, const geometry::Aabb& box, double distance);

}  // namespace voxnav::planning
