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

geometry::Index3 index_at(const Vec3& p) {
  const auto floor_of = [](double value) {
    const int truncated = static_cast<int>(value);
    return truncated - (value < truncated ? 1 : 0);
  };
  return {floor_of(p.x()), floor_of(p.y()), floor_of(p.z())};
}

/// The gap between a range and a voxel on one axis, 0 if they overlap.
double gap(double least, double most, int voxel) { return std::max({least - (voxel + 1), voxel - most, 0.0}); }

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
  return all_pieces(from, to,
                    [this](const Vec3& a, const Vec3& b) { return is_piece_clear(a, b, 0.5 * (b - a).norm()); });
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
  const ClearanceBlock* block = block_at(geometry::block_of(voxel));
  // Blocks that the field does not hold are far from obstacles.
  if (block == nullptr || block->to_occupied == nullptr) return {radius_, false};
  const int offset = geometry::offset_in_block(voxel);
  const int squared = (*block->to_occupied)[geometry::kBlockSide * (offset % kColumns) + offset / kColumns];
  const double distance = 0.5 * std::sqrt(static_cast<double>(squared));
  if (distance < radius_) return {distance, true};
  return {radius_, false};
}

/// The distance at the middle decides most pieces, since it changes by no more than the way that one goes; what it
/// leaves open is halved, and compared with the obstacles themselves when it is short.
/// @param half  half of its length
bool SegmentClearance::is_piece_clear(const Vec3& from, const Vec3& to, double half) const {
  const Vec3 middle = 0.5 * (from + to);
  const geometry::Index3 voxel = index_at(middle);
  const Room room = room_at(voxel);
  const double aside = (middle - geometry::center_of(voxel, 1.0)).norm();
  if (room.distance - aside - half >= distance_) return true;
  if (room.is_exact && room.distance + aside < distance_ - kTolerance) return false;
  if (half > kShortestHalf) {
    return is_piece_clear(from, middle, 0.5 * half) && is_piece_clear(middle, to, 0.5 * half);
  }
  return is_exactly_clear(from, to);
}

bool SegmentClearance::is_exactly_clear(const Vec3& from, const Vec3& to) const {
  const Vec3 reach = Vec3::Constant(distance_);
  const VoxelBox near{index_at(from.cwiseMin(to) - reach), index_at(from.cwiseMax(to) + reach)};
  const geometry::Index3 low = geometry::block_of(near.low), high = geometry::block_of(near.high);
  for (int z = low.z; z <= high.z; ++z) {
    for (int y = low.y; y <= high.y; ++y) {
      for (int x = low.x; x <= high.x; ++x) {
        const ClearanceBlock* block = block_at({x, y, z});
        if (block != nullptr && !is_clear_in(*block, part_in(near, {x, y, z}), {from, to})) return false;
      }
    }
  }
  return true;
}

/// Whether a piece is clear of the occupied voxels of a part of a block.
bool SegmentClearance::is_clear_in(const ClearanceBlock& block, const VoxelBox& part, const Piece& piece) const {
  const geometry::Index3 first = geometry::voxel_at(block.index, 0);
  const Vec3 least = piece.from.cwiseMin(piece.to), most = piece.from.cwiseMax(piece.to);
  const std::uint32_t heights = ((2u << part.high.z) - 1u) & ~((1u << part.low.z) - 1u);
  bool is_clear = true;
  const std::uint32_t width = ((2u << part.high.x) - 1u) & ~((1u << part.low.x) - 1u);
  for (int y = part.low.y; y <= part.high.y; ++y) {
    const double across = gap(least.y(), most.y(), first.y + y);
    for (std::uint32_t row = block.occupied_rows[y] & width; row != 0; row &= row - 1) {
      const int x = __builtin_ctz(row);
      const std::uint32_t bits = block.occupied[column_at(x, y)] & heights;
      const double along = gap(least.x(), most.x(), first.x + x);
      if (along * along + across * across >= distance_ * distance_) continue;
      for_each_run(bits, [&](int z0, int z1) {
        const VoxelBox run{first + geometry::Index3{x, y, z0}, first + geometry::Index3{x, y, z1}};
        is_clear = is_clear && !is_nearer(piece.from, piece.to, box_of(run), distance_ - kTolerance);
      });
      if (!is_clear) return false;
    }
  }
  return true;
}

}  // namespace voxnav::planning
