// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <vector>

#include "voxnav/base/time.hpp"

namespace voxnav::cloud {

/// Number types of a cloud field; the values are those of sensor_msgs/PointField, and the two of pcl::PCLPointField.
enum class FieldType : std::uint8_t {
  kInt8 = 1,
  kUint8 = 2,
  kInt16 = 3,
  kUint16 = 4,
  kInt32 = 5,
  kUint32 = 6,
  kFloat32 = 7,
  kFloat64 = 8,
  kInt64 = 9,
  kUint64 = 10
};

/// Bytes of one value; 0 for a number that is no type.
std::size_t size_of(FieldType type);
const char* name_of(FieldType type);

struct CloudField {
  std::string name;
  std::uint32_t offset = 0;  ///< bytes from the start of the point; need not be aligned
  FieldType type = FieldType::kFloat32;
  std::uint32_t count = 1;  ///< 0 is read as 1, as common drivers mean it
};

/// The declared layout of the bytes of a cloud (sensor_msgs/PointCloud2 without its header).
struct CloudLayout {
  std::uint32_t height = 1;
  std::uint32_t width = 0;
  std::uint32_t point_step = 0;  ///< bytes per point
  /// Bytes per row; 0 = width * point_step. Some drivers give the bytes of the whole cloud, which is understood.
  std::uint32_t row_step = 0;
  bool is_big_endian = false;
  std::vector<CloudField> fields;

  std::uint64_t num_points() const { return static_cast<std::uint64_t>(height) * width; }
  const CloudField* find(const std::string& name) const;
  /// Bytes from one row to the next in a buffer of `data_size` bytes.
  std::uint64_t bytes_per_row(std::size_t data_size) const;
  /// Explains to the user why a buffer of `data_size` bytes cannot be read with this layout; empty if it can.
  std::string problem(std::size_t data_size) const;
};

/// The position and type of one scalar within a point.
struct FieldAccess {
  std::uint32_t offset = 0;
  FieldType type = FieldType::kFloat32;
};

/// The field that holds the time of each point; how its numbers are meant is for PointTimes to find out.
struct TimeField {
  std::string name;
  FieldAccess access;
};

/// Field names and types of the usual drivers, resolved to byte positions:
/// Ouster, Gazebo, Velodyne, LSLiDAR, Livox, Hesai, RoboSense and Aeva.
struct CloudAccess {
  FieldAccess x, y, z;
  std::optional<FieldAccess> intensity;            ///< intensity, else reflectivity
  std::optional<TimeField> time;                   ///< t, time, timestamp, offset_time, or another name with time in it
  std::optional<std::array<FieldAccess, 3>> beam;  ///< beam_x, beam_y, beam_z of the cloud filter
};

/// A cloud read in place: the layout is checked once, the bytes are neither copied nor owned.
class RawCloudView {
 public:
  /// @param data  at least row_step * height bytes; must outlive the view; may be null when there are no points
  /// @throws std::invalid_argument with the text of CloudLayout::problem()
  RawCloudView(const CloudLayout& layout, const std::uint8_t* data, std::size_t data_size, base::StampNs stamp_ns = 0);

  std::uint32_t height() const { return height_; }
  std::uint32_t width() const { return width_; }
  std::uint32_t point_step() const { return point_step_; }
  bool is_organised() const { return height_ > 1; }
  std::uint64_t num_points() const { return static_cast<std::uint64_t>(height_) * width_; }
  base::StampNs stamp_ns() const { return stamp_ns_; }
  const CloudAccess& access() const { return access_; }
  const std::uint8_t* row(std::uint32_t index) const { return data_ + index * row_step_; }

 private:
  std::uint32_t height_;
  std::uint32_t width_;
  std::uint32_t point_step_;
  std::size_t row_step_;
  base::StampNs stamp_ns_;
  CloudAccess access_;
  const std::uint8_t* data_;
};

/// Reads one value of any type as a double (exact but for integers beyond 2^53).
double read_number(const std::uint8_t* point, const FieldAccess& field);

/// Reads one value of any type as a float; fast for the usual type.
inline float read_float(const std::uint8_t* point, const FieldAccess& field) {
  if (field.type != FieldType::kFloat32) return static_cast<float>(read_number(point, field));
  float value;
  std::memcpy(&value, point + field.offset, sizeof(value));
  return value;
}

}  // namespace voxnav::cloud
