// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/point_map.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numeric>

namespace voxnav::odometry {
namespace {

constexpr int kMinNeighbours = 6;
constexpr std::uint16_t kMaxRefitInterval = 32;
/// Ratios of the spread (variance) of a neighbourhood along its axes.
constexpr float kMaxPlaneThickness = 0.1F;  // smallest over middle
constexpr float kMinPlaneWidth = 0.05F;     // middle over largest: points of a single sensor ring span no plane
constexpr float kMaxLineThickness = 0.15F;  // middle over largest
constexpr float kMinLineUprightness = 0.8F;

Vec3f center_of(VoxelKey key, float size) {
  constexpr VoxelKey kMask = (1u << 21) - 1;
  const auto cell = [](VoxelKey k) {
    return static_cast<float>(static_cast<std::int32_t>(k & kMask) - (1 << 20)) + 0.5F;
  };
  return Vec3f(cell(key >> 42), cell(key >> 21), cell(key)) * size;
}

/// The cells, between two corners, that a sphere around a point may reach.
struct CellRange {
  std::int32_t low[3], high[3];
  bool is_valid = true;
};

CellRange cells_around(const Vec3f& point, float radius, float inverse_size) {
  constexpr float kLimit = (1 << 20) - 4;
  CellRange out;
  for (int axis = 0; axis < 3; ++axis) {
    const float low = std::floor((point[axis] - radius) * inverse_size);
    const float high = std::floor((point[axis] + radius) * inverse_size);
    if (!(low > -kLimit && high < kLimit)) {
      out.is_valid = false;
      return out;
    }
    const auto own = static_cast<std::int32_t>(std::floor(point[axis] * inverse_size));
    out.low[axis] = std::max(static_cast<std::int32_t>(low), own - 2) + (1 << 20);
    out.high[axis] = std::min(static_cast<std::int32_t>(high), own + 2) + (1 << 20);
  }
  return out;
}

template <class F>
void for_each_cell(const CellRange& range, F&& visit) {
  if (!range.is_valid) return;
  for (std::int32_t x = range.low[0]; x <= range.high[0]; ++x) {
    for (std::int32_t y = range.low[1]; y <= range.high[1]; ++y) {
      for (std::int32_t z = range.low[2]; z <= range.high[2]; ++z) {
        visit((static_cast<VoxelKey>(x) << 42) | (static_cast<VoxelKey>(y) << 21) | static_cast<VoxelKey>(z));
      }
    }
  }
}

struct Neighbourhood {
  int count = 0;
  Vec3f sum = Vec3f::Zero();
  Eigen::Matrix3f products = Eigen::Matrix3f::Zero();

