// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/planning/corridor.hpp"

#include <algorithm>
#include <cmath>

#include "planning/segment_box.hpp"

namespace voxnav::planning {
namespace {

using geometry::Index3;
using geometry::Vec3;

/// Longer segments are split, since the box around a long slanted segment holds many voxels far from it.
constexpr double kMaxPieceInRadii = 2.0;

/// Reads single voxels through a cache of one block: corridors are local, so the next voxel nearly always lies in it.
class BlockReader {
 public:
  explicit BlockReader(const OccupancyView& view) : view_(view) {}

  VoxelState state(const Index3& voxel) {
    const Index3 index = geometry::block_of(voxel);
    Slot& slot = slots_[(index.x & 1) | ((index.y & 1) << 1) | ((index.z & 1) << 2)];
    if (!slot.is_used || slot.index != index) {
      slot.index = index;
      slot.is_used = true;
      slot.states = view_.block(index, &slot.scratch);
    }
    return slot.states == nullptr ? VoxelState::kUnknown : slot.states->get(geometry::offset_in_block(voxel));
  }

 private:
  struct Slot {
    bool is_used = false;
    Index3 index;
    const StateBlock* states = nullptr;
    StateBlock scratch;
  };
  const OccupancyView& view_;
  std::array<Slot, 8> slots_;
};

struct Touch {
  double t = 2.0;  ///< parameter on the segment from 0 to 1; above 1 = no touch
  VoxelState state = VoxelState::kFree;
  Vec3 center;
};

class PieceChecker {
 public:
  PieceChecker(const OccupancyView& view, double radius_m, CorridorRule rule)
      : reader_(view), resolution_m_(view.resolution_m()), radius_m_(radius_m), rule_(rule) {}

  Touch first_touch(const Segment& piece) {
    Touch first;
    geometry::Aabb box;
    box.extend(piece.a);
    box.extend(piece.b);
    const Index3 low = geometry::index_of(box.min.array() - radius_m_, resolution_m_);
    const Index3 high = geometry::index_of(box.max.array() + radius_m_, resolution_m_);
    // The ball can only touch voxels whose centre is nearer than the radius and half the diagonal of a voxel.
    const double reach = radius_m_ + 0.5 * std::sqrt(3.0) * resolution_m_;
    const Vec3 direction = piece.b - piece.a;
    const double inverse_sq = direction.squaredNorm() > 0.0 ? 1.0 / direction.squaredNorm() : 0.0;
    for (int z = low.z; z <= high.z; ++z) {
      for (int y = low.y; y <= high.y; ++y) {
        for (int x = low.x; x <= high.x; ++x) {
          const Vec3 center = geometry::center_of({x, y, z}, resolution_m_);
          const Vec3 offset = center - piece.a;
          const double t = std::min(1.0, std::max(0.0, offset.dot(direction) * inverse_sq));
          if ((offset - t * direction).squaredNorm() >= reach * reach) continue;
          const VoxelState state = reader_.state({x, y, z});
          if (is_unsafe(state)) consider(piece, center, state, &first);
        }
      }
    }
    return first;
  }

 private:
  bool is_unsafe(VoxelState state) const {
    return rule_ == CorridorRule::kNotOccupied ? state == VoxelState::kOccupied : state != VoxelState::kFree;
  }

  void consider(const Segment& piece, const Vec3& center, VoxelState state, Touch* first) const {
    const Vec3 half = Vec3::Constant(0.5 * resolution_m_);
    const geometry::Aabb box{center - half, center + half};
    // If the segment up to the first known touch stays clear of this voxel, the voxel is not touched earlier.
    if (first->t <= 1.0 && squared_distance(Segment{piece.a, piece.at(first->t)}, box) >= radius_m_ * radius_m_) return;
    const double t = first_parameter_within(piece, box, radius_m_);
    if (t < 0.0 || t >= first->t) return;
    *first = {t, state, center};
  }

