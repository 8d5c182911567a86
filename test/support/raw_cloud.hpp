// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstring>
#include <string>
#include <vector>

#include "voxnav/cloud/cloud_layout.hpp"

namespace voxnav::test {

/// A cloud as raw bytes with a layout, whose values are set field by field.
struct RawCloud {
  cloud::CloudLayout layout;
  std::vector<std::uint8_t> bytes;

  RawCloud(std::uint32_t height, std::uint32_t width, std::uint32_t point_step, std::vector<cloud::CloudField> fields) {
    layout.height = height;
    layout.width = width;
    layout.point_step = point_step;
    layout.fields = std::move(fields);
    bytes.assign(static_cast<std::size_t>(height) * width * point_step, 0);
  }
  template <class T>
  void set(std::size_t index, const std::string& field, T value) {
    const cloud::CloudField* f = layout.find(field);
    std::memcpy(bytes.data() + index * layout.point_step + f->offset, &value, sizeof(T));
  }
  void set_xyz(std::size_t index, float x, float y, float z) {
    set(index, "x", x);
    set(index, "y", y);
    set(index, "z", z);
  }
  cloud::RawCloudView view(base::StampNs stamp_ns = 0) const { return {layout, bytes.data(), bytes.size(), stamp_ns}; }
};

inline std::vector<cloud::CloudField> xyzi_fields() {
  using cloud::FieldType;
  return {{"x", 0, FieldType::kFloat32, 1},
          {"y", 4, FieldType::kFloat32, 1},
          {"z", 8, FieldType::kFloat32, 1},
          {"intensity", 12, FieldType::kFloat32, 1}};
}

/// Returns an organised cloud of points with intensity 100, whose x goes from 2 m to 51 m in steps of 1 m and repeats.
inline RawCloud xyzi_cloud(std::uint32_t height, std::uint32_t width) {
  RawCloud cloud(height, width, 16, xyzi_fields());
  for (std::size_t i = 0; i < cloud.layout.num_points(); ++i) {
    cloud.set_xyz(i, 2.0F + static_cast<float>(i % 50), 1.0F, 0.5F);
    cloud.set(i, "intensity", 100.0F);
  }
  return cloud;
}

/// Returns the fields of the MRS Gazebo plugin, packed in 29 bytes: no field after x, y and z is aligned to its size.
inline std::vector<cloud::CloudField> gazebo_fields() {
  using cloud::FieldType;
  std::vector<cloud::CloudField> fields = xyzi_fields();
  fields.push_back({"ring", 16, FieldType::kUint8, 1});
  fields.push_back({"range", 17, FieldType::kUint32, 1});
  fields.push_back({"t", 21, FieldType::kUint32, 1});
  fields.push_back({"reflectivity", 25, FieldType::kUint16, 1});
  fields.push_back({"ambient", 27, FieldType::kUint16, 1});
  return fields;
}

/// Returns the fields of the Ouster driver in 48 bytes, with x, y and z padded to 16 bytes.
inline std::vector<cloud::CloudField> ouster_fields() {
  using cloud::FieldType;
  return {{"x", 0, FieldType::kFloat32, 1},    {"y", 4, FieldType::kFloat32, 1},
          {"z", 8, FieldType::kFloat32, 1},    {"intensity", 16, FieldType::kFloat32, 1},
          {"t", 20, FieldType::kUint32, 1},    {"reflectivity", 24, FieldType::kUint16, 1},
          {"ring", 26, FieldType::kUint8, 1},  {"ambient", 28, FieldType::kUint16, 1},
          {"range", 32, FieldType::kUint32, 1}};
}

}  // namespace voxnav::test
