// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav_simulation/lidar_config.hpp"

#include <map>

#include "sensor_mount.hpp"

namespace voxnav_simulation {
namespace {

constexpr double kDegree = M_PI / 180.0;
constexpr std::size_t kMaxBeams = 256;
constexpr std::size_t kCapsuleNumbers = 7;
constexpr std::size_t kMaxCapsules = 100;

/// The number of beams and the vertical field of view over which they are spaced evenly.
struct BeamTable {
  int beams;
  double vertical_fov_rad;
};
// The figures are from data sheets; those of the OS1-16, which MRS UAVs carry, from that of Ouster's first generation.
const std::map<BeamModel, BeamTable> kBeamTables{
    {BeamModel::kOs0With128, {128, 90.0 * kDegree}}, {BeamModel::kOs0With64, {64, 90.0 * kDegree}},
    {BeamModel::kOs0With32, {32, 90.0 * kDegree}},   {BeamModel::kOs1With16, {16, 33.2 * kDegree}},
    {BeamModel::kOs1With64, {64, 33.2 * kDegree}},   {BeamModel::kVlp16, {16, 30.0 * kDegree}},
};

}  // namespace

std::vector<std::string> LidarConfig::problems() const {
  std::vector<std::string> out;
  const bool is_custom = model == BeamModel::kCustom;
  if (is_custom && (beam_elevations_rad.empty() || beam_elevations_rad.size() > kMaxBeams)) {
    out.emplace_back("beam_elevations_rad must hold 1 to 256 beams when model is custom");
  }
  if (!is_custom && !beam_elevations_rad.empty()) out.emplace_back("beam_elevations_rad is only for model custom");
  if (min_range_m >= max_range_m) out.emplace_back("min_range_m must be below max_range_m");
  if (ghost_ratio > 0 && ghost_max_range_m <= min_range_m) {
    out.emplace_back("ghost_max_range_m must exceed min_range_m");
  }
  if (speckle_ratio > 0 && speckle_max_range_m <= min_range_m) {
    out.emplace_back("speckle_max_range_m must exceed min_range_m");
  }
  if (body_capsules_m.size() % kCapsuleNumbers != 0 || body_capsules_m.size() > kMaxCapsules * kCapsuleNumbers) {
    out.emplace_back("body_capsules_m must hold seven numbers per capsule, at most 100 capsules");
  }
  for (std::size_t i = kCapsuleNumbers - 1; i < body_capsules_m.size(); i += kCapsuleNumbers) {
    if (body_capsules_m[i] <= 0.0) out.emplace_back("body_capsules_m: every radius must be positive");
  }
  return out;
}

std::vector<double> LidarConfig::elevations_rad() const {
  if (model == BeamModel::kCustom) return beam_elevations_rad;
  const BeamTable& table = kBeamTables.at(model);
  std::vector<double> out;
  out.reserve(static_cast<std::size_t>(table.beams));
  for (int i = 0; i < table.beams; ++i) out.push_back(table.vertical_fov_rad * (0.5 - i / (table.beams - 1.0)));
  return out;
}

Pose LidarConfig::T_B_L() const { return sensor_mount(mount_position_m, mount_rpy_rad); }

}  // namespace voxnav_simulation
