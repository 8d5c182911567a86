// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "voxnav/geometry/pose.hpp"
#include "voxnav_simulation/scene.hpp"

namespace voxnav::benchmark {

/// One scan with what it should have measured.
struct FlightScan {
  geometry::Pose T_W_L;
  std::vector<float> points;                   ///< x y z per return, sensor frame
  std::vector<geometry::Vec3f> true_points_W;  ///< of the same returns without noise; empty for recordings
  std::vector<std::uint8_t> classes;           ///< voxnav_simulation::SurfaceClass of each return
};

/// A sensor on its way at 3 m/s and 10 Hz; each scan is measured from one place, so that nothing needs deskewing.
struct Flight {
  std::string name;
  std::vector<FlightScan> scans;
};

/// OS0-128 between the trees of a simulated forest, without returns from the UAV itself and ghosts, which the cloud
/// filter removes.
Flight fly_forest(const voxnav_simulation::Scene& scene, std::uint64_t seed, int num_scans);

/// A folder with scans/%06d.bin and TUM poses. Empty when there is none.
Flight read_recording(const std::string& dir, const std::string& poses_file, int num_scans);

}  // namespace voxnav::benchmark
