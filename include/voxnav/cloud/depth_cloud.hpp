// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "voxnav/base/config.hpp"
#include "voxnav/cloud/cloud_layout.hpp"

namespace voxnav::cloud {

/// The numbers of a sensor_msgs/CameraInfo that depth images need.
struct CameraInfo {
  std::uint32_t width = 0, height = 0;  ///< of the whole sensor
  std::array<double, 9> K{};            ///< intrinsics by rows; used if P has none
  std::array<double, 12> P{};           ///< those of the rectified image, by rows
  std::uint32_t binning_x = 0, binning_y = 0;
  std::uint32_t roi_x = 0, roi_y = 0, roi_width = 0, roi_height = 0;  ///< the part that images show; 0 = all of it
};

/// A pinhole camera: the pixel (u, v) sees along ((u - cx) / fx, (v - cy) / fy, 1), axes right, down and forward.
struct CameraModel {
  std::uint32_t width = 0, height = 0;  ///< of the images
  double fx = 0.0, fy = 0.0, cx = 0.0, cy = 0.0;
};

/// Returns the camera of rectified images, with binning and region of interest taken into account.
/// @throws std::invalid_argument saying what is missing or impossible: the size, the intrinsics
CameraModel camera_of(const CameraInfo& info);

/// How a depth image tells its depths. Source: REP 118, but what is said to lie beyond the range of the camera is none,
/// too.
enum class DepthEncoding : std::uint8_t {
  kMillimetres,      ///< 16 bits, 0 and 65535 = none
  kGreyMillimetres,  ///< the same by the name that some drivers give it
  kMetres,           ///< float, 0 or not finite = none
};
constexpr auto words_of(DepthEncoding) { return std::array{"16UC1", "mono16", "32FC1"}; }

/// A depth image as sensor_msgs/Image has it, in place.
struct DepthImage {
  std::string encoding;  ///< a word of DepthEncoding, else the image is refused
  std::uint32_t width = 0, height = 0;
  std::uint32_t step = 0;  ///< bytes per row
  bool is_big_endian = false;
  const std::uint8_t* data = nullptr;
  std::size_t size = 0;  ///< bytes
};

struct DepthCloudConfig {
  int row_step = 2;
  int column_step = 2;
  bool has_beams = false;

  template <class V>
  static void fields(V&& v) {
    using C = DepthCloudConfig;
    v("row_step", &C::row_step, base::in(1, 64), "", "only every n-th row of the image is used");
    v("column_step", &C::column_step, base::in(1, 64), "", "only every n-th column of the image is used");
    v("has_beams", &C::has_beams, base::any(), "",
      "pixels without depth bear their direction, of which open_beams of the filter can make open beams; depth "
      "cameras see nothing of what is dark, bare or too near either, so that this is for those that are known to");
  }
};

/// Turns depth images into organised clouds, which the cloud filter takes as those of a LiDAR. A pixel without depth
/// becomes a point that is not finite. Not thread-safe.
class DepthCloud {
 public:
  /// @throws base::ConfigError
  explicit DepthCloud(const DepthCloudConfig& config = {});

  /// The fields of the clouds: x y z and, with has_beams, beam_x beam_y beam_z, all float32.
  CloudLayout layout(const CameraModel& camera) const;
  /// Converts an image to the bytes of a cloud of that layout, in the optical frame of the camera. O(pixels used).
  /// @throws std::invalid_argument saying what is wrong with the image, or that it is of another size than the camera
  void convert(const DepthImage& image, const CameraModel& camera, std::vector<std::uint8_t>* bytes);

 private:
  template <class Number>
  void convert_rows(const DepthImage& image, const CameraModel& camera, float metres_per_unit, float* out) const;
  void note_camera(const CameraModel& camera);

  DepthCloudConfig config_;
  CameraModel camera_;                ///< of the slopes below
  std::vector<float> across_, down_;  ///< x / z of each column that is used, y / z of each row
};

}  // namespace voxnav::cloud
