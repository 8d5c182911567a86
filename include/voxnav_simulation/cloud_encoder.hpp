// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "voxnav/cloud/cloud_layout.hpp"
#include "voxnav_simulation/lidar_scan.hpp"

namespace voxnav_simulation {

/// The two layouts users meet: the MRS fork of the Ouster driver (48 bytes per point, aligned, with times), and the
/// MRS Gazebo plugin (29 bytes, packed, times zero). Both mark "no return" with (0, 0, 0).
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

/// Organised cloud of a scan. `ring` is the row; `ambient` is not simulated and 0.
EncodedCloud encode(const LidarScan& scan, DriverLayout layout);

}  // namespace voxnav_simulation
