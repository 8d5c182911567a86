// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "voxnav/cloud/cloud_layout.hpp"
#include "voxnav_simulation/lidar_scan.hpp"

namespace voxnav_simulation {

/// Layouts of the clouds on MRS vehicles: the MRS fork of the Ouster driver writes 48 bytes per point, aligned and with
/// times; the MRS Gazebo plugin writes 29 bytes, packed, with times of zero. Both mark "no return" with (0, 0, 0).
enum class DriverLayout { kOuster, kGazebo };
constexpr auto words_of(DriverLayout) { return std::array{"ouster", "gazebo"}; }

/// The parts of a sensor_msgs/PointCloud2.
struct EncodedCloud {
  std::uint32_t height = 0;
  std::uint32_t width = 0;
  std::uint32_t point_step = 0;
  bool is_dense = false;
  std::vector<voxnav::cloud::CloudField> fields;
  std::vector<std::uint8_t> data;
};

/// Returns the organised cloud of a scan. The field `ring` holds the row; `ambient` is not simulated and always 0.
EncodedCloud encode(const LidarScan& scan, DriverLayout layout);

}  // namespace voxnav_simulation