  void add(const Vec3f& offset) {
    ++count;
    sum += offset;
    products += offset * offset.transpose();
  }
};

/// Decides what shape a neighbourhood has. Its offsets are relative to the point, since sums of squares far from zero
/// would lose the thickness of a plane to rounding.
void classify(const Neighbourhood& offsets, const Vec3f& sensor_up, MapPoint* point) {
  point->shape = Shape::kUnknown;
  if (offsets.count < kMinNeighbours) return;
  const Vec3f mean = offsets.sum / static_cast<float>(offsets.count);
  const Eigen::Matrix3f covariance = offsets.products / static_cast<float>(offsets.count) - mean * mean.transpose();
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f> solver;
  solver.computeDirect(covariance);
  const Vec3f spread = solver.eigenvalues();
  if (!spread.allFinite() || spread[2] <= 0.0F) return;
  if (spread[0] < kMaxPlaneThickness * spread[1] && spread[1] > kMinPlaneWidth * spread[2]) {
    point->shape = Shape::kPlane;
    point->direction = solver.eigenvectors().col(0);
    point->anchor = point->position + mean;
  } else if (spread[1] < kMaxLineThickness * spread[2] &&
             std::abs(solver.eigenvectors().col(2).dot(sensor_up)) > kMinLineUprightness) {
    point->shape = Shape::kLine;
    point->direction = solver.eigenvectors().col(2);
    point->anchor = point->position;
  }
}

}  // namespace

PointMap::PointMap(const PointMapOptions& options)
    : options_(options),
      capacity_(static_cast<std::uint32_t>(options.max_points_per_voxel)),
      inverse_size_(static_cast<float>(1.0 / options.voxel_size_m)),
      spacing_sq_(static_cast<float>(options.voxel_size_m * options.voxel_size_m / options.max_points_per_voxel)) {
  numbers_.reset(static_cast<std::size_t>(options.max_voxels) / 4);
}

void PointMap::clear() {
  numbers_.clear();
  voxels_.clear();
  points_.clear();
}

void PointMap::insert(const std::vector<Vec3f>& points_O) {
  for (const Vec3f& point : points_O) insert_point(point);
}

void PointMap::insert_point(const Vec3f& point) {
  const VoxelKey key = key_of(point, inverse_size_);
  if (key == kNoKey) return;
  const std::optional<std::uint32_t> found = find(key);
  std::uint32_t index = found ? *found : static_cast<std::uint32_t>(voxels_.size());
  if (!found) {
    if (voxels_.size() >= static_cast<std::size_t>(options_.max_voxels)) return;
    number(key, index);
    voxels_.push_back({key, 0});
    points_.resize(voxels_.size() * capacity_);
  }
  Voxel& voxel = voxels_[index];
  if (voxel.count >= capacity_) return;
  MapPoint* points = points_of(index);
  for (std::uint32_t i = 0; i < voxel.count; ++i) {
    if ((points[i].position - point).squaredNorm() < spacing_sq_) return;
  }
  points[voxel.count] = MapPoint();
  points[voxel.count].position = point;
  ++voxel.count;
}

void PointMap::transform(const Eigen::Isometry3f& T_new_O) {
  std::vector<Vec3f> moved;
  moved.reserve(num_points());
  for (std::uint32_t voxel = 0; voxel < voxels_.size(); ++voxel) {
    const MapPoint* first = points_of(voxel);
    for (std::uint32_t i = 0; i < voxels_[voxel].count; ++i) moved.push_back(T_new_O * first[i].position);
  }
  clear();
  insert(moved);
}

void PointMap::keep_around(const Vec3f& center_O, double radius_m) {
  const float size = 1.0F / inverse_size_;
  const float radius_sq = static_cast<float>(radius_m * radius_m);
  std::vector<std::pair<float, std::uint32_t>> by_distance;
  for (std::uint32_t i = 0; i < voxels_.size(); ++i) {
    const float distance_sq = (center_of(voxels_[i].key, size) - center_O).squaredNorm();
    if (distance_sq <= radius_sq) by_distance.emplace_back(distance_sq, i);
  }
  const auto bound = static_cast<std::size_t>(options_.max_voxels);
  if (by_distance.size() == voxels_.size() && voxels_.size() < bound) return;
  if (by_distance.size() >= bound) {
    const auto keep = static_cast<std::ptrdiff_t>(bound * 3 / 4);
    std::nth_element(by_distance.begin(), by_distance.begin() + keep, by_distance.end());
    by_distance.resize(static_cast<std::size_t>(keep));
  }
  std::vector<std::uint32_t> kept;
  kept.reserve(by_distance.size());
  for (const auto& entry : by_distance) kept.push_back(entry.second);
  std::sort(kept.begin(), kept.end());
  rebuild(kept);
}

void PointMap::rebuild(const std::vector<std::uint32_t>& kept) {
  numbers_.clear();
  for (std::uint32_t to = 0; to < kept.size(); ++to) {
    const std::uint32_t from = kept[to];  // >= to, so that nothing is overwritten before it is moved
    voxels_[to] = voxels_[from];
    if (from != to) std::copy_n(points_of(from), capacity_, points_of(to));
    number(voxels_[to].key, to);
  }
  voxels_.resize(kept.size());
  points_.resize(kept.size() * capacity_);
}

void PointMap::search_cell(VoxelKey key, const Vec3f& point, float* best_sq, MapPoint** best) {
  const std::optional<std::uint32_t> index = find(key);
  if (!index) return;
  MapPoint* points = points_of(*index);
  for (std::uint32_t i = 0; i < voxels_[*index].count; ++i) {
    const float distance_sq = (points[i].position - point).squaredNorm();
    if (distance_sq < *best_sq) {
      *best_sq = distance_sq;
      *best = points + i;
    }
  }
}

MapPoint* PointMap::nearest(const Vec3f& point_O, double max_distance_m) {
  const auto limit = static_cast<float>(max_distance_m);
  float best_sq = limit * limit;
  MapPoint* best = nullptr;
  // Most searches end close by, so that the whole radius is searched only when half a voxel does not give a point.
  const float near = std::min(limit, 0.5F / inverse_size_);
  for_each_cell(cells_around(point_O, near, inverse_size_),
                [&](VoxelKey key) { search_cell(key, point_O, &best_sq, &best); });
  if ((best && best_sq <= near * near) || near >= limit) return best;
  const float rest = best ? std::sqrt(best_sq) : limit;
  for_each_cell(cells_around(point_O, rest, inverse_size_),
                [&](VoxelKey key) { search_cell(key, point_O, &best_sq, &best); });
  return best;
}

void PointMap::update_shape(MapPoint* point, const Vec3f& sensor_up_O, std::uint32_t scan) {
  if (scan < point->next_fit_scan) return;
  const float radius = 1.0F / inverse_size_;
  const Vec3f center = point->position;
  Neighbourhood offsets;
  for_each_cell(cells_around(center, radius, inverse_size_), [&](VoxelKey key) {
    const std::optional<std::uint32_t> index = find(key);
    if (!index) return;
    const MapPoint* points = points_of(*index);
    for (std::uint32_t i = 0; i < voxels_[*index].count; ++i) {
      const Vec3f offset = points[i].position - center;
      if (offset.squaredNorm() <= radius * radius) offsets.add(offset);
    }
  });
  classify(offsets, sensor_up_O, point);
  if (point->shape == Shape::kLine && !stands_alone(*point)) point->shape = Shape::kUnknown;
  point->refit_interval =
      std::min<std::uint16_t>(kMaxRefitInterval, static_cast<std::uint16_t>(point->refit_interval * 2 + 1));
  point->next_fit_scan = scan + point->refit_interval;
}

bool PointMap::stands_alone(const MapPoint& line) const {
  const float radius = 1.0F / inverse_size_;
  int on_line = 0, beside = 0;
  for_each_cell(cells_around(line.position, 2.0F * radius, inverse_size_), [&](VoxelKey key) {
    const std::optional<std::uint32_t> index = find(key);
    if (!index) return;
    const MapPoint* points = points_.data() + std::size_t{*index} * capacity_;
    for (std::uint32_t i = 0; i < voxels_[*index].count; ++i) {
      const Vec3f offset = points[i].position - line.position;
      const float along = line.direction.dot(offset);
      // Ground and canopy lie at the ends of a pole and not beside it.
      if (std::abs(along) > radius) continue;
      (offset - along * line.direction).squaredNorm() < 0.25F * radius* radius ? ++on_line : ++beside;
    }
  });
  return beside * 4 <= on_line;
}

std::size_t PointMap::num_points() const {
  return std::accumulate(voxels_.begin(), voxels_.end(), std::size_t{0},
                         [](std::size_t sum, const Voxel& v) { return sum + v.count; });
}

std::size_t PointMap::memory_bytes() const {
  return points_.capacity() * sizeof(MapPoint) + voxels_.capacity() * sizeof(Voxel) + numbers_.memory_bytes();
}

}  // namespace voxnav::odometry
