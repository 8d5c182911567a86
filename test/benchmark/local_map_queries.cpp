// SPDX-License-Identifier: BSD-3-Clause
// Measures queries of a local map of an analytic forest at 0.4 m, its outputs, and moves of its window, beside OctoMap
// where that has the same. Items per second are queries per second where there are queries.
#include <benchmark/benchmark.h>
#include <octomap/octomap.h>

#include <algorithm>
#include <chrono>
#include <sstream>

#include "local_map/analytic_scan.hpp"
#include "octomap_insertion.hpp"
#include "voxnav/occupancy/local_map.hpp"
#include "voxnav/occupancy/octomap_export.hpp"

using namespace voxnav;  // NOLINT: benchmark
using voxnav::benchmark::position;
using voxnav::benchmark::scan;

namespace {

using geometry::Vec3;

geometry::Pose sensor_at(const Vec3& place) {
  geometry::Pose T_W_L = geometry::Pose::Identity();
  T_W_L.translation() = place;
  return T_W_L;
}

occupancy::LocalMap make_map() {
  occupancy::LocalMap map{occupancy::LocalMapConfig{}};
  for (int i = 0; i < 5; ++i) map.insert(geometry::view_of_rows(scan()), sensor_at(position(i)));
  return map;
}

octomap::OcTree make_octree() {
  octomap::OcTree tree(0.4);
  for (int i = 0; i < 5; ++i) {
    tree.insertPointCloud(test::octomap_cloud(scan(), position(i)), test::octomap_point(position(i)), 26.0, false,
                          true);
  }
  return tree;
}

/// Returns random places in the part of the forest that was seen.
const std::vector<Vec3>& places() {
  static const std::vector<Vec3> out = [] {
    std::mt19937 rng(3);
    std::uniform_real_distribution<double> flat(-25.0, 25.0), height(0.0, 10.0);
    std::vector<Vec3> made(4096);
    for (Vec3& place : made) place = Vec3{flat(rng), flat(rng), height(rng)};
    return made;
  }();
  return out;
}

template <class Ask>
void ask(::benchmark::State& state, Ask one) {
  std::size_t i = 0;
  for (auto _ : state) ::benchmark::DoNotOptimize(one(places()[i++ % places().size()]));
  state.SetItemsProcessed(static_cast<std::int64_t>(state.iterations()));
}

void point_state(::benchmark::State& state) {
  const auto map = make_map();
  ask(state, [&](const Vec3& p) { return map.state(p); });
}

void point_octomap(::benchmark::State& state) {
  const auto tree = make_octree();
  ask(state, [&](const Vec3& p) { return tree.search(p.x(), p.y(), p.z()); });
}

void box_of_2_m(::benchmark::State& state) {
  const auto map = make_map();
  ask(state, [&](const Vec3& p) { return map.box_state({p - Vec3::Constant(1.0), p + Vec3::Constant(1.0)}); });
}

void nearest_within_3_m(::benchmark::State& state) {
  const auto map = make_map();
  ask(state, [&](const Vec3& p) { return map.nearest_occupied(p, 3.0).has_value(); });
}

void ray_of_20_m(::benchmark::State& state) {
  const auto map = make_map();
  const Vec3 sensor(0.0, 0.0, 2.0);
  ask(state,
      [&](const Vec3& p) { return map.ray_cast(sensor, sensor + 20.0 * (p - sensor).normalized(), true).range_m; });
}

void ray_octomap(::benchmark::State& state) {
  const auto tree = make_octree();
  const octomap::point3d sensor(0.0f, 0.0f, 2.0f);
  ask(state, [&](const Vec3& p) {
    octomap::point3d end;
    const octomap::point3d target(static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z()));
    return tree.castRay(sensor, target - sensor, end, true, 20.0);
  });
}

void corridor_60_m(::benchmark::State& state) {
  const auto map = make_map();
  for (auto _ : state) ::benchmark::DoNotOptimize(map.corridor_state({-30, 0.3, 2}, {30, 1.0, 2.5}, 0.8));
}

void occupied_points(::benchmark::State& state) {
  const auto map = make_map();
  for (auto _ : state) ::benchmark::DoNotOptimize(map.occupied_points());
  state.counters["points"] = static_cast<double>(map.occupied_points().size()) / 3.0;
}

/// Measures the data of an OctoMap message of the whole map.
template <bool kIsBinary>
void octomap_message(::benchmark::State& state) {
  const auto map = make_map();
  for (auto _ : state) ::benchmark::DoNotOptimize(occupancy::octomap_message_data(map, kIsBinary));
  state.counters["bytes"] = static_cast<double>(occupancy::octomap_message_data(map, kIsBinary).size());
}

/// Measures the same bytes made by OctoMap itself, as a program that has the voxels of the map would.
void octomap_message_by_octomap(::benchmark::State& state) {
  const auto map = make_map();
  for (auto _ : state) {
    octomap::OcTree tree(map.config().resolution_m);
    map.for_known([&](const occupancy::LocalMap::KnownVoxel& voxel) {
      const Vec3 center = geometry::center_of(voxel.index, map.config().resolution_m);
      tree.setNodeValue(center.x(), center.y(), center.z(), static_cast<float>(voxel.log_odds), true);
    });
    tree.updateInnerOccupancy();
    tree.prune();
    std::stringstream bytes;
    tree.writeData(bytes);
    ::benchmark::DoNotOptimize(bytes.str());
  }
}

/// Measures an empty scan that moves the window by a block, whose evicted content is made for the handover.
void window_move(::benchmark::State& state) {
  auto map = make_map();
  const double step_m = 16 * map.config().resolution_m;
  double x = 0.0, longest_s = 0.0;
  for (auto _ : state) {
    state.PauseTiming();
    if (x > 30.0) {
      map = make_map();
      x = 0.0;
    }
    x += step_m;
    state.ResumeTiming();
    const auto begin = std::chrono::steady_clock::now();
    map.insert({}, sensor_at({x, 0.0, 2.0}));
    longest_s = std::max(longest_s, std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
    state.PauseTiming();
    map.take_evicted();
    state.ResumeTiming();
  }
  state.counters["longest_ms"] = 1e3 * longest_s;
}

BENCHMARK(point_state);
BENCHMARK(point_octomap);
BENCHMARK(box_of_2_m);
BENCHMARK(nearest_within_3_m);
BENCHMARK(ray_of_20_m);
BENCHMARK(ray_octomap);
BENCHMARK(corridor_60_m)->Unit(::benchmark::kMicrosecond);
BENCHMARK(occupied_points)->Unit(::benchmark::kMicrosecond);
BENCHMARK_TEMPLATE(octomap_message, false)->Unit(::benchmark::kMillisecond);
BENCHMARK_TEMPLATE(octomap_message, true)->Unit(::benchmark::kMillisecond);
BENCHMARK(octomap_message_by_octomap)->Unit(::benchmark::kMillisecond);
BENCHMARK(window_move)->Unit(::benchmark::kMicrosecond)->Iterations(40);

}  // namespace
