// SPDX-License-Identifier: BSD-3-Clause
// Measures the insertion time and the accuracy of LocalMap and OctoMap on the same scans, one map after the other, and
// prints them as rows of a Markdown table.
//   benchmark_local_map_table [--seeds=1,2,3] [--scans=60,24,8] [--without-octomap] [--points=DIR]
// With --points it also writes the points of the maps of 0.4 m of the last seed, for scripts/dev/plot_local_map.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <numeric>
#include <sstream>
#include <string>

#include "contestants.hpp"
#include "points_out.hpp"
#include "quality.hpp"

using namespace voxnav::benchmark;  // NOLINT: benchmark

namespace {

constexpr int kLeastScans = 5;  ///< surfaces that were seen less often are not judged

struct Options {
  std::vector<int> seeds{1, 2, 3};
  std::vector<int> scans{60, 24, 8};  ///< per resolution, few at the finest, where OctoMap needs seconds for each
  bool with_octomap = true;
  std::string points_dir;  ///< empty: no points are written
};

struct Setup {
  double resolution_m, max_range_m;
};
constexpr Setup kSetups[] = {{0.4, 26.0}, {0.2, 26.0}, {0.1, 20.0}};

double now_ms(clockid_t clock) {
  timespec t{};
  clock_gettime(clock, &t);
  return 1e3 * static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_nsec);
}

struct Run {
  std::unique_ptr<Contestant> map;
  std::vector<double> cpu_ms, wall_ms;
};

std::vector<int> numbers(const char* text) {
  std::vector<int> out;
  std::istringstream in(text);
  for (std::string item; std::getline(in, item, ',');) out.push_back(std::atoi(item.c_str()));
  return out;
}

Options options_of(int argc, char** argv) {
  Options out;
  for (int i = 1; i < argc; ++i) {
    if (std::strncmp(argv[i], "--seeds=", 8) == 0) out.seeds = numbers(argv[i] + 8);
    if (std::strncmp(argv[i], "--scans=", 8) == 0) out.scans = numbers(argv[i] + 8);
    if (std::strncmp(argv[i], "--points=", 9) == 0) out.points_dir = argv[i] + 9;
    if (std::strcmp(argv[i], "--without-octomap") == 0) out.with_octomap = false;
  }
  out.scans.resize(3, out.scans.empty() ? 8 : out.scans.back());
  return out;
}

double mean(const std::vector<double>& v) {
  return std::accumulate(v.begin(), v.end(), 0.0) / static_cast<double>(std::max<std::size_t>(v.size(), 1));
}

double share(std::vector<double> v, double quantile) {
  std::sort(v.begin(), v.end());
  if (v.empty()) return 0.0;
  return v[static_cast<std::size_t>(std::lround(quantile * static_cast<double>(v.size() - 1)))];
}

/// Inserts all scans into one map after the other. If they took turns, the time to free memory of OctoMap would count
/// against the map that comes next.
void insert_all(const Flight& flight, std::size_t num_scans, std::vector<Run>* runs) {
  for (Run& run : *runs) {
    for (std::size_t i = 0; i < std::min(num_scans, flight.scans.size()); ++i) {
      run.map->prepare(flight.scans[i]);
      const double cpu = now_ms(CLOCK_PROCESS_CPUTIME_ID), wall = now_ms(CLOCK_MONOTONIC);
      run.map->insert(flight.scans[i]);
      run.cpu_ms.push_back(now_ms(CLOCK_PROCESS_CPUTIME_ID) - cpu);
      run.wall_ms.push_back(now_ms(CLOCK_MONOTONIC) - wall);
    }
  }
}

std::vector<Run> make_runs(const Setup& setup, bool with_octomap) {
  std::vector<Run> out(with_octomap ? 4 : 3);
  out[0].map = make_voxnav(setup.resolution_m, setup.max_range_m, 1);
  out[1].map = make_voxnav(setup.resolution_m, setup.max_range_m, 2);
  out[2].map = make_voxnav(setup.resolution_m, setup.max_range_m, 1, 2);
  if (with_octomap) out[3].map = make_octomap(setup.resolution_m, setup.max_range_m);
  return out;
}

