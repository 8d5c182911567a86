// SPDX-License-Identifier: BSD-3-Clause
// Insertion of one 128 x 1024 scan of an analytic forest (ground and trunks), beside OctoMap on the same points.
#include "voxnav/occupancy/local_map.hpp"

#include <benchmark/benchmark.h>
#include <octomap/octomap.h>

#include <cmath>
#include <random>
#include <vector>

using namespace voxnav;  // NOLINT: benchmark

namespace {

struct Trunk {
  double x, y, radius;
};

std::vector<Trunk> trunks() {
  std::mt19937 rng(7);
  std::uniform_real_distribution<double> place(-40.0, 40.0);
  std::uniform_real_distribution<double> radius(0.05, 0.4);
  std::vector<Trunk> out;
  while (out.size() < 190) {
    const Trunk trunk{place(rng), place(rng), radius(rng)};
    if (std::hypot(trunk.x, trunk.y) > 2.0) out.push_back(trunk);
  }
  return out;
}

/// Range along a unit direction from 2 m above the ground; 0 = nothing within 60 m.
double range_of(const geometry::Vec3& direction, const std::vector<Trunk>& forest) {
  double range = direction.z() < 0.0 ? -2.0 / direction.z() : 1e9;
  const double a = direction.x() * direction.x() + direction.y() * direction.y();
  for (const Trunk& t : forest) {
    const double b = direction.x() * t.x + direction.y() * t.y;
    const double discriminant = b * b - a * (t.x * t.x + t.y * t.y - t.radius * t.radius);
    if (b <= 0.0 || discriminant < 0.0) continue;
    const double hit = (b - std::sqrt(discriminant)) / a;
    if (2.0 + hit * direction.z() < 12.0) range = std::min(range, hit);
  }
  return range < 60.0 ? range : 0.0;
}

const std::vector<float>& scan() {
  static const std::vector<float> points = [] {
    std::vector<float> out;
    const std::vector<Trunk> forest = trunks();
    for (int column = 0; column < 1024; ++column) {
      for (int row = 0; row < 128; ++row) {
        const double azimuth = column * (2.0 * M_PI / 1024.0);
        const double elevation = (45.0 - row * (90.0 / 127.0)) * M_PI / 180.0;
        const geometry::Vec3 direction(std::cos(azimuth) * std::cos(elevation), std::sin(azimuth) * std::cos(elevation),
                                       std::sin(elevation));
        const double range = range_of(direction, forest);
        if (range <= 0.0) continue;
        for (int axis = 0; axis < 3; ++axis) out.push_back(static_cast<float>(direction[axis] * range));
      }
    }
    return out;
  }();
  return points;
}

/// A slow flight, so that the map is neither empty nor always the same.
geometry::Vec3 position(std::int64_t i) { return {0.1 * static_cast<double>(i % 50), 0.0, 2.0}; }

double max_range_m(double resolution_m) { return resolution_m < 0.15 ? 20.0 : 26.0; }

void insert_voxnav(benchmark::State& state) {
  occupancy::LocalMapConfig config;
  config.resolution_m = static_cast<double>(state.range(0)) / 100.0;
  config.max_range_m = max_range_m(config.resolution_m);
  config.num_threads = static_cast<int>(state.range(1));
  occupancy::LocalMap map(config);
  std::int64_t i = 0;
  for (auto _ : state) {
    geometry::Pose T_W_L = geometry::Pose::Identity();
    T_W_L.translation() = position(i++);
    benchmark::DoNotOptimize(map.insert(scan().data(), scan().size() / 3, 3, T_W_L));
  }
  state.counters["points"] = static_cast<double>(scan().size()) / 3.0;
  state.counters["map_mb"] = static_cast<double>(map.memory_bytes()) * 1e-6;
}

void insert_octomap(benchmark::State& state) {
  const double resolution_m = static_cast<double>(state.range(0)) / 100.0;
  octomap::OcTree tree(resolution_m);
  tree.setProbHit(0.7);
  tree.setProbMiss(0.4);
  std::int64_t i = 0;
  for (auto _ : state) {
    state.PauseTiming();
    const geometry::Vec3 origin = position(i++);
    octomap::Pointcloud cloud;
    for (std::size_t k = 0; k < scan().size(); k += 3) {
      cloud.push_back(scan()[k] + static_cast<float>(origin.x()), scan()[k + 1] + static_cast<float>(origin.y()),
                      scan()[k + 2] + static_cast<float>(origin.z()));
    }
    const octomap::point3d sensor(static_cast<float>(origin.x()), static_cast<float>(origin.y()),
                                  static_cast<float>(origin.z()));
    state.ResumeTiming();
    tree.insertPointCloud(cloud, sensor, max_range_m(resolution_m), false, true);
  }
}

void corridor_60_m(benchmark::State& state) {
  occupancy::LocalMap map{occupancy::LocalMapConfig{}};
  for (int i = 0; i < 5; ++i) {
    geometry::Pose T_W_L = geometry::Pose::Identity();
    T_W_L.translation() = position(i);
    map.insert(scan().data(), scan().size() / 3, 3, T_W_L);
  }
  for (auto _ : state) benchmark::DoNotOptimize(map.corridor_state({-30, 0.3, 2}, {30, 1.0, 2.5}, 0.8));
}

BENCHMARK(insert_voxnav)->Args({40, 1})->Args({40, 2})->Args({20, 1})->Args({10, 1})->Unit(benchmark::kMillisecond);
BENCHMARK(insert_octomap)->Arg(40)->Arg(20)->Arg(10)->Unit(benchmark::kMillisecond);
BENCHMARK(corridor_60_m)->Unit(benchmark::kMicrosecond);

}  // namespace
