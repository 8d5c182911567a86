// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "occupancy/local_map_impl.hpp"
#include "occupancy/octree_search.hpp"
#include "occupancy/segment_distance.hpp"

namespace voxnav::occupancy {
namespace {

using containers::VoxelState;

constexpr double kMaxCells = 5e8;
constexpr std::int64_t kMaxRaySteps = 1000000;

/// Ranks the states that a node contains by how bad they are for a vehicle: 0 free, 1 unknown, 2 occupied.
int badness(std::uint8_t flags) {
  if ((flags & kContainsOccupied) != 0) return 2;
  return (flags & kContainsUnknown) != 0 ? 1 : 0;
}

VoxelState state_of_badness(int badness) {
  constexpr VoxelState kStates[] = {VoxelState::kFree, VoxelState::kUnknown, VoxelState::kOccupied};
  return kStates[badness];
}

void require_finite(const geometry::Vec3& a, const geometry::Vec3& b, double resolution_m) {
  const double limit = kMaxCells * resolution_m;
  // Each coordinate is compared by itself, because the result of maxCoeff() with a NaN differs between versions of
  // Eigen.
  if (!(a.array().abs() < limit).all() || !(b.array().abs() < limit).all()) {
    throw std::invalid_argument("query points must be finite and within the grid");
  }
}

/// Octree visitor that finds the worst state along a corridor, and the first arc length at which the corridor touches
/// anything that is not free.
class CorridorSearch {
 public:
  CorridorSearch(const SegmentDistance& segment, double radius_m) : segment_(segment), radius_m_(radius_m) {}

  /// Returns true if anything below the node can still change the result.
  bool enter(const geometry::Vec3& center, double half_edge, std::uint8_t flags) {
    const int here = badness(flags);
    if (here == 0) return false;
    const double reach = radius_m_ + half_edge * std::sqrt(3.0);
    if (segment_.distance_to_point(center) > reach) return false;
    if (here > worst_) return true;
    return (segment_.nearest_ratio(center) * segment_.length() - reach) < first_bad_m_;
  }
  void leaf(const geometry::Vec3& center, double half_edge, std::uint8_t flags) {
    const double nearest = segment_.nearest_ratio(center, half_edge);
    if (segment_.distance_at(nearest, center, half_edge) > radius_m_) return;
    worst_ = std::max(worst_, badness(flags));
    first_bad_m_ =
        std::min(first_bad_m_, segment_.length() * segment_.first_touch(nearest, radius_m_, center, half_edge));
  }
  void starts_in_unknown() {
    worst_ = std::max(worst_, 1);
    first_bad_m_ = 0.0;
  }
  CorridorState result() const {
    CorridorState out;
    out.worst = state_of_badness(worst_);
    if (worst_ > 0) out.first_bad_m = first_bad_m_;
    return out;
  }

 private:
  SegmentDistance segment_;
  double radius_m_;
  int worst_ = 0;
  double first_bad_m_ = std::numeric_limits<double>::infinity();
};

class BoxSearch {
 public:
  explicit BoxSearch(const geometry::Aabb& box) : box_(box) {}
  bool enter(const geometry::Vec3& center, double half_edge, std::uint8_t flags) const {
    return badness(flags) > worst_ && box_.intersects({center.array() - half_edge, center.array() + half_edge});
  }
  void leaf(const geometry::Vec3&, double, std::uint8_t flags) { worst_ = std::max(worst_, badness(flags)); }
  VoxelState result() const { return state_of_badness(worst_); }

 private:
  geometry::Aabb box_;
  int worst_ = 0;
};

class NearestSearch {
 public:
  NearestSearch(const geometry::Vec3& point, double max_distance_m) : point_(point), best_m_(max_distance_m) {}
  bool enter(const geometry::Vec3& center, double half_edge, std::uint8_t flags) const {
    if ((flags & kContainsOccupied) == 0) return false;
    const geometry::Vec3 d = ((point_ - center).cwiseAbs().array() - half_edge).max(0.0);
    return d.norm() <= best_m_;
  }
  void surface(const geometry::Vec3& surface_point) {
    const double distance_m = (surface_point - point_).norm();
    if (distance_m > best_m_ || (found_ && distance_m == best_m_)) return;
    best_m_ = distance_m;
    found_ = NearestHit{surface_point, distance_m};
  }
  const std::optional<NearestHit>& result() const { return found_; }

