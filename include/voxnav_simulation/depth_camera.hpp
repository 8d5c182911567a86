// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "voxnav/base/config.hpp"
#include "voxnav/cloud/depth_cloud.hpp"
#include "voxnav_simulation/scene.hpp"

namespace voxnav_simulation {

/// A stereo depth camera. View, ranges and noise are those of an Intel RealSense D435 (data sheet: 87 x 58 degrees,
/// from 0.3 m; a disparity error of 0.08 pixels over a baseline of 50 mm), with fewer pixels.
struct DepthCameraConfig {
  int width = 160;
  int height = 120;
  double horizontal_fov_rad = 1.518;
  double vertical_fov_rad = 1.012;
  double rate_hz = 10.0;
  double min_range_m = 0.3;
  double max_range_m = 10.0;
  double noise_per_m = 0.0047;
  double dropout_ratio = 0.01;
  std::array<double, 3> mount_position_m{0.12, 0.0, 0.05};
  std::array<double, 3> mount_rpy_rad{0.0, 0.0, 0.0};

  template <class V>
  static void fields(V&& v);
  std::vector<std::string> problems() const;

  /// Pose of the camera's optical frame (axes right, down, forward) on the body.
  Pose T_B_C() const;
  voxnav::cloud::CameraModel camera() const;
};

template <class V>
void DepthCameraConfig::fields(V&& v) {
  using C = DepthCameraConfig;
  using voxnav::base::in;
  v("width", &C::width, in(8, 2048), "", "pixels in a row");
  v("height", &C::height, in(8, 2048), "", "rows of pixels");
  v("horizontal_fov_rad", &C::horizontal_fov_rad, in(0.1, 2.8), "rad", "angle of view across");
  v("vertical_fov_rad", &C::vertical_fov_rad, in(0.1, 2.8), "rad", "angle of view from top to bottom");
  v("rate_hz", &C::rate_hz, in(1, 90), "Hz", "images per second");
  v("min_range_m", &C::min_range_m, in(0, 10), "m", "no depth is measured below this");
  v("max_range_m", &C::max_range_m, in(0.5, 60), "m", "no depth is measured beyond this");
  v("noise_per_m", &C::noise_per_m, in(0, 0.1), "1/m", "standard deviation of a depth over the square of that depth");
  v("dropout_ratio", &C::dropout_ratio, in(0, 1), "", "share of pixels without depth at random");
  v("mount_position_m", &C::mount_position_m, in(-5, 5), "m", "position of the camera on the body (fcu)");
  v("mount_rpy_rad", &C::mount_rpy_rad, in(-3.1416, 3.1416), "rad",
    "roll, pitch and yaw of the camera on the body; with zeros it looks ahead");
}

/// A depth image: metres along the optical axis by rows, 0 = none.
using DepthPixels = std::vector<float>;

/// Measures a scene. The same seed, index and pose give the same image.
class DepthCameraModel {
 public:
  /// @throws voxnav::base::ConfigError
  DepthCameraModel(const DepthCameraConfig& config, std::uint64_t seed);

  const DepthCameraConfig& config() const { return config_; }
  /// Takes an image from the pose of the optical frame. The image with index i is taken after i periods; persons and
  /// other UAVs are where they are then.
  DepthPixels image(const Scene& scene, const Pose& T_W_C, std::uint64_t index) const;

 private:
  DepthCameraConfig config_;
  std::uint64_t seed_;
  std::vector<Vec3f> directions_C_;  ///< unit vectors of all pixels, by rows
};

}  // namespace voxnav_simulation
