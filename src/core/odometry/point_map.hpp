// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "containers/number_table.hpp"
#include "voxnav/geometry/pose.hpp"

namespace voxnav::odometry {

using geometry::Vec3f;

/// Cell of a point as one number: 21 bits per axis; kNoKey when it does not fit or is not finite.
using VoxelKey = std::uint64_t;
constexpr VoxelKey kNoKey = ~VoxelKey{0};
VoxelKey key_of(const Vec3f& point, float inverse_size);

/// Finaliser of SplitMix64 (Steele, Lea & Flood 2014, figure 16), in short: neighbouring voxels must not share a run of
/// slots.
struct VoxelKeyHash {
  std::size_t operator()(VoxelKey key) const {
    const std::uint64_t h = key * 0x9E3779B97F4A7C15ull;
    return static_cast<std::size_t>(h ^ (h >> 29));
  }
};
using VoxelNumbers = containers::NumberTable<VoxelKey, VoxelKeyHash>;

/// Thins points out; keeps its memory from call to call.
class Downsampler {
 public:
  /// First point of every voxel, in input order.
  /// Source: Vizzo et al. 2023 (KISS-ICP), section III-B; differs: the first point stands for its voxel.
  void run(const std::vector<Vec3f>& points, double voxel_size_m, std::vector<Vec3f>* out);

 private:
  containers::KeyNumbers<VoxelKey, VoxelKeyHash> voxels_;
};

/// What the surface around a map point looks like.
enum class Shape : std::uint8_t { kUnknown, kPlane, kLine };

struct MapPoint {
  Vec3f position = Vec3f::Zero();
  Vec3f anchor = Vec3f::Zero();     ///< plane: centroid of the neighbourhood; line: the point itself
  Vec3f direction = Vec3f::Zero();  ///< plane: normal; line: axis; unit
  Shape shape = Shape::kUnknown;
  std::uint16_t refit_interval = 0;  ///< scans
  std::uint32_t next_fit_scan = 0;
};

struct PointMapOptions {
  double voxel_size_m = 0.6;
  int max_points_per_voxel = 12;
  int max_voxels = 60000;
};

/// Bounded local map: points hashed by voxel, with the surface around a point fitted when it is first asked for
/// and refitted ever more rarely while the map grows. Not thread-safe; deterministic.
class PointMap {
 public:
  explicit PointMap(const PointMapOptions& options);

  void clear();
  /// Adds points of frame O where the map is not yet as dense as it may be. O(points).
  void insert(const std::vector<Vec3f>& points_O);
  /// Removes voxels farther than `radius_m`, then the farthest until at most 3/4 of the bound are left when it is
  /// reached.
  void keep_around(const Vec3f& center_O, double radius_m);
  /// Nearest point within max_distance_m, at most two voxels away; null when there is none.
  MapPoint* nearest(const Vec3f& point_O, double max_distance_m);
  /// Fits the surface around a map point unless a recent fit is at hand. Lines are only believed along
  /// `sensor_up_O`: across it, the rings of the sensor itself look like lines.
  void update_shape(MapPoint* point, const Vec3f& sensor_up_O, std::uint32_t scan);

  std::size_t num_voxels() const { return voxels_.size(); }
  std::size_t num_points() const;
  bool empty() const { return voxels_.empty(); }
  std::size_t memory_bytes() const;

 private:
  struct Voxel {
    VoxelKey key;
    std::uint32_t count;
  };
  MapPoint* points_of(std::uint32_t voxel) { return points_.data() + std::size_t{voxel} * capacity_; }
  void insert_point(const Vec3f& point);
  void rebuild(const std::vector<std::uint32_t>& kept);
  /// A column of beams on a wall is a line too, and moves with the sensor; poles and trunks have air around them.
  bool stands_alone(const MapPoint& line) const;
  void search_cell(VoxelKey key, const Vec3f& point, float* best_sq, MapPoint** best);

  PointMapOptions options_;
  std::uint32_t capacity_;
  float inverse_size_;
  float spacing_sq_;
  std::optional<std::uint32_t> find(VoxelKey key) const {
    return numbers_.find(key, [this](std::uint32_t voxel) { return voxels_[voxel].key; });
  }
  void number(VoxelKey key, std::uint32_t voxel) {
    numbers_.insert(key, voxel, [this](std::uint32_t other) { return voxels_[other].key; });
  }

  VoxelNumbers numbers_;  ///< of voxels, by key
  std::vector<Voxel> voxels_;
  std::vector<MapPoint> points_;  // capacity_ per voxel
};

}  // namespace voxnav::odometry
