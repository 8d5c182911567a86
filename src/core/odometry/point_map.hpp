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

/// The cell that holds a point as one number with 21 bits per axis. It is kNoKey for a point that lies too far away or
/// is not finite.
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

/// Thins points out. Its memory is kept from call to call.
class Downsampler {
 public:
  /// Keeps the first point of every voxel, in the order of the input.
  /// Source: Vizzo et al., KISS-ICP, RA-L 2023, section III-B; differs: the first point stands for its voxel.
  void run(const std::vector<Vec3f>& points, double voxel_size_m, std::vector<Vec3f>* out);

 private:
  containers::KeyNumbers<VoxelKey, VoxelKeyHash> voxels_;
};

/// Shape of the surface around a map point, as far as its neighbours show it.
enum class Shape : std::uint8_t { kUnknown, kPlane, kLine };

struct MapPoint {
  Vec3f position = Vec3f::Zero();
  Vec3f anchor = Vec3f::Zero();     ///< plane: centroid of the neighbourhood; line: the point itself
  Vec3f direction = Vec3f::Zero();  ///< plane: normal; line: axis; unit
  Shape shape = Shape::kUnknown;
  std::uint16_t refit_interval = 0;  ///< scans between the last fit and the next
  std::uint32_t next_fit_scan = 0;
};

struct PointMapOptions {
  double voxel_size_m = 0.6;
  int max_points_per_voxel = 12;
  int max_voxels = 60000;
};

/// Bounded map of points, hashed by voxel. The surface around a point is fitted when it is first asked for and refitted
/// ever more rarely while the map grows. Not thread-safe; deterministic.
/// Source: Vizzo et al., KISS-ICP, RA-L 2023, section III-C (voxel hash of points); the fitted shapes are of this
/// repository.
class PointMap {
 public:
  explicit PointMap(const PointMapOptions& options);

  void clear();
  /// Adds points of frame O, except where the map is already as dense as its options allow. O(points).
  void insert(const std::vector<Vec3f>& points_O);
  /// Moves all points, as the frame in which they are given is moved. O(points).
  void transform(const Eigen::Isometry3f& T_new_O);
  /// Removes the voxels farther away than `radius_m`. If the bound is reached nevertheless, the farthest ones go too,
  /// until three quarters of it are left.
  void keep_around(const Vec3f& center_O, double radius_m);
  /// Returns the nearest point within max_distance_m and within two voxels on each axis; null if there is none.
  MapPoint* nearest(const Vec3f& point_O, double max_distance_m);
  /// Fits the surface around a map point unless its last fit is recent enough. A line is believed only if it stands
  /// along `sensor_up_O`, since the rings that a spinning sensor draws look like lines across that axis.
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
  /// Returns true if a line has air around it, as poles and trunks do. A column of beams on a wall looks like a line,
  /// but that line moves with the sensor.
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

  VoxelNumbers numbers_;  ///< where a voxel lies in voxels_, by its key
  std::vector<Voxel> voxels_;
  std::vector<MapPoint> points_;  // capacity_ per voxel
};

}  // namespace voxnav::odometry
