// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "voxnav_simulation/lidar_config.hpp"
#include "voxnav_simulation/lidar_scan.hpp"
#include "voxnav_simulation/scene.hpp"

namespace voxnav_simulation {

class BeamFootprint;
class Rain;

/// Simulates the scans of a spinning LiDAR in a scene. The same seed, scan index and poses give the same scan with any
/// number of threads. Beams have width and give mixed returns if LidarConfig::footprint_rays says so. Fog is not
/// simulated.
class LidarModel {
 public:
  /// @throws voxnav::base::ConfigError
  LidarModel(const LidarConfig& config, std::uint64_t seed);
  ~LidarModel();
  LidarModel(LidarModel&&) noexcept;
  LidarModel& operator=(LidarModel&&) noexcept;

  const LidarConfig& config() const { return config_; }
  int rows() const { return static_cast<int>(beams_.size()); }
  std::int64_t sweep_ns() const;
  std::uint32_t column_time_ns(int column) const;
  /// Returns the direction of a column in the sensor frame.
  double azimuth_rad(int column) const;

  /// Measures one turn. `T_W_L` holds the pose of the sensor for each column, at the column's own time.
  /// The turn with index i begins at i times the duration of a turn; persons and other UAVs are where they are then.
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
  /// What returns a beam, if anything does.
  struct Target {
    float range_m;
    float power;  ///< photons that would return from a range of 1 m
    std::uint8_t label;
  };
  struct Footprints;
  /// One turn of the sensor.
  struct Turn {
    std::uint64_t key;  ///< of its random numbers
    std::int64_t start_ns;
  };
  void scan_columns(const Scene& scene, const std::vector<Pose>& T_W_L, const Turn& turn, int first, int last,
                    LidarScan* out) const;
  void cast_column(const Scene& scene, const Pose& T_W_L, int column, const Turn& turn, Footprints* out) const;
  std::uint64_t key_of(std::uint64_t scan_key, int column, std::size_t beam) const;
  Target target_of(const Hit* hits, float body_range_m) const;
  Target seen_through_rain(const Target& target, std::uint64_t key) const;
  Return measure(const Target& target, bool is_towards_sun, std::uint64_t key) const;
  float signal_of(const Target& target, std::uint64_t key) const;
  void store(const Return& measured, std::size_t pixel, const Vec3f& direction_L, LidarScan* out) const;

  LidarConfig config_;
  std::uint64_t seed_;
  std::vector<Beam> beams_;
  std::unique_ptr<const BeamFootprint> footprint_;
  std::unique_ptr<const Rain> rain_;
  std::vector<float> body_ranges_m_;  ///< per column and row; infinite where the beam misses the UAV
  Vec3f sun_W_;
  float cos_sun_half_angle_;
};

/// Returns one pose per column for a sensor that moves evenly from `T_W_L_start` to `T_W_L_end` during one turn.
std::vector<Pose> poses_between(const Pose& T_W_L_start, const Pose& T_W_L_end, int columns);

}  // namespace voxnav_simulation