 private:
  geometry::Vec3 point_;
  double best_m_;
  std::optional<NearestHit> found_;
};

}  // namespace

VoxelState LocalMap::state(const geometry::Vec3& point) const {
  const OctreeForest& forest = impl_->forest;
  if (!((point.array().abs() / forest.resolution_m) < kMaxCells).all()) return VoxelState::kUnknown;
  const geometry::Index3 voxel = geometry::index_of(point, forest.resolution_m);
  const OctreeBlock* block = forest.window.find(geometry::block_of(voxel));
  return block ? forest.levels.of(block->log_odds[geometry::offset_in_block(voxel)]) : VoxelState::kUnknown;
}

std::optional<double> LocalMap::log_odds(const geometry::Vec3& point) const {
  const OctreeForest& forest = impl_->forest;
  if (!((point.array().abs() / forest.resolution_m) < kMaxCells).all()) return std::nullopt;
  const geometry::Index3 voxel = geometry::index_of(point, forest.resolution_m);
  const OctreeBlock* block = forest.window.find(geometry::block_of(voxel));
  if (block == nullptr) return std::nullopt;
  return forest.scale.log_odds(block->log_odds[geometry::offset_in_block(voxel)]);
}

VoxelState LocalMap::box_state(const geometry::Aabb& box) const {
  const OctreeForest& forest = impl_->forest;
  require_finite(box.min, box.max, forest.resolution_m);
  if (box.empty()) throw std::invalid_argument("the box is empty");
  BoxSearch search(box);
  search_octree(forest, box, &search);
  const bool all_inside = forest.contains(box.min) && forest.contains(box.max);
  return all_inside || search.result() == VoxelState::kOccupied ? search.result() : VoxelState::kUnknown;
}

CorridorState LocalMap::corridor_state(const geometry::Vec3& a, const geometry::Vec3& b, double radius_m) const {
  const OctreeForest& forest = impl_->forest;
  require_finite(a, b, forest.resolution_m);
  if (!(radius_m >= 0.0) || !std::isfinite(radius_m))
    throw std::invalid_argument("radius_m must be finite and not negative");
  geometry::Aabb box;
  box.extend(a);
  box.extend(b);
  CorridorSearch search(SegmentDistance(a, b), radius_m);
  search_octree(forest, box.padded(radius_m), &search);
  if (!forest.contains(a)) search.starts_in_unknown();
  return search.result();
}

std::optional<NearestHit> LocalMap::nearest_occupied(const geometry::Vec3& point, double max_distance_m) const {
  const OctreeForest& forest = impl_->forest;
  require_finite(point, point, forest.resolution_m);
  if (!(max_distance_m >= 0.0) || !std::isfinite(max_distance_m))
    throw std::invalid_argument("max_distance_m must be finite");
  NearestSearch search(point, max_distance_m);
  geometry::Aabb box;
  box.extend(point);
  search_surface(forest, box.padded(max_distance_m), &search);
  return search.result();
}

RayCast LocalMap::ray_cast(const geometry::Vec3& a, const geometry::Vec3& b, bool pass_unknown) const {
  const OctreeForest& forest = impl_->forest;
  require_finite(a, b, forest.resolution_m);
  const double length = (b - a).norm();
  const double v = forest.resolution_m;
  geometry::Index3 cell = geometry::index_of(a, v);
  const geometry::Index3 last = geometry::index_of(b, v);
  int* coordinates[3] = {&cell.x, &cell.y, &cell.z};
  const std::int64_t steps = std::abs(std::int64_t{last.x} - cell.x) + std::abs(std::int64_t{last.y} - cell.y) +
                             std::abs(std::int64_t{last.z} - cell.z);
  if (steps > kMaxRaySteps) throw std::invalid_argument("the ray is too long");
  geometry::Vec3 next;
  for (int axis = 0; axis < 3; ++axis) {
    const double d = b[axis] - a[axis];
    next[axis] = d == 0.0 ? std::numeric_limits<double>::infinity()
                          : ((*coordinates[axis] + (d > 0.0 ? 1 : 0)) * v - a[axis]) / d;
  }
  double entered = 0.0;
  for (std::int64_t i = 0; i <= steps; ++i) {
    const VoxelState here = state(geometry::center_of(cell, v));
    if (here == VoxelState::kOccupied || (here == VoxelState::kUnknown && !pass_unknown))
      return {here, entered * length};
    int axis = 0;
    next.minCoeff(&axis);
    entered = std::min(1.0, next[axis]);
    *coordinates[axis] += b[axis] > a[axis] ? 1 : -1;
    next[axis] += v / std::abs(b[axis] - a[axis]);
  }
  return {VoxelState::kFree, length};
}

}  // namespace voxnav::occupancy
