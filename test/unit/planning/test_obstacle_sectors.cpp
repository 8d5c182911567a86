// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "voxnav/planning/obstacle_sectors.hpp"

using namespace voxnav;  // NOLINT: test
using containers::VoxelState;
using geometry::Index3;
using geometry::Vec3;
using planning::ObstacleSector;
using planning::ObstacleSectorsConfig;

namespace {

constexpr double kResolution_m = 0.4;
constexpr double kPi = 3.14159265358979323846;

std::shared_ptr<containers::StateGrid> grid_of(const std::vector<std::pair<Vec3, VoxelState>>& voxels) {
  auto grid = std::make_shared<containers::StateGrid>(kResolution_m);
  for (const auto& [point, state] : voxels) grid->set(geometry::index_of(point, kResolution_m), state);
  return grid;
}

std::vector<ObstacleSector> sectors_of(const std::shared_ptr<containers::StateGrid>& grid, const Vec3& position,
                                       double heading_rad, const ObstacleSectorsConfig& config = {}) {
  return planning::obstacle_sectors(config, planning::StateGridView(grid), position, heading_rad);
}

/// Finds the sector by comparing the angles with the bounds of each, one after the other.
std::size_t sector_by_bounds(const ObstacleSectorsConfig& config, const Vec3& way, double heading_rad) {
  const double elevation = std::atan2(way.z(), std::hypot(way.x(), way.y()));
  if (elevation < -0.5 * config.vertical_fov_rad) return config.num_horizontal;
  if (elevation > 0.5 * config.vertical_fov_rad) return config.num_horizontal + 1;
  const double azimuth = std::atan2(way.y(), way.x()) - heading_rad;
  for (int i = 0; i < config.num_horizontal; ++i) {
    const double middle = i * 2.0 * kPi / config.num_horizontal;
    if (std::abs(std::remainder(azimuth - middle, 2.0 * kPi)) <= kPi / config.num_horizontal) return i;
  }
  ADD_FAILURE() << "no sector";
  return 0;
}

}  // namespace

TEST(ObstacleSectors, AreCountedCounterClockwiseFromAheadThenBelowAndAbove) {
  const Vec3 at(0.2, 0.2, 0.2);
  const std::vector<std::pair<Vec3, std::size_t>> places = {{{4, 0, 0}, 0},  {{0, 4, 0}, 2},  {{-4, 0, 0}, 4},
                                                            {{0, -4, 0}, 6}, {{0, 0, -4}, 8}, {{0, 0, 4}, 9}};
  for (const auto& [way, sector] : places) {
    const auto found = sectors_of(grid_of({{at + way, VoxelState::kOccupied}}), at, 0.0);
    ASSERT_EQ(found.size(), 10u);
    for (std::size_t i = 0; i < found.size(); ++i) EXPECT_EQ(found[i].has_obstacle, i == sector) << i;
    EXPECT_NEAR(found[sector].distance_m, 3.8, 1e-9);  // to the face of the voxel
  }
}

TEST(ObstacleSectors, TurnWithTheVehicle) {
  const auto grid = grid_of({{Vec3(0, 4, 0), VoxelState::kOccupied}});
  EXPECT_TRUE(sectors_of(grid, Vec3::Zero(), 0.5 * kPi)[0].has_obstacle);
  EXPECT_TRUE(sectors_of(grid, Vec3::Zero(), kPi)[6].has_obstacle);
}

TEST(ObstacleSectors, AFewFreeVoxelsDoNotMakeAFreeSector) {
  const auto found = sectors_of(grid_of({{Vec3(3, 0, 0), VoxelState::kFree}}), Vec3::Zero(), 0.0);
  for (const ObstacleSector& sector : found) EXPECT_FALSE(sector.is_known || sector.has_obstacle);
}

