// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "voxnav_simulation/lidar_scan.hpp"

namespace voxnav_simulation {

/// The two layouts users meet: the MRS fork of the Ouster driver (48 bytes per point, aligned, with times), and the
/// MRS Gazebo plugin (29 bytes, packed, times zero). Both mark "no return" with (0, 0, 0).
enum class CloudLayout { kOuster, kGazebo };
constexpr auto words_of(CloudLayout) { return std::array{"ouster", "gazebo"}; }

/// Types as numbered by sensor_msgs/PointField.
enum class FieldType : std::uint8_t { kUint8 = 2, kUint16 = 4, kUint32 = 6, kFloat32 = 7 };

struct CloudField {
  std::string name;
  std::uint32_t offset;
  FieldType type;
};

/// The parts of a sensor_msgs/PointCloud2.
struct EncodedCloud {
  std::uint32_t height = 0;
  std::uint32_t width = 0;
  std::uint32_t point_step = 0;
  bool is_dense = false;
  std::vector<CloudField> fields;
  std::vector<std::uint8_t> data;
};

/// Organised cloud of a scan. `ring` is the row; `ambient` is not simulated and 0.
EncodedCloud encode(const LidarScan& scan, CloudLayout layout);

}  // namespace voxnav_simulation
