// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/planning/obstacle_sectors.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace voxnav::planning {
namespace {

using geometry::Index3;
using geometry::Vec3;

constexpr double kTurn_rad = 6.283185307179586;
/// A sector without an obstacle is known if at least this share of its volume is.
constexpr double kKnownShare = 0.5;

/// Sees the voxels of a map from a vehicle.
class SectorScan {
 public:
  SectorScan(const ObstacleSectorsConfig& config, double resolution_m, const Vec3& position, double heading_rad)
      : config_(config),
        resolution_m_(resolution_m),
        position_(position),
        heading_rad_(heading_rad),
        sine_(std::sin(0.5 * config.vertical_fov_rad)),
        sectors_(static_cast<std::size_t>(config.num_horizontal) + 2),
        num_known_(sectors_.size(), 0) {}

  void add(const Index3& block, const StateBlock& states) {
    for (int offset = 0; offset < geometry::kBlockVolume; ++offset) {
      const VoxelState state = states.get(offset);
      if (state != VoxelState::kUnknown) add(geometry::voxel_at(block, offset), state);
    }
  }

  std::vector<ObstacleSector> take() {
    const double voxel_m3 = std::pow(resolution_m_, 3);
    for (std::size_t i = 0; i < sectors_.size(); ++i) {
      sectors_[i].is_known = sectors_[i].has_obstacle || num_known_[i] * voxel_m3 >= kKnownShare * volume_m3(i);
    }
    return std::move(sectors_);
  }

 private:
  void add(const Index3& voxel, VoxelState state) {
    const Vec3 way = geometry::center_of(voxel, resolution_m_) - position_;
    const double middle_m = way.norm();
    if (middle_m < config_.body_radius_m || middle_m == 0.0) return;
    const double half_m = 0.5 * resolution_m_;
    const double distance_m = (way.cwiseAbs().array() - half_m).max(0.0).matrix().norm();
    if (distance_m > config_.max_range_m) return;
    const std::size_t number = sector_of(way, middle_m);
    ObstacleSector& sector = sectors_[number];
    ++num_known_[number];
    if (state != VoxelState::kOccupied || (sector.has_obstacle && sector.distance_m <= distance_m)) return;
    sector.has_obstacle = true;
    sector.distance_m = distance_m;
  }

  std::size_t sector_of(const Vec3& way, double length_m) const {
    const auto count = static_cast<std::size_t>(config_.num_horizontal);
    if (way.z() < -sine_ * length_m) return count;
    if (way.z() > sine_ * length_m) return count + 1;
    const double size_rad = kTurn_rad / config_.num_horizontal;
    const double turns = (std::atan2(way.y(), way.x()) - heading_rad_ + 0.5 * size_rad) / kTurn_rad;
    const auto index = static_cast<std::size_t>((turns - std::floor(turns)) * config_.num_horizontal);
    return std::min(index, count - 1);
  }

  /// The part of the ball around the vehicle that a sector takes, without the vehicle itself.
  double volume_m3(std::size_t sector) const {
    const bool is_horizontal = sector < static_cast<std::size_t>(config_.num_horizontal);
    const double solid_angle =
        is_horizontal ? 2.0 * sine_ * kTurn_rad / config_.num_horizontal : kTurn_rad * (1.0 - sine_);
    return solid_angle * (std::pow(config_.max_range_m, 3) - std::pow(config_.body_radius_m, 3)) / 3.0;
  }

  const ObstacleSectorsConfig& config_;
  double resolution_m_;
  Vec3 position_;
  double heading_rad_, sine_;
  std::vector<ObstacleSector> sectors_;
  std::vector<int> num_known_;  ///< voxels of each sector within range
};

}  // namespace

std::vector<std::string> ObstacleSectorsConfig::problems() const {
  if (body_radius_m < max_range_m) return {};
  return {"body_radius_m must be below max_range_m"};
}

std::vector<ObstacleSector> obstacle_sectors(const ObstacleSectorsConfig& config, const OccupancyView& view,
                                             const Vec3& position, double heading_rad) {
  if (!position.allFinite() || !std::isfinite(heading_rad)) {
    throw std::invalid_argument("position and heading must be finite");
  }
  SectorScan scan(base::checked(config), view.resolution_m(), position, heading_rad);
  const double block_m = geometry::kBlockSide * view.resolution_m();
  StateBlock scratch;
  const Vec3 reach = Vec3::Constant(config.max_range_m + view.resolution_m());
  const Index3 low = geometry::index_of(position - reach, block_m),
               high = geometry::index_of(position + reach, block_m);
  for (std::int32_t z = low.z; z <= high.z; ++z) {
    for (std::int32_t y = low.y; y <= high.y; ++y) {
      for (std::int32_t x = low.x; x <= high.x; ++x) {
        if (const StateBlock* states = view.block({x, y, z}, &scratch)) scan.add({x, y, z}, *states);
      }
    }
  }
  return scan.take();
}

}  // namespace voxnav::planning
