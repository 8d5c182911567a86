// SPDX-License-Identifier: BSD-3-Clause
// Measures the memory of a process that maps a flight of 19 minutes and 1.28 km (111 submaps, out and back beside the
// way out), with submaps on disk beyond --resident-mb. It prints one CSV row per submap; `--submaps=N` sets the length.
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <limits>

#include "forest_flight.hpp"
#include "voxnav/base/stage_statistics.hpp"
#include "voxnav/submap/obstacle_map.hpp"
#include "voxnav/submap/submap_collection.hpp"

using namespace voxnav;  // NOLINT: benchmark

namespace {

constexpr double kSubmapLength_m = 11.5;
constexpr double kSubmapPeriod_s = 10.3;
constexpr int kScans = 10;

double option(int argc, char** argv, const char* name, double otherwise) {
  const std::size_t length = std::strlen(name);
  for (int i = 1; i < argc; ++i) {
    if (std::strncmp(argv[i], name, length) == 0) return std::atof(argv[i] + length);
  }
  return otherwise;
}

double resident_mb() {
  std::ifstream in("/proc/self/statm");
  double total = 0.0;
  double resident = 0.0;
  in >> total >> resident;
  return resident * static_cast<double>(::sysconf(_SC_PAGESIZE)) * 1e-6;
}

geometry::Pose pose_at(double travelled_m, double length_m) {
  const bool is_back = travelled_m > 0.5 * length_m;
  const double x = is_back ? length_m - travelled_m : travelled_m;
  return geometry::from_position_yaw({x, is_back ? 8.0 : 0.0, 3.0}, is_back ? 3.0 : 0.1);
}

struct Process {
  explicit Process(const submap::SubmapCollectionConfig& config) : collection(config) {}
  occupancy::LocalMap map{occupancy::LocalMapConfig{}};
  submap::SubmapCollection collection;
  submap::ObstacleMap obstacles{0.4, 1.5};

  /// Flies one submap. @return CPU time in ms of all stages after the local map
  double fly(int i, int count) {
    geometry::Pose T_O_L;
    for (int scan = 0; scan < kScans; ++scan) {
      T_O_L = pose_at(kSubmapLength_m * (i + static_cast<double>(scan) / kScans), kSubmapLength_m * count);
      const double yaw = geometry::yaw_of(T_O_L);
      const std::vector<float> points = test::forest_scan(T_O_L.translation(), yaw);
      for (int repeat = 0; repeat < 2; ++repeat) map.insert(geometry::view_of_rows(points), T_O_L);
    }
    const double start_ms = base::thread_cpu_ms();
    submap::SubmapEntry entry;
    entry.id = static_cast<std::uint32_t>(i);
    entry.end_ns = static_cast<base::StampNs>(i);
    entry.T_O_S = entry.T_W_S = geometry::gravity_aligned(T_O_L);
    entry.submap = submap::Submap::from_content(map.content(), entry.T_O_S.inverse(Eigen::Isometry), {});
    map.take_evicted();
    collection.add(std::move(entry));
    obstacles.mark_changed(collection.update());
    obstacles.update(collection.evidence(), std::numeric_limits<std::size_t>::max());
    obstacles.take_changes();
    return base::thread_cpu_ms() - start_ms;
  }
};

}  // namespace

int main(int argc, char** argv) {
  const int count = static_cast<int>(option(argc, argv, "--submaps=", 111));
  submap::SubmapCollectionConfig config;
  config.page_dir = "/tmp";
  config.max_resident_mb = option(argc, argv, "--resident-mb=", 15.0);
  Process process(config);
  std::printf("minutes,process_mb,growth_mb,submaps_in_memory,merged_map_mb,update_cpu_ms\n");
  double first_mb = 0.0;
  for (int i = 0; i < count; ++i) {
    const double cpu_ms = process.fly(i, count);
    if (i == 0) first_mb = resident_mb();
    const double merged_mb =
        static_cast<double>(process.collection.evidence().memory_bytes() + process.obstacles.memory_bytes()) * 1e-6;
    std::printf("%.2f,%.1f,%.1f,%zu,%.1f,%.1f\n", (i + 1) * kSubmapPeriod_s / 60.0, resident_mb(),
                resident_mb() - first_mb, process.collection.num_resident(), merged_mb, cpu_ms);
    std::fflush(stdout);
  }
  return 0;
}
