// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <string>
#include <vector>

#include "voxnav/base/config.hpp"
#include "voxnav_simulation/mesh.hpp"

namespace voxnav_simulation {

/// Sensors whose beam elevations are known from data sheets; kCustom takes the elevations that are configured.
enum class BeamModel { kOs0With128, kOs0With64, kOs0With32, kOs1With16, kOs1With64, kVlp16, kCustom };
constexpr auto words_of(BeamModel) {
  return std::array{"os0-128", "os0-64", "os0-32", "os1-16", "os1-64", "vlp-16", "custom"};
}

/// A spinning LiDAR. The defaults of the signal follow recordings of an Ouster OS0-128: common surfaces at range r
/// return about 45000 / r^2 photons, the detector saturates near 4500, and returns below about 20 are lost. Its beam is
/// 0.35 degrees wide at half maximum (data sheet).
struct LidarConfig {
  BeamModel model = BeamModel::kOs0With128;
  std::vector<double> beam_elevations_rad;
  int columns = 1024;
  double rate_hz = 10.0;
  double min_range_m = 0.3;
  double max_range_m = 100.0;
  double range_noise_m = 0.015;
  double dropout_ratio = 0.01;

  double signal_scale = 3.0e5;
  double signal_saturation = 4500.0;
  double signal_noise_ratio = 0.1;
  double min_signal = 20.0;

  double beam_divergence_rad = 0.0061;
  static constexpr int kMostFootprintRays = 32;
  int footprint_rays = 1;
  double echo_separation_m = 0.4;

  double rain_mm_per_h = 0.0;
  double speckle_ratio = 0.0;
  double speckle_max_range_m = 30.0;
  double ghost_ratio = 0.005;
  double ghost_max_range_m = 4.0;
  double ghost_intensity_max = 15.0;
  double sun_azimuth_rad = 0.8;
  double sun_elevation_rad = 0.6;
  double sun_half_angle_rad = 0.8;

  std::array<double, 3> mount_position_m{0.0, 0.0, 0.15};
  std::array<double, 3> mount_rpy_rad{0.0, 0.0, 0.0};
  std::vector<double> body_capsules_m{
      0,     0,    0,    0.24,  0.24, 0,    0.015, 0,     0,     0,    0.24,  -0.24, 0,    0.015,  // arms
      0,     0,    0,    -0.24, 0.24, 0,    0.015, 0,     0,     0,    -0.24, -0.24, 0,    0.015,  //
      0.24,  0.24, 0.01, 0.24,  0.24, 0.05, 0.02,  0.24,  -0.24, 0.01, 0.24,  -0.24, 0.05, 0.02,   // motors
      -0.24, 0.24, 0.01, -0.24, 0.24, 0.05, 0.02,  -0.24, -0.24, 0.01, -0.24, -0.24, 0.05, 0.02,   //
      0.2,   0.2,  0,    0.26,  0.26, -0.3, 0.01,  0.2,   -0.2,  0,    0.26,  -0.26, -0.3, 0.01,   // legs
      -0.2,  0.2,  0,    -0.26, 0.26, -0.3, 0.01,  -0.2,  -0.2,  0,    -0.26, -0.26, -0.3, 0.01};
  double body_reflectance = 0.1;

  int num_threads = 1;

  template <class V>
  static void fields(V&& v) {
    beam_fields(v);
    signal_fields(v);
    echo_fields(v);
    weather_fields(v);
    body_fields(v);
  }
  std::vector<std::string> problems() const;

  /// Returns the elevations of the beams in radians, top beam first.
  std::vector<double> elevations_rad() const;
  /// Returns the pose of the sensor on the body.
  Pose T_B_L() const;

 private:
  template <class V>
  static void beam_fields(V& v);
  template <class V>
  static void signal_fields(V& v);
  template <class V>
  static void echo_fields(V& v);
  template <class V>
  static void weather_fields(V& v);
  template <class V>
  static void body_fields(V& v);
};

}  // namespace voxnav_simulation

#include "voxnav_simulation/lidar_config_fields.hpp"  // IWYU pragma: export
