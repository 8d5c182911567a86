// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav_simulation/cloud_encoder.hpp"

#include <cmath>
#include <cstring>

namespace voxnav_simulation {
namespace {

using voxnav::cloud::CloudField;
using voxnav::cloud::FieldType;

struct Layout {
  std::uint32_t point_step;
  bool is_dense;
  bool has_times;
  std::uint32_t intensity, t, reflectivity, ring, ambient, range;  // offsets in bytes; x, y and z are at 0, 4 and 8
};

// The Ouster driver copies its aligned point structure from memory with the gaps; Gazebo's plugin packs the fields.
constexpr Layout kOusterLayout{48, true, true, 16, 20, 24, 26, 28, 32};
constexpr Layout kGazeboLayout{29, false, false, 12, 21, 25, 16, 27, 17};

const Layout& layout_of(DriverLayout layout) { return layout == DriverLayout::kOuster ? kOusterLayout : kGazeboLayout; }

std::vector<CloudField> ouster_fields() {
  const Layout& l = kOusterLayout;
  return {{"x", 0, FieldType::kFloat32},         {"y", 4, FieldType::kFloat32},
          {"z", 8, FieldType::kFloat32},         {"intensity", l.intensity, FieldType::kFloat32},
          {"t", l.t, FieldType::kUint32},        {"reflectivity", l.reflectivity, FieldType::kUint16},
          {"ring", l.ring, FieldType::kUint8},   {"ambient", l.ambient, FieldType::kUint16},
          {"range", l.range, FieldType::kUint32}};
}

std::vector<CloudField> gazebo_fields() {
  const Layout& l = kGazeboLayout;
  return {{"x", 0, FieldType::kFloat32},
          {"y", 4, FieldType::kFloat32},
          {"z", 8, FieldType::kFloat32},
          {"intensity", l.intensity, FieldType::kFloat32},
          {"ring", l.ring, FieldType::kUint8},
          {"range", l.range, FieldType::kUint32},
          {"t", l.t, FieldType::kUint32},
          {"reflectivity", l.reflectivity, FieldType::kUint16},
          {"ambient", l.ambient, FieldType::kUint16}};
}

template <class T>
void put(std::uint8_t* point, std::uint32_t offset, T value) {
  std::memcpy(point + offset, &value, sizeof(T));
}

void put_point(const LidarScan& scan, const Layout& layout, int row, int column, std::uint8_t* point) {
  const std::size_t pixel = scan.index(row, column);
  const auto& p = scan.points[pixel];
  std::memcpy(point, p.data(), 3 * sizeof(float));
  put(point, layout.intensity, p[3]);
  put(point, layout.t, layout.has_times ? scan.column_times_ns[column] : 0U);
  put(point, layout.reflectivity, static_cast<std::uint16_t>(std::lround(scan.reflectivity[pixel])));
  put(point, layout.ring, static_cast<std::uint8_t>(row));
  put(point, layout.ambient, std::uint16_t{0});
  put(point, layout.range, static_cast<std::uint32_t>(std::lround(1000.0F * scan.ranges_m[pixel])));
}

}  // namespace

EncodedCloud encode(const LidarScan& scan, DriverLayout layout) {
  const Layout& l = layout_of(layout);
  EncodedCloud out;
  out.height = static_cast<std::uint32_t>(scan.rows);
  out.width = static_cast<std::uint32_t>(scan.columns);
  out.point_step = l.point_step;
  out.is_dense = l.is_dense;
  out.fields = layout == DriverLayout::kOuster ? ouster_fields() : gazebo_fields();
  out.data.assign(static_cast<std::size_t>(out.height) * out.width * out.point_step, 0);
  std::uint8_t* point = out.data.data();
  for (int row = 0; row < scan.rows; ++row) {
    for (int column = 0; column < scan.columns; ++column, point += l.point_step) {
      put_point(scan, l, row, column, point);
    }
  }
  return out;
}

}  // namespace voxnav_simulation
