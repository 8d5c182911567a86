// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "voxnav_simulation/lidar_config.hpp"
#include "voxnav_simulation/lidar_scan.hpp"
#include "voxnav_simulation/scene.hpp"

namespace voxnav_simulation {

/// Simulates the scans of a spinning LiDAR in a scene. The same seed, scan index and poses give the same scan with any
/// number of threads. Beam divergence (mixed returns at edges), rain and fog are not simulated.
class LidarModel {
 public:
  /// @throws voxnav::base::ConfigError
  LidarModel(const LidarConfig& config, std::uint64_t seed);

  const LidarConfig& config() const { return config_; }
  int rows() const { return static_cast<int>(beams_.size()); }
  std::int64_t sweep_ns() const;
  std::uint32_t column_time_ns(int column) const;
  /// Returns the direction of a column in the sensor frame.
  double azimuth_rad(int column) const;

  /// Measures one turn. `T_W_L` holds the pose of the sensor for each column, at the column's own time.
  /// @throws std::invalid_argument unless there is one pose per column
  LidarScan scan(const Scene& scene, const std::vector<Pose>& T_W_L, std::uint64_t scan_index) const;

 private:
  struct Beam {
    float cos_elevation;
    float sin_elevation;
  };
  struct Return {
    float range_m;
    float signal;
    std::uint8_t label;
  };
  void scan_columns(const Scene& scene, const std::vector<Pose>& T_W_L, std::uint64_t scan_key, int first, int last,
                    LidarScan* out) const;
  Return measure(const Hit& hit, float body_range_m, bool is_towards_sun, std::uint64_t key) const;
  float signal_of(float reflectance, float cos_incidence, float range_m, std::uint64_t key) const;
  void store(const Return& measured, std::size_t pixel, const Vec3f& direction_L, LidarScan* out) const;

  LidarConfig config_;
  std::uint64_t seed_;
  std::vector<Beam> beams_;
  std::vector<float> body_ranges_m_;  ///< per column and row; infinite where the beam misses the UAV
  Vec3f sun_W_;
  float cos_sun_half_angle_;
};

/// Returns one pose per column for a sensor that moves evenly from `T_W_L_start` to `T_W_L_end` during one turn.
std::vector<Pose> poses_between(const Pose& T_W_L_start, const Pose& T_W_L_end, int columns);

}  // namespace voxnav_simulation