TEST(ObstacleSectors, AreKnownWhereMostOfTheirSpaceIsKnown) {
  for (const double depth_m : {4.0, 6.0, 9.0, 11.0}) {  // half of the volume lies within 0.79 of the range
    const int side = static_cast<int>(depth_m / kResolution_m);
    auto grid = std::make_shared<containers::StateGrid>(kResolution_m);
    for (int z = -side; z <= side; ++z) {
      for (int y = -side; y <= side; ++y) {
        for (int x = -side; x <= side; ++x) {
          const Vec3 center = geometry::center_of(Index3{x, y, z}, kResolution_m);
          if (center.norm() <= depth_m) grid->set({x, y, z}, VoxelState::kFree);
        }
      }
    }
    for (const ObstacleSector& sector : sectors_of(grid, Vec3::Zero(), 0.3)) {
      EXPECT_EQ(sector.is_known, depth_m > 8.0) << depth_m;
      EXPECT_FALSE(sector.has_obstacle);
    }
  }
}

TEST(ObstacleSectors, TheVehicleItselfAndWhatIsFarAreLeftOut) {
  const auto grid = grid_of({{Vec3(0.1, 0.1, 0.1), VoxelState::kOccupied}, {Vec3(11, 0, 0), VoxelState::kOccupied}});
  for (const ObstacleSector& sector : sectors_of(grid, Vec3(0.1, 0.1, 0.1), 0.0)) EXPECT_FALSE(sector.has_obstacle);
}

TEST(ObstacleSectors, EqualThoseOfAllVoxelsOneByOne) {
  std::mt19937 random(17);
  std::uniform_real_distribution<double> place(-12.0, 12.0), angle(-7.0, 7.0);
  for (int trial = 0; trial < 20; ++trial) {
    ObstacleSectorsConfig config;
    config.num_horizontal = 1 + static_cast<int>(random() % 12);
    std::vector<std::pair<Vec3, VoxelState>> voxels;
    voxels.reserve(60);
    for (int i = 0; i < 60; ++i) {
      voxels.emplace_back(Vec3(place(random), place(random), place(random)),
                          random() % 3 == 0 ? VoxelState::kOccupied : VoxelState::kFree);
    }
    const auto grid = grid_of(voxels);
    const Vec3 at(0.3 * place(random), 0.3 * place(random), 0.3 * place(random));
    const double heading_rad = angle(random);
    std::vector<ObstacleSector> expected(config.num_horizontal + 2);
    for (const auto& [index, block] : grid->blocks()) {
      for (int offset = 0; offset < geometry::kBlockVolume; ++offset) {
        const VoxelState state = block.get(offset);
        if (state == VoxelState::kUnknown) continue;
        const Vec3 way = geometry::center_of(geometry::voxel_at(index, offset), kResolution_m) - at;
        const Vec3 nearest(std::max(0.0, std::abs(way.x()) - 0.2), std::max(0.0, std::abs(way.y()) - 0.2),
                           std::max(0.0, std::abs(way.z()) - 0.2));
        if (way.norm() < config.body_radius_m || nearest.norm() > config.max_range_m) continue;
        ObstacleSector& sector = expected[sector_by_bounds(config, way, heading_rad)];
        if (state != VoxelState::kOccupied) continue;
        sector.is_known = true;
        sector.distance_m = sector.has_obstacle ? std::min(sector.distance_m, nearest.norm()) : nearest.norm();
        sector.has_obstacle = true;
      }
    }
    const auto found = sectors_of(grid, at, heading_rad, config);
    for (std::size_t i = 0; i < expected.size(); ++i) {
      EXPECT_EQ(found[i].is_known, expected[i].is_known) << trial << " " << i;
      EXPECT_EQ(found[i].has_obstacle, expected[i].has_obstacle) << trial << " " << i;
      EXPECT_NEAR(found[i].distance_m, expected[i].distance_m, 1e-9);
    }
  }
}

TEST(ObstacleSectors, RefusesPlacesThatAreNone) {
  const auto grid = grid_of({});
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(sectors_of(grid, Vec3(nan, 0, 0), 0.0), std::invalid_argument);
  EXPECT_THROW(sectors_of(grid, Vec3::Zero(), nan), std::invalid_argument);
  ObstacleSectorsConfig config;
  config.body_radius_m = 5.0;
  config.max_range_m = 2.0;
  EXPECT_THROW(sectors_of(grid, Vec3::Zero(), 0.0, config), base::ConfigError);
}
