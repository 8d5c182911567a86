// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pybind11/numpy.h>

#include <vector>

#include "voxnav/odometry/lidar_odometry.hpp"

namespace voxnav::bindings {

/// stamps (n,) seconds as float64 or nanoseconds as int64, gyro (n, 3) and accel (n, 3) float64.
std::vector<odometry::ImuSample> imu_samples_of(const pybind11::array& stamps, const pybind11::array& gyro,
                                                const pybind11::array& accel);

}  // namespace voxnav::bindings
