// SPDX-License-Identifier: BSD-3-Clause
#include "planning/path/segment_clearance.hpp"

#include <algorithm>
#include <cmath>

#include "planning/segment_box.hpp"

namespace voxnav::planning {
namespace {

using geometry::Vec3;

constexpr double kPieceLength = 4.0;
/// Rounding must not turn a segment at exactly the distance into one that is too near.
constexpr double kTolerance = 1e-7;
/// Pieces of which the half is no longer than this are not halved again.
constexpr double kShortestHalf = 0.5;

Vec3 excess(const Vec3& point, const geometry::Aabb& box) { return point - point.cwiseMax(box.min).cwiseMin(box.max); }

geometry::Aabb box_of(const VoxelBox& run) {
  return {Vec3(run.low.x, run.low.y, run.low.z), Vec3(run.high.x + 1, run.high.y + 1, run.high.z + 1)};
}

/// Whether all pieces of a segment are as `is_good` wants them.
template <class Fn>
bool all_pieces(const Vec3& from, const Vec3& to, Fn is_good) {
  const int num_pieces = std::max(1, static_cast<int>(std::ceil((to - from).norm() / kPieceLength)));
  for (int i = 0; i < num_pieces; ++i) {
    const Vec3 a = from + (to - from) * (static_cast<double>(i) / num_pieces);
    const Vec3 b = from + (to - from) * (static_cast<double>(i + 1) / num_pieces);
    if (!is_good(a, b)) return false;
  }
  return true;
}

}  // namespace

bool is_nearer(const Vec3& from, const Vec3& to, const geometry::Aabb& box, double distance) {
  const Vec3 direction = to - from;
  const double limit = distance * distance;
  const auto slope = [&](double t) { return excess(from + t * direction, box).dot(direction); };
  const auto is_near = [&](double t) { return excess(from + t * direction, box).squaredNorm() < limit; };
  if (slope(0.0) >= 0.0) return is_near(0.0);
  if (slope(1.0) <= 0.0) return is_near(1.0);
  // The slope grows linearly between the parameters at which the segment crosses planes of the box.
  double low = 0.0, high = 1.0;
  for (int axis = 0; axis < 3; ++axis) {
    if (direction[axis] == 0.0) continue;
    for (const double face : {box.min[axis], box.max[axis]}) {
      const double t = (face - from[axis]) / direction[axis];
      if (t > low && t < high) (slope(t) < 0.0 ? low : high) = t;
    }
  }
  const double a = slope(low), b = slope(high);
  return is_near(b > a ? low + (high - low) * (-a) / (b - a) : low);
}

bool SegmentClearance::is_clear(const Vec3& from, const Vec3& to) const {
  ++num_checks_;
  if (distance_ <= 0.0) return true;
  return all_pieces(from, to, [this](const Vec3& a, const Vec3& b) { return is_piece_clear(a, b); });
}

bool SegmentClearance::is_known(const Vec3& from, const Vec3& to) const {
  if (known_.distance <= 0.0) return true;
  return all_pieces(from, to, [this](const Vec3& a, const Vec3& b) { return is_piece_known(a, b); });
}

bool SegmentClearance::is_piece_known(const Vec3& from, const Vec3& to) const {
  const geometry::Aabb ball{known_.center, known_.center};
  if (!is_nearer(from, to, ball, known_.radius)) return true;
  const Vec3 reach = Vec3::Constant(known_.distance);
  const VoxelBox near{geometry::index_of(from.cwiseMin(to) - reach, 1.0),
                      geometry::index_of(from.cwiseMax(to) + reach, 1.0)};
  bool is_known = true;
  field_.for_each_unknown(near, [&](const VoxelBox& run) {
    is_known = is_known && !is_nearer(from, to, box_of(run), known_.distance - kTolerance);
  });
  return is_known;
}

SegmentClearance::Room SegmentClearance::room_at(const geometry::Index3& voxel) const {
  const geometry::Index3 index = geometry::block_of(voxel);
  if (!has_last_block_ || index != last_index_) {
    last_block_ = field_.block_of(voxel);
    last_index_ = index;
    has_last_block_ = true;
  }
  // Blocks that the field does not hold are far from obstacles.
  if (last_block_ == nullptr || last_block_->to_occupied == nullptr) return {field_.radius_voxels(), false};
  const int offset = geometry::offset_in_block(voxel);
  const int squared = (*last_block_->to_occupied)[geometry::kBlockSide * (offset % kColumns) + offset / kColumns];
  const double distance = 0.5 * std::sqrt(static_cast<double>(squared));
  if (distance < field_.radius_voxels()) return {distance, true};
  return {field_.radius_voxels(), false};
}

/// The distance at the middle decides most pieces, since it changes by no more than the way that one goes; what it
/// leaves open is halved, and compared with the obstacles themselves when it is short.
bool SegmentClearance::is_piece_clear(const Vec3& from, const Vec3& to) const {
  const Vec3 middle = 0.5 * (from + to);
  const geometry::Index3 voxel = geometry::index_of(middle, 1.0);
  const Room room = room_at(voxel);
  const double aside = (middle - geometry::center_of(voxel, 1.0)).norm(), half = 0.5 * (to - from).norm();
  if (room.distance - aside - half >= distance_) return true;
  if (room.is_exact && room.distance + aside < distance_ - kTolerance) return false;
  if (half > kShortestHalf) return is_piece_clear(from, middle) && is_piece_clear(middle, to);
  const Vec3 reach = Vec3::Constant(distance_);
  const VoxelBox near{geometry::index_of(from.cwiseMin(to) - reach, 1.0),
                      geometry::index_of(from.cwiseMax(to) + reach, 1.0)};
  bool is_clear = true;
  field_.for_each_occupied(near, [&](const VoxelBox& run) {
    is_clear = is_clear && !is_nearer(from, to, box_of(run), distance_ - kTolerance);
  });
  return is_clear;
}

}  // namespace voxnav::planning
