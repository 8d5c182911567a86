// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/cloud/depth_cloud.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <stdexcept>

namespace voxnav::cloud {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr float kMetresPerMillimetre = 0.001F;
constexpr std::uint32_t kMaxSide = 16384;

std::string size_words(std::uint32_t width, std::uint32_t height) {
  return std::to_string(width) + " x " + std::to_string(height);
}

bool is_focal_length(double f) { return std::isfinite(f) && f > 0.0; }

/// @throws std::invalid_argument for an encoding that is none of depth
DepthEncoding encoding_of(const DepthImage& image) {
  const auto encoding = base::value_of_word<DepthEncoding>(image.encoding);
  if (encoding) return *encoding;
  throw std::invalid_argument("its encoding is '" + image.encoding +
                              "', but depth comes as 16UC1 (millimetres) or 32FC1 (metres)");
}

std::size_t bytes_of(DepthEncoding encoding) {
  return encoding == DepthEncoding::kMetres ? sizeof(float) : sizeof(std::uint16_t);
}

void check(const DepthImage& image, const CameraModel& camera) {
  const std::size_t bytes = bytes_of(encoding_of(image));
  if (image.width != camera.width || image.height != camera.height) {
    throw std::invalid_argument("it has " + size_words(image.width, image.height) +
                                " pixels, but camera_info is of images of " + size_words(camera.width, camera.height));
  }
  if (image.is_big_endian) throw std::invalid_argument("big-endian images are not read");
  const std::uint64_t row = std::uint64_t{image.width} * bytes;
  if (image.step < row || image.size < std::uint64_t{image.step} * (image.height - 1) + row) {
    throw std::invalid_argument("it has " + std::to_string(image.size) + " bytes in rows of " +
                                std::to_string(image.step) + ", too few for " + size_words(image.width, image.height) +
                                " pixels of " + image.encoding);
  }
}

/// The largest number is what drivers write for "too far to say", or for nothing at all.
float depth_of(std::uint16_t millimetres) {
  return millimetres == std::numeric_limits<std::uint16_t>::max() ? 0.0F : static_cast<float>(millimetres);
}
float depth_of(float metres) { return std::isfinite(metres) && metres > 0.0F ? metres : 0.0F; }

}  // namespace

CameraModel camera_of(const CameraInfo& info) {
  if (info.width == 0 || info.height == 0 || info.width > kMaxSide || info.height > kMaxSide)
    throw std::invalid_argument("camera_info tells no size of images: " + size_words(info.width, info.height));
  const bool is_rectified = is_focal_length(info.P[0]) && is_focal_length(info.P[5]);
  CameraModel out;
  out.fx = is_rectified ? info.P[0] : info.K[0];
  out.fy = is_rectified ? info.P[5] : info.K[4];
  out.cx = is_rectified ? info.P[2] : info.K[2];
  out.cy = is_rectified ? info.P[6] : info.K[5];
  if (!is_focal_length(out.fx) || !is_focal_length(out.fy) || !std::isfinite(out.cx) || !std::isfinite(out.cy)) {
    throw std::invalid_argument(
        "camera_info tells no intrinsics: neither P nor K has focal lengths; calibrate the "
        "camera, or let its driver publish them");
  }
  const std::uint32_t binning_x = std::max(info.binning_x, 1U), binning_y = std::max(info.binning_y, 1U);
  out.width = (info.roi_width > 0 ? info.roi_width : info.width) / binning_x;
  out.height = (info.roi_height > 0 ? info.roi_height : info.height) / binning_y;
  if (out.width == 0 || out.height == 0) throw std::invalid_argument("camera_info has a binning beyond its size");
  out.fx /= binning_x;
  out.fy /= binning_y;
  out.cx = (out.cx - info.roi_x) / binning_x;
  out.cy = (out.cy - info.roi_y) / binning_y;
  return out;
}

DepthCloud::DepthCloud(const DepthCloudConfig& config) : config_(base::checked(config)) {}

CloudLayout DepthCloud::layout(const CameraModel& camera) const {
  const auto used = [](std::uint32_t count, int step) {
    return (count + static_cast<std::uint32_t>(step) - 1) / static_cast<std::uint32_t>(step);
  };
  CloudLayout out;
  out.height = used(camera.height, config_.row_step);
  out.width = used(camera.width, config_.column_step);
  for (const char* name : {"x", "y", "z", "beam_x", "beam_y", "beam_z"}) {
    if (out.fields.size() == 3 && !config_.has_beams) break;
    out.fields.push_back({name, out.point_step, FieldType::kFloat32, 1});
    out.point_step += sizeof(float);
  }
  out.row_step = out.width * out.point_step;
  return out;
}

void DepthCloud::note_camera(const CameraModel& camera) {
  const bool is_known = camera.width == camera_.width && camera.height == camera_.height && camera.fx == camera_.fx &&
                        camera.fy == camera_.fy && camera.cx == camera_.cx && camera.cy == camera_.cy;
  if (is_known) return;
  camera_ = camera;
  across_.clear();
  down_.clear();
  for (std::uint32_t u = 0; u < camera.width; u += static_cast<std::uint32_t>(config_.column_step))
    across_.push_back(static_cast<float>((u - camera.cx) / camera.fx));
  for (std::uint32_t v = 0; v < camera.height; v += static_cast<std::uint32_t>(config_.row_step))
    down_.push_back(static_cast<float>((v - camera.cy) / camera.fy));
}

void DepthCloud::convert(const DepthImage& image, const CameraModel& camera, std::vector<std::uint8_t>* bytes) {
  check(image, camera);
  note_camera(camera);
  const CloudLayout cloud = layout(camera);
  bytes->resize(static_cast<std::size_t>(cloud.height) * cloud.row_step);
  auto* out = reinterpret_cast<float*>(bytes->data());  // of the allocator, which aligns it for any number
  if (encoding_of(image) == DepthEncoding::kMetres) {
    convert_rows<float>(image, camera, 1.0F, out);
  } else {
    convert_rows<std::uint16_t>(image, camera, kMetresPerMillimetre, out);
  }
}

template <class Number>
void DepthCloud::convert_rows(const DepthImage& image, const CameraModel& camera, float metres_per_unit,
                              float* out) const {
  const auto row_step = static_cast<std::uint32_t>(config_.row_step);
  const auto column_step = static_cast<std::uint32_t>(config_.column_step);
  for (std::uint32_t v = 0; v < camera.height; v += row_step) {
    const std::uint8_t* row = image.data + std::size_t{v} * image.step;
    const float down = down_[v / row_step];
    for (std::uint32_t u = 0; u < camera.width; u += column_step) {
      Number value;
      std::memcpy(&value, row + u * sizeof(Number), sizeof(Number));
      const float across = across_[u / column_step], depth = depth_of(value) * metres_per_unit;
      const float z = depth > 0.0F ? depth : kNaN;
      *out++ = across * z;
      *out++ = down * z;
      *out++ = z;
      if (!config_.has_beams) continue;
      const float length = depth > 0.0F ? 0.0F : 1.0F / std::sqrt(1.0F + across * across + down * down);
      *out++ = across * length;
      *out++ = down * length;
      *out++ = length;
    }
  }
}

}  // namespace voxnav::cloud
