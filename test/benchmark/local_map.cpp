// SPDX-License-Identifier: BSD-3-Clause
// Measures the insertion of a scan of 128 x 1024 points of an analytic forest (ground and trunks), beside OctoMap with
// the same points.
#include "voxnav/occupancy/local_map.hpp"

#include <benchmark/benchmark.h>
#include <octomap/octomap.h>

#include "local_map/analytic_scan.hpp"
#include "octomap_insertion.hpp"

using namespace voxnav;  // NOLINT: benchmark
using voxnav::benchmark::position;
using voxnav::benchmark::scan;
using voxnav::test::octomap_cloud;
using voxnav::test::octomap_point;

namespace {

double max_range_m(double resolution_m) { return resolution_m < 0.15 ? 20.0 : 26.0; }

void insert_voxnav(::benchmark::State& state) {
  occupancy::LocalMapConfig config;
  config.resolution_m = static_cast<double>(state.range(0)) / 100.0;
  config.max_range_m = max_range_m(config.resolution_m);
  config.num_threads = static_cast<int>(state.range(1));
  occupancy::LocalMap map(config);
  std::int64_t i = 0;
  for (auto _ : state) {
    geometry::Pose T_W_L = geometry::Pose::Identity();
    T_W_L.translation() = position(i++);
    ::benchmark::DoNotOptimize(map.insert(geometry::view_of_rows(scan()), T_W_L));
  }
  state.counters["points"] = static_cast<double>(scan().size()) / 3.0;
  state.counters["map_mb"] = static_cast<double>(map.memory_bytes()) * 1e-6;
}

void insert_octomap(::benchmark::State& state) {
  const double resolution_m = static_cast<double>(state.range(0)) / 100.0;
  octomap::OcTree tree(resolution_m);
  tree.setProbHit(0.7);
  tree.setProbMiss(0.4);
  std::int64_t i = 0;
  for (auto _ : state) {
    state.PauseTiming();
    const geometry::Vec3 origin = position(i++);
    const octomap::Pointcloud cloud = octomap_cloud(scan(), origin);
    const octomap::point3d sensor = octomap_point(origin);
    state.ResumeTiming();
    tree.insertPointCloud(cloud, sensor, max_range_m(resolution_m), false, true);
  }
}

BENCHMARK(insert_voxnav)->Args({40, 1})->Args({40, 2})->Args({20, 1})->Args({10, 1})->Unit(::benchmark::kMillisecond);
BENCHMARK(insert_octomap)->Arg(40)->Arg(20)->Arg(10)->Unit(::benchmark::kMillisecond);

}  // namespace
