// SPDX-License-Identifier: BSD-3-Clause
#include "flights.hpp"

#include <cmath>
#include <cstdio>
#include <fstream>
#include <sstream>

#include "voxnav_simulation/lidar_model.hpp"

namespace voxnav::benchmark {
namespace {

using geometry::Pose;
using geometry::Vec3;
using voxnav_simulation::LidarModel;
using voxnav_simulation::LidarScan;
using voxnav_simulation::Scene;

constexpr double kStep_m = 0.3;
constexpr double kHeight_m = 2.0;

double room_at(const Scene& scene, double x, double y) {
  const double ground = scene.world().ground_height(x, y).value_or(0.0);
  return scene.clearance({x, y, ground + kHeight_m}, 1.5) - 0.01 * std::abs(y);
}

/// Returns a path straight ahead that avoids trunks sideways.
std::vector<Pose> path_through(const Scene& scene, int num_scans) {
  std::vector<Pose> out;
  double y = 0.0;
  for (int i = 0; i < num_scans; ++i) {
    const double x = kStep_m * i;
    double best = y;
    for (const double candidate : {y - 0.15, y + 0.15}) {
      if (room_at(scene, x + 1.0, candidate) > room_at(scene, x + 1.0, best)) best = candidate;
    }
    y = best;
    const double yaw = 0.2 * std::sin(0.1 * i), tilt = 0.05 * std::sin(0.23 * i);
    Pose T_W_L = Pose::Identity();
    T_W_L.translation() = Vec3(x, y, scene.world().ground_height(x, y).value_or(0.0) + kHeight_m);
    T_W_L.linear() =
        (Eigen::AngleAxisd(yaw, Vec3::UnitZ()) * Eigen::AngleAxisd(tilt, Vec3::UnitY())).toRotationMatrix();
    out.push_back(T_W_L);
  }
  return out;
}

FlightScan scan_of(const LidarScan& noisy, const LidarScan& exact, const Pose& T_W_L) {
  FlightScan out;
  out.T_W_L = T_W_L;
  for (std::size_t i = 0; i < noisy.points.size(); ++i) {
    if (noisy.labels[i] >= voxnav_simulation::kNumSurfaceClasses || exact.labels[i] != noisy.labels[i]) continue;
    const auto& p = noisy.points[i];
    out.points.insert(out.points.end(), p.begin(), p.begin() + 3);
    const auto& q = exact.points[i];
    out.true_points_W.emplace_back((T_W_L * Vec3(q[0], q[1], q[2])).cast<float>());
    out.classes.push_back(noisy.labels[i]);
  }
  return out;
}

FlightScan read_scan(const std::string& path) {
  FlightScan out;
  std::ifstream file(path, std::ios::binary);
  float row[4];
  while (file.read(reinterpret_cast<char*>(row), sizeof(row))) out.points.insert(out.points.end(), row, row + 3);
  return out;
}

}  // namespace

Flight fly_forest(const Scene& scene, std::uint64_t seed, int num_scans) {
  voxnav_simulation::LidarConfig config;
  config.ghost_ratio = 0.0;
  const LidarModel lidar(config, seed);
  config.range_noise_m = 0.0;
  config.dropout_ratio = 0.0;
  const LidarModel ideal(config, seed);
  Flight out{"forest " + std::to_string(seed), {}};
  std::uint64_t index = 0;
  for (const Pose& T_W_L : path_through(scene, num_scans)) {
    const std::vector<Pose> poses(static_cast<std::size_t>(config.columns), T_W_L);
    out.scans.push_back(scan_of(lidar.scan(scene, poses, index), ideal.scan(scene, poses, index), T_W_L));
    ++index;
  }
  return out;
}

Flight read_recording(const std::string& dir, const std::string& poses_file, int num_scans) {
  Flight out{dir.substr(dir.find_last_of('/') + 1), {}};
  std::ifstream poses(dir + "/" + poses_file);
  std::string line;
  while (static_cast<int>(out.scans.size()) < num_scans && std::getline(poses, line)) {
    if (line.empty() || line[0] == '#') continue;
    std::istringstream row(line);
    double t = 0, x = 0, y = 0, z = 0, qx = 0, qy = 0, qz = 0, qw = 1;
    row >> t >> x >> y >> z >> qx >> qy >> qz >> qw;
    char name[32];
    std::snprintf(name, sizeof(name), "/scans/%06d.bin", static_cast<int>(out.scans.size()));
    FlightScan scan = read_scan(dir + name);
    if (scan.points.empty()) break;
    scan.T_W_L.setIdentity();
    scan.T_W_L.linear() = Eigen::Quaterniond(qw, qx, qy, qz).normalized().toRotationMatrix();
    scan.T_W_L.translation() = Vec3(x, y, z);
    out.scans.push_back(std::move(scan));
  }
  return out;
}

}  // namespace voxnav::benchmark
