// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "voxnav/geometry/pose.hpp"
#include "voxnav_simulation/scene.hpp"

namespace voxnav::benchmark {

/// A scan with the points that it would have measured without noise.
struct FlightScan {
  geometry::Pose T_W_L;
  std::vector<float> points;                   ///< x, y, z of each return in the sensor frame
  std::vector<geometry::Vec3f> true_points_W;  ///< points of the same returns without noise; empty for recordings
  std::vector<std::uint8_t> classes;           ///< voxnav_simulation::SurfaceClass of each return
};

/// The scans of a sensor that moves at 3 m/s and measures at 10 Hz. Each scan is measured from one pose, so that none
/// needs deskewing.
struct Flight {
  std::string name;
  std::vector<FlightScan> scans;
};

/// Returns the scans of an OS0-128 between the trees of a simulated forest. Returns from the UAV itself and ghosts are
/// left out, because the cloud filter removes them in flight.
Flight fly_forest(const voxnav_simulation::Scene& scene, std::uint64_t seed, int num_scans);

/// Reads a folder with scans/%06d.bin and poses in TUM format. The flight is empty if the folder does not exist.
Flight read_recording(const std::string& dir, const std::string& poses_file, int num_scans);

}  // namespace voxnav::benchmark