void print_speed(const Flight& flight, const Setup& setup, const std::vector<Run>& runs) {
  for (const Run& run : runs) {
    std::printf("| %s | %.1f | %-17s | %4zu | %8.2f | %8.2f | %8.2f | %6.1f |", flight.name.c_str(), setup.resolution_m,
                run.map->name().c_str(), run.cpu_ms.size(), mean(run.cpu_ms), share(run.cpu_ms, 0.99),
                share(run.wall_ms, 0.5), static_cast<double>(run.map->memory_bytes()) * 1e-6);
    if (runs.size() > 3 && &run == &runs[0]) std::printf(" %.0f x |", mean(runs[3].cpu_ms) / mean(run.cpu_ms));
    std::printf("\n");
  }
}

void print_quality(const Flight& flight, const SurfaceCells& cells, const std::vector<Run>& runs,
                   const voxnav_simulation::Scene& scene) {
  for (const Run& run : runs) {
    if (&run == &runs[1]) continue;  // with more threads the map is the same, as tests assert
    const Contestant& map = *run.map;
    const Quality q = cells.judge([&](const auto& p) { return map.probability(p); }, map.free_threshold(), kLeastScans);
    std::printf("| %s | %.1f | %-14s | %6zu | %.3f | %.3f | %.4f | %.3f |", flight.name.c_str(), cells.resolution_m(),
                map.name().c_str(), q.all.cells, q.all.kept_share(), q.all.free_share(),
                phantom_share(map.occupied_centers(), cells.resolution_m(), scene),
                rms_distance(map.surface_points(), cells.resolution_m(), scene) / cells.resolution_m());
    for (int c = 0; c <= 4; ++c) {
      std::printf(" %.3f/%.3f (%zu) |", q.by_class[c].kept_share(), q.by_class[c].free_share(), q.by_class[c].cells);
    }
    std::printf("\n");
  }
}

void measure_forest(const Options& options, int seed) {
  voxnav_simulation::WorldConfig world;
  world.num_poles = 40;  // the default of six poles is too few for statistics
  const voxnav_simulation::Scene scene(voxnav_simulation::World(world, static_cast<std::uint64_t>(seed)));
  const int longest = *std::max_element(options.scans.begin(), options.scans.end());
  const Flight flight = fly_forest(scene, static_cast<std::uint64_t>(seed), longest);
  for (std::size_t i = 0; i < 3; ++i) {
    const auto num_scans = static_cast<std::size_t>(options.scans[i]);
    if (num_scans == 0) continue;
    std::vector<Run> runs = make_runs(kSetups[i], options.with_octomap);
    insert_all(flight, num_scans, &runs);
    SurfaceCells cells(kSetups[i].resolution_m);
    for (std::size_t k = 0; k < num_scans; ++k) cells.add(flight.scans[k], kSetups[i].max_range_m);
    std::printf("\n| scans | m | map | number | CPU ms mean | p99 | wall ms median | MB | OctoMap / voxnav |\n");
    print_speed(flight, kSetups[i], runs);
    std::printf(
        "\n| scans | m | map | cells | kept | wrongly free | phantom | rms/voxel | terrain | trunk | pole | "
        "foliage | branch |\n");
    print_quality(flight, cells, runs, scene);
    std::fflush(stdout);
    if (i != 0 || options.points_dir.empty()) continue;
    write_truth(options.points_dir, flight, num_scans);
    write_occupied(options.points_dir, *runs.front().map);
    if (options.with_octomap) write_occupied(options.points_dir, *runs.back().map);
  }
}

void measure_recordings(const Options& options) {
  const char* data = std::getenv("VOXNAV_DATA");
  if (data == nullptr) return;
  const Flight flight = read_recording(std::string(data) + "/kitti_0001", "poses_gt.txt", 48);
  if (flight.scans.empty()) return;
  for (std::size_t i = 0; i < 3; ++i) {
    if (options.scans[i] == 0) continue;
    std::vector<Run> runs = make_runs(kSetups[i], options.with_octomap);
    insert_all(flight, static_cast<std::size_t>(options.scans[i]), &runs);
    print_speed(flight, kSetups[i], runs);
  }
}

}  // namespace

int main(int argc, char** argv) {
  const Options options = options_of(argc, argv);
  for (const int seed : options.seeds) measure_forest(options, seed);
  measure_recordings(options);
  return 0;
}