  BlockReader reader_;
  double resolution_m_;
  double radius_m_;
  CorridorRule rule_;
};

bool is_usable(const std::vector<Vec3>& points, double resolution_m) {
  const double limit = 1e9 * resolution_m;
  return !points.empty() &&
         std::all_of(points.begin(), points.end(), [&](const Vec3& p) { return (p.array().abs() < limit).all(); });
}

/// The first contact of a polyline with the fences of a view, as a result that is safe if there is none.
CorridorResult check_fences(const OccupancyView& view, const std::vector<Vec3>& points, double radius_m,
                            CorridorRule rule) {
  CorridorResult out;
  const auto fences = view.fences();
  if (fences == nullptr) return out;
  double arc_m = 0.0;
  for (std::size_t i = 0; i < std::max<std::size_t>(1, points.size() - 1); ++i) {
    const Segment piece{points[i], points[std::min(i + 1, points.size() - 1)]};
    const auto touch = rule == CorridorRule::kNotOccupied ? fences->first_zone_touch(piece.a, piece.b, radius_m)
                                                          : fences->first_touch(piece.a, piece.b, radius_m);
    if (touch) {
      out.is_safe = false;
      out.first_unsafe_m = arc_m + touch->t * piece.length();
      out.unsafe_point = piece.at(touch->t);
      out.unsafe_state = view.state(geometry::index_of(out.unsafe_point, view.resolution_m()));
      out.fence = touch->contact;
      return out;
    }
    arc_m += piece.length();
  }
  return out;
}

/// The first contact of a ball along a polyline with voxels, as a result that is safe if there is none.
CorridorResult check_voxels(const OccupancyView& view, const std::vector<Vec3>& points, double radius_m,
                            CorridorRule rule) {
  CorridorResult out;
  // With a radius of exactly zero no distance would be below it, not even that of the voxels that the line crosses.
  const double radius = std::max(radius_m, 1e-3 * view.resolution_m());
  const double max_piece_m = kMaxPieceInRadii * std::max(radius, view.resolution_m());
  PieceChecker checker(view, radius, rule);
  double arc_m = 0.0;
  for (std::size_t i = 0; i < std::max<std::size_t>(1, points.size() - 1); ++i) {
    const Segment whole{points[i], points[std::min(i + 1, points.size() - 1)]};
    const int num_pieces = std::max(1, static_cast<int>(std::ceil(whole.length() / max_piece_m)));
    for (int k = 0; k < num_pieces; ++k) {
      const Segment piece{whole.at(static_cast<double>(k) / num_pieces), whole.at((k + 1.0) / num_pieces)};
      const Touch touch = checker.first_touch(piece);
      if (touch.t > 1.0) {
        arc_m += piece.length();
        continue;
      }
      out.is_safe = false;
      out.first_unsafe_m = arc_m + touch.t * piece.length();
      out.unsafe_state = touch.state;
      out.unsafe_point = touch.center;
      return out;
    }
  }
  return out;
}

}  // namespace

CorridorResult check_corridor(const OccupancyView& view, const std::vector<Vec3>& points, double radius_m,
                              CorridorRule rule) {
  CorridorResult out;
  out.is_safe = false;
  out.unsafe_state = VoxelState::kUnknown;
  if (!is_usable(points, view.resolution_m()) || !(radius_m >= 0.0)) return out;
  out = check_voxels(view, points, radius_m, rule);
  const CorridorResult fenced = check_fences(view, points, radius_m, rule);
  if (!fenced.is_safe && (out.is_safe || fenced.first_unsafe_m < out.first_unsafe_m)) out = fenced;
  for (std::size_t i = 1; i < points.size(); ++i) out.length_m += (points[i] - points[i - 1]).norm();
  return out;
}

const char* what_is_unsafe(const CorridorResult& corridor) {
  if (corridor.fence) return corridor.fence->kind == FenceKind::kArea ? "outside the safety area" : "in a no-fly zone";
  return corridor.unsafe_state == VoxelState::kOccupied ? "occupied" : "unknown";
}

}  // namespace voxnav::planning
