// SPDX-License-Identifier: BSD-3-Clause
// What limits of the flight add to the update of the planner's clearance field: none, fences, heights above the
// terrain. A forest of 80 x 80 m on rolling ground, of which a scan has changed the blocks around the vehicle. Prints
// CPU times.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <functional>
#include <random>

#include "box_grid.hpp"
#include "voxnav/pipeline/navigation_map.hpp"
#include "voxnav/planning/clearance_field.hpp"
#include "voxnav/planning/fences.hpp"

using namespace voxnav;  // NOLINT: benchmark
using containers::VoxelState;
using geometry::Index3;
using geometry::Vec3;

namespace {

constexpr double kResolution = 0.4;
constexpr int kSide = 200;  ///< voxels along an edge of the map
constexpr int kScan = 80;   ///< voxels along an edge of what a scan changes
constexpr int kNumScans = 60;

double cpu_ms() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) * 1e3 + static_cast<double>(now.tv_nsec) * 1e-6;
}

int ground(int x, int y) { return static_cast<int>(std::lround(6.0 + 5.0 * std::sin(0.04 * x) * std::cos(0.03 * y))); }

std::shared_ptr<containers::StateGrid> forest(std::mt19937* random) {
  auto grid = test::box_grid({0, 0, 0}, {kSide - 1, kSide - 1, 40}, kResolution);
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      test::fill(grid.get(), {x, y, 0}, {x, y, ground(x, y)}, VoxelState::kUnknown);
      grid->set({x, y, ground(x, y)}, VoxelState::kOccupied);
    }
  }
  for (int i = 0; i < 400; ++i) {
    const int x = static_cast<int>((*random)() % kSide), y = static_cast<int>((*random)() % kSide);
    test::fill(grid.get(), {x, y, ground(x, y)}, {x, y, ground(x, y) + 25}, VoxelState::kOccupied);
  }
  return grid;
}

/// Lets some voxels around the middle change their state, the ground's surface among them, as noise does.
std::vector<Index3> change(containers::StateGrid* grid, std::mt19937* random) {
  std::vector<Index3> blocks;
  for (int i = 0; i < 300; ++i) {
    const auto near = [&] { return (kSide - kScan) / 2 + static_cast<int>((*random)() % kScan); };
    const int x = near(), y = near(), z = ground(x, y) + static_cast<int>((*random)() % 8);
    grid->set({x, y, z}, (*random)() % 2 == 0 ? VoxelState::kFree : VoxelState::kOccupied);
    blocks.push_back(geometry::block_of({x, y, z}));
  }
  std::sort(blocks.begin(), blocks.end());
  blocks.erase(std::unique(blocks.begin(), blocks.end()), blocks.end());
  return blocks;
}

std::shared_ptr<const planning::Fences> fences() {
  const auto square = [](double low, double high) {
    return std::vector<Eigen::Vector2d>{{low, low}, {high, low}, {high, high}, {low, high}};
  };
  const planning::Prism area{square(4.0, 76.0), -2.0, 15.0};
  std::vector<planning::Prism> zones;
  for (const double at : {10.0, 24.0, 50.0, 64.0}) zones.push_back({square(at, at + 6.0), 0.0, 12.0});
  return std::make_shared<planning::Fences>(area, zones);
}

void measure(const char* name, const pipeline::NavigationMapConfig& config, bool has_fences) {
  std::mt19937 random(1);
  const auto grid = forest(&random);
  pipeline::NavigationMap map(config);
  std::uint32_t sequence = 1;
  map.apply_local(containers::snapshot_of(*grid), sequence, kResolution);
  map.set_T_W_O(geometry::Pose::Identity());
  map.set_vehicle({40, 40, 6});
  if (has_fences) map.set_fences(fences());
  planning::ClearanceFieldConfig field_config;
  field_config.safety_distance_m = 1.2;
  field_config.radius_m = 2.0;
  field_config.unknown_is_flyable = true;
  planning::ClearanceField field(field_config);
  std::vector<double> times_ms;
  for (int scan = 0; scan <= kNumScans; ++scan) {
    const double begin_ms = cpu_ms();
    field.update(*map.view());
    times_ms.push_back(cpu_ms() - begin_ms);
    map.apply_local(containers::changes_of(*grid, change(grid.get(), &random)), ++sequence, kResolution);
  }
  const double first_ms = times_ms.front();
  std::sort(times_ms.begin(), times_ms.end() - 1);
  std::printf("| %s | %.1f | %.2f | %.2f | %zu |\n", name, first_ms, times_ms[times_ms.size() / 2],
              times_ms[times_ms.size() * 95 / 100], field.num_blocks());
}

}  // namespace

int main() {
  std::printf("| limits | first update [CPU ms] | median | p95 | blocks of the field |\n|---|---|---|---|---|\n");
  pipeline::NavigationMapConfig config;
  measure("none", config, false);
  measure("fences", config, true);
  config.min_height_m = 2.0;
  measure("least height", config, false);
  config.max_height_m = 8.0;
  measure("both heights", config, false);
  measure("both heights and fences", config, true);
}
