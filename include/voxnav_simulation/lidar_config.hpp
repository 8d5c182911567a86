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
/// return about 45000 / r^2 photons, the detector saturates near 4500, and returns below about 20 are lost.
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
  static void body_fields(V& v);
};

template <class V>
void LidarConfig::beam_fields(V& v) {
  using C = LidarConfig;
  using voxnav::base::in;
  using voxnav::base::one_of;
  v("model", &C::model, one_of<BeamModel>(), "", "beam table; custom takes beam_elevations_rad");
  v("beam_elevations_rad", &C::beam_elevations_rad, in(-1.5708, 1.5708), "rad",
    "elevation of each beam, top first; only for model custom");
  v("columns", &C::columns, in(16, 4096), "", "measurements per turn (Ouster: 512, 1024, 2048)");
  v("rate_hz", &C::rate_hz, in(1, 50), "Hz", "turns per second (Ouster: 10, 20)");
  v("min_range_m", &C::min_range_m, in(0, 10), "m", "nothing nearer is measured");
  v("max_range_m", &C::max_range_m, in(1, 500), "m", "nothing farther is measured");
  v("range_noise_m", &C::range_noise_m, in(0, 1), "m", "standard deviation of a range");
  v("dropout_ratio", &C::dropout_ratio, in(0, 1), "", "share of returns lost at random");
}

template <class V>
void LidarConfig::signal_fields(V& v) {
  using C = LidarConfig;
  using voxnav::base::in;
  v("signal_scale", &C::signal_scale, in(1, 1e9), "", "photons from a white surface head-on at 1 m");
  v("signal_saturation", &C::signal_saturation, in(1, 65535), "", "largest signal a near surface gives");
  v("signal_noise_ratio", &C::signal_noise_ratio, in(0, 1), "", "standard deviation of a signal over the signal");
  v("min_signal", &C::min_signal, in(0, 1e4), "", "weaker returns are not detected");
  v("ghost_ratio", &C::ghost_ratio, in(0, 1), "", "share of the beams towards the sun that give a false near return");
  v("ghost_max_range_m", &C::ghost_max_range_m, in(0.1, 100), "m", "farthest false return");
  v("ghost_intensity_max", &C::ghost_intensity_max, in(0, 1e4), "", "largest signal of a false return");
  v("sun_azimuth_rad", &C::sun_azimuth_rad, in(-6.3, 6.3), "rad", "direction of the sun in the world");
  v("sun_elevation_rad", &C::sun_elevation_rad, in(-1.5708, 1.5708), "rad", "height of the sun above the horizon");
  v("sun_half_angle_rad", &C::sun_half_angle_rad, in(0, 3.1416), "rad", "beams this close to the sun are disturbed");
}

template <class V>
void LidarConfig::body_fields(V& v) {
  using C = LidarConfig;
  using voxnav::base::any;
  using voxnav::base::in;
  v("mount_position_m", &C::mount_position_m, in(-5, 5), "m", "position of the sensor on the body (fcu)");
  v("mount_rpy_rad", &C::mount_rpy_rad, in(-3.1416, 3.1416), "rad", "roll, pitch and yaw of the sensor on the body");
  v("body_capsules_m", &C::body_capsules_m, any(), "m",
    "parts of the UAV in the body frame, seven numbers each: both ends of the axis and the radius");
  v("body_reflectance", &C::body_reflectance, in(0, 1), "", "share of the light that the UAV's own parts return");
  v("num_threads", &C::num_threads, in(1, 16), "", "threads of one scan; results do not depend on it");
}

}  // namespace voxnav_simulation
