// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "voxnav_simulation/lidar_config.hpp"

namespace voxnav_simulation {

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
}

template <class V>
void LidarConfig::echo_fields(V& v) {
  using C = LidarConfig;
  using voxnav::base::in;
  v("beam_divergence_rad", &C::beam_divergence_rad, in(0, 0.1), "rad",
    "width of the beam's cone at half of its brightness (OS0: 0.35 degrees, OS1: 0.18)");
  v("footprint_rays", &C::footprint_rays, in(1, kMostFootprintRays), "",
    "rays by which the footprint of a beam is sampled; 1 = beams without width, hence without mixed returns");
  v("echo_separation_m", &C::echo_separation_m, in(0, 10), "m",
    "surfaces under one footprint that follow each other more closely return as one echo at their mean range");
}

template <class V>
void LidarConfig::weather_fields(V& v) {
  using C = LidarConfig;
  using voxnav::base::in;
  v("rain_mm_per_h", &C::rain_mm_per_h, in(0, 200), "mm/h", "rain, whose drops return beams (moderate 4, heavy 16)");
  v("speckle_ratio", &C::speckle_ratio, in(0, 1), "",
    "share of all beams that return from dust or from the noise of sunlight (Ouster: 0.0001 in full sun)");
  v("speckle_max_range_m", &C::speckle_max_range_m, in(0.1, 500), "m", "farthest return from dust or noise");
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
