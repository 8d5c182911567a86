// SPDX-License-Identifier: BSD-3-Clause
// Measures submaps of a flight through an analytic forest in CPU time: filling, memory, obstacles, corrections and
// projective integration, with OctoMap on the same cloud for comparison.
#include <benchmark/benchmark.h>
#include <octomap/octomap.h>

#include <limits>

#include "forest_flight.hpp"
#include "octomap_insertion.hpp"
#include "voxnav/submap/obstacle_map.hpp"
#include "voxnav/submap/projective_integrator.hpp"
#include "voxnav/submap/submap_collection.hpp"

using namespace voxnav;  // NOLINT: benchmark

namespace {

constexpr int kSubmaps = 12;
constexpr double kSafetyDistance_m = 1.5;

const std::vector<test::FlownSubmap>& flight() {
  static const std::vector<test::FlownSubmap> submaps = test::forest_flight(kSubmaps);
  return submaps;
}

std::shared_ptr<submap::Submap> filled(std::size_t i) {
  return submap::Submap::from_content(flight()[i].content, flight()[i].T_O_S.inverse(Eigen::Isometry), {});
}

const std::vector<std::shared_ptr<submap::Submap>>& submaps() {
  static const std::vector<std::shared_ptr<submap::Submap>> all = [] {
    std::vector<std::shared_ptr<submap::Submap>> out;
    for (std::size_t i = 0; i < flight().size(); ++i) out.push_back(filled(i));
    return out;
  }();
  return all;
}

submap::SubmapEntry entry_of(std::size_t i, double shift_m = 0.0) {
  submap::SubmapEntry entry;
  entry.id = static_cast<std::uint32_t>(i);
  entry.end_ns = static_cast<base::StampNs>(i);
  entry.T_O_S = flight()[i].T_O_S;
  // The poses are like those after an optimisation: no submap shares the grid of another.
  entry.T_W_S = geometry::from_position_yaw({shift_m, 0.07 * static_cast<double>(i), 0.01 * static_cast<double>(i)},
                                            0.003 * static_cast<double>(i)) *
                entry.T_O_S;
  entry.submap = submaps()[i];
  return entry;
}

struct Map {
  submap::SubmapCollection collection{submap::SubmapCollectionConfig{}};
  submap::ObstacleMap obstacles{0.4, kSafetyDistance_m};
  void update() {
    obstacles.mark_changed(collection.update());
    obstacles.update(collection.evidence(), std::numeric_limits<std::size_t>::max());
    benchmark::DoNotOptimize(obstacles.take_changes());
  }
};

void fill_submap(benchmark::State& state) {
  const std::size_t i = 4;
  flight();
  for (auto _ : state) benchmark::DoNotOptimize(filled(i));
  state.counters["leaves"] = static_cast<double>(flight()[i].content.num_occupied());
  state.counters["blocks"] = static_cast<double>(flight()[i].content.blocks.size());
  state.counters["submap_kb"] = static_cast<double>(submaps()[i]->memory_bytes()) * 1e-3;
  state.counters["file_kb"] = static_cast<double>(submaps()[i]->to_bytes().size()) * 1e-3;
}

/// Measures filling, the surface points, and the distance at every known voxel near a surface.
void fill_and_use_submap(benchmark::State& state) {
  const auto& content = flight()[4].content;
  for (auto _ : state) {
    const auto made = filled(4);
    benchmark::DoNotOptimize(made->surface_points().size());
    double distance = 0.0;
    for (const auto& block : content.blocks) {
      if (block.occupied.empty()) continue;
      const geometry::Vec3 p_O =
          geometry::center_of(geometry::voxel_at(block.index, block.occupied[0].offset), content.resolution_m);
      made->sample(flight()[4].T_O_S.inverse(Eigen::Isometry) * p_O, &distance, nullptr);
    }
  }
}

/// Measures adding a submap to a map of the given size.
void obstacles_of_a_new_submap(benchmark::State& state) {
  const auto size = static_cast<std::size_t>(state.range(0));
  submaps();
  for (auto _ : state) {
    state.PauseTiming();
    Map map;
    for (std::size_t i = 0; i + 1 < size; ++i) map.collection.add(entry_of(i));
    map.update();
    map.collection.add(entry_of(size - 1));
    state.ResumeTiming();
    map.update();
  }
}

/// Measures a correction that moves only the newest submaps.
void correction_of_submaps(benchmark::State& state) {
  Map map;
  for (std::size_t i = 0; i < kSubmaps; ++i) map.collection.add(entry_of(i));
  map.update();
  double shift_m = 0.0;
  for (auto _ : state) {
    shift_m += 0.3;
    for (std::size_t i = kSubmaps - static_cast<std::size_t>(state.range(0)); i < kSubmaps; ++i) {
      map.collection.set_pose(static_cast<std::uint32_t>(i), entry_of(i, shift_m).T_W_S);
    }
    map.update();
  }
  state.counters["map_mb"] = static_cast<double>(map.collection.memory_bytes() + map.obstacles.memory_bytes()) * 1e-6;
}

/// Returns a submap of a flight of 19 minutes and 1.28 km: the flight above is repeated, each time 66 m farther on.
submap::SubmapEntry long_entry(std::size_t i, double shift_m) {
  submap::SubmapEntry entry = entry_of(i % kSubmaps, shift_m);
  entry.id = static_cast<std::uint32_t>(i);
  entry.end_ns = static_cast<base::StampNs>(i);
  const std::size_t lap = i / kSubmaps;
  entry.T_W_S = geometry::from_position_yaw({66.0 * static_cast<double>(lap), 0.0, 0.0}, 0.0) * entry.T_W_S;
  return entry;
}

/// Measures a correction that moves all submaps of the long flight, and one new submap at its end.
void correction_of_a_long_flight(benchmark::State& state) {
  constexpr std::size_t kLong = 111;
  Map map;
  for (std::size_t i = 0; i < kLong; ++i) map.collection.add(long_entry(i, 0.0));
  map.update();
  double shift_m = 0.0;
  for (auto _ : state) {
    shift_m += 0.3;
    for (std::size_t i = 0; i < kLong; ++i) {
      map.collection.set_pose(static_cast<std::uint32_t>(i), long_entry(i, shift_m).T_W_S);
    }
    map.update();
  }
  state.counters["map_mb"] = static_cast<double>(map.collection.memory_bytes() + map.obstacles.memory_bytes()) * 1e-6;
}

void new_submap_in_a_long_flight(benchmark::State& state) {
  constexpr std::size_t kLong = 111;
  Map map;
  for (std::size_t i = 0; i + 1 < kLong; ++i) map.collection.add(long_entry(i, 0.0));
  map.update();
  for (auto _ : state) {
    state.PauseTiming();
    map.collection.remove(kLong - 1);
    map.update();
    map.collection.add(long_entry(kLong - 1, 0.0));
    state.ResumeTiming();
    map.update();
  }
}

void distance_queries(benchmark::State& state) {
  const auto& submap = *submaps()[4];
  std::mt19937 rng(1);
  std::uniform_real_distribution<double> jitter(-1.0, 1.0);
  std::vector<geometry::Vec3> points;
  for (const auto& s : submap.surface_points()) {
    points.emplace_back(s.position.cast<double>() + geometry::Vec3(jitter(rng), jitter(rng), jitter(rng)));
  }
  double distance = 0.0;
  geometry::Vec3 gradient;
  for (auto _ : state) {
    for (const geometry::Vec3& p : points) benchmark::DoNotOptimize(submap.sample(p, &distance, &gradient));
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(points.size()));
}

const std::vector<float>& scan() {
  static const std::vector<float> points = test::forest_scan({20.0, 1.0, 3.0}, 0.0, 600);
  return points;
}

geometry::Pose pose_of(std::int64_t i) {
  return geometry::from_position_yaw({0.1 * static_cast<double>(i % 50), 0.0, 3.0}, 0.0);
}

void integrate_projective(benchmark::State& state, submap::RayRule rule) {
  submap::ProjectiveConfig config;
  config.rule = rule;
  submap::ProjectiveIntegrator integrator(config);
  std::vector<geometry::Vec3f> points;
  for (std::size_t k = 0; k < scan().size(); k += 3) points.emplace_back(scan()[k], scan()[k + 1], scan()[k + 2]);
  std::int64_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(integrator.integrate(points, pose_of(i++)));
  state.counters["points"] = static_cast<double>(points.size());
}

void integrate_octomap(benchmark::State& state) {
  octomap::OcTree tree(0.4);
  std::int64_t i = 0;
  for (auto _ : state) {
    state.PauseTiming();
    const geometry::Vec3 origin = pose_of(i++).translation();
    const octomap::Pointcloud cloud = test::octomap_cloud(scan(), origin);
    const octomap::point3d sensor = test::octomap_point(origin);
    state.ResumeTiming();
    tree.insertPointCloud(cloud, sensor, 26.0, false, true);
  }
}

BENCHMARK(fill_submap)->Unit(benchmark::kMillisecond);
BENCHMARK(fill_and_use_submap)->Unit(benchmark::kMillisecond);
BENCHMARK(obstacles_of_a_new_submap)->Arg(1)->Arg(6)->Arg(12)->Unit(benchmark::kMillisecond);
BENCHMARK(correction_of_submaps)->Arg(1)->Arg(8)->Arg(12)->Unit(benchmark::kMillisecond);
BENCHMARK(correction_of_a_long_flight)->Unit(benchmark::kMillisecond);
BENCHMARK(new_submap_in_a_long_flight)->Unit(benchmark::kMillisecond);
BENCHMARK(distance_queries)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(integrate_projective, simple, submap::RayRule::kSimple)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(integrate_projective, merged, submap::RayRule::kMerged)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(integrate_projective, fast, submap::RayRule::kFast)->Unit(benchmark::kMillisecond);
BENCHMARK(integrate_octomap)->Unit(benchmark::kMillisecond);

}  // namespace
