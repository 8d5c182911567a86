// SPDX-License-Identifier: BSD-3-Clause
// Measures the CPU time of the pose graph after each new submap, on laps through an analytic forest with odometry that
// drifts. It prints a row of a Markdown table for each flight.
//   benchmark_graph [--submaps=32] [--drift_m=1.8] [--cache_mb=256]
#include <algorithm>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <numeric>
#include <random>
#include <string>

#include "configs/optimizer_config.hpp"
#include "forest_flight.hpp"
#include "voxnav/graph/submap_graph.hpp"
#include "voxnav/submap/submap.hpp"

using namespace voxnav;  // NOLINT: benchmark
using geometry::Pose;
using geometry::Vec3;

namespace {

struct Flown {
  Pose T_W_S;  ///< the true pose
  std::shared_ptr<const geometry::DistanceField> field;
};

/// Returns the pose on a ring of 24 submaps, 11 m each.
Pose pose_on_ring(double way_m) {
  constexpr double kRadiusM = 42.0;
  const double angle = way_m / kRadiusM;
  return geometry::from_position_yaw({kRadiusM * std::sin(angle), kRadiusM * (1.0 - std::cos(angle)), 3.0}, angle);
}

std::vector<Flown> fly(int num_submaps) {
  occupancy::LocalMap map{occupancy::LocalMapConfig{}};
  std::vector<Flown> out;
  constexpr int kScans = 10;
  for (int i = 0; i < num_submaps * kScans; ++i) {
    const Pose T_W_L = pose_on_ring(1.1 * i);
    const double yaw = std::atan2(T_W_L.linear()(1, 0), T_W_L.linear()(0, 0));
    const std::vector<float> points = test::forest_scan(T_W_L.translation(), yaw, 256);
    for (int repeat = 0; repeat < 3; ++repeat) map.insert(geometry::view_of_rows(points), T_W_L);
    if (i % kScans != kScans - 1) continue;
    const int middle = i - kScans / 2;
    const Pose T_W_S = pose_on_ring(1.1 * middle);
    const occupancy::MapContent content = map.hand_over();
    map.take_evicted();
    const auto submap = submap::Submap::from_content(content, T_W_S.inverse(Eigen::Isometry), {});
    std::vector<geometry::StampedPose> T_S_B;
    for (int k = i - kScans + 1; k <= i; ++k)
      T_S_B.push_back({k, T_W_S.inverse(Eigen::Isometry) * pose_on_ring(1.1 * k)});
    out.push_back({T_W_S, submap::registration_field(submap, T_S_B)});
  }
  return out;
}

/// Returns a random walk that is scaled so that its largest distance is `peak_m`.
std::vector<Vec3> drift_of(std::size_t n, double peak_m) {
  std::mt19937 rng(5);
  std::normal_distribution<double> step(0.0, 1.0);
  std::vector<Vec3> out{Vec3::Zero()};
  Vec3 velocity = Vec3::Zero();
  double peak = 0.0;
  while (out.size() < n) {
    velocity = 0.8 * velocity + Vec3(step(rng), step(rng), 0.3 * step(rng));
    out.emplace_back(out.back() + velocity);
    peak = std::max(peak, out.back().norm());
  }
  for (Vec3& d : out) d *= peak > 0.0 ? peak_m / peak : 0.0;
  return out;
}

double cpu_s() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

double rmse_m(const graph::SubmapGraph& graph, const std::vector<Flown>& flown) {
  double sum = 0.0;
  const auto poses = graph.poses();
  for (const auto& [id, T_W_S] : poses) {
    sum += (T_W_S.translation() - flown[static_cast<std::size_t>(id)].T_W_S.translation()).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(poses.size()));
}

void measure(int num_submaps, double drift_m) {
  const std::vector<Flown> flown = fly(num_submaps);
  const std::vector<Vec3> drift = drift_of(flown.size(), drift_m);
  graph::SubmapGraph graph;
  Eigen::Matrix4d information = Eigen::Matrix4d::Zero();
  information.diagonal() << 4.0, 4.0, 100.0, 2500.0;
  std::vector<double> seconds;
  std::vector<Pose> odometry;
  graph::OptimizeReport report;
  Pose T_W_O = Pose::Identity();
  for (std::size_t i = 0; i < flown.size(); ++i) {
    odometry.push_back(flown[i].T_W_S);
    odometry.back().translation() += drift[i];
    const int id = static_cast<int>(i);
    const double begin = cpu_s();
    graph.add_submap(id, geometry::gravity_aligned(T_W_O * odometry[i]), flown[i].field);
    if (i > 0) {
      const Pose T_a_b = odometry[i - 1].inverse(Eigen::Isometry) * odometry[i];
      graph.add_relative_pose(id - 1, id, T_a_b, information, graph::ConstraintKind::kOdometry);
    }
    report = graph.optimize();
    seconds.push_back(cpu_s() - begin);
    T_W_O = graph.poses().at(id) * odometry[i].inverse(Eigen::Isometry);
  }
  const double sum = std::accumulate(seconds.begin(), seconds.end(), 0.0);
  const double drifted = std::sqrt(
      std::accumulate(drift.begin(), drift.end(), 0.0, [](double s, const Vec3& d) { return s + d.squaredNorm(); }) /
      static_cast<double>(drift.size()));
  std::printf("| %d | %d | %.3f | %.3f | %.3f | %.2f -> %.2f |\n", num_submaps, report.num_pairs,
              sum / static_cast<double>(seconds.size()), *std::max_element(seconds.begin(), seconds.end()),
              seconds.back(), drifted, rmse_m(graph, flown));
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<int> sizes{32, 111};
  double drift_m = 1.8;
  const auto set_cache = [](int mb) { submap::Submap::set_distance_cache_bytes(static_cast<std::size_t>(mb) << 20); };
  set_cache(bindings::OptimizerConfig{}.distance_cache_mb);
  for (int i = 1; i < argc; ++i) {
    if (std::strncmp(argv[i], "--drift_m=", 10) == 0) drift_m = std::stod(argv[i] + 10);
    if (std::strncmp(argv[i], "--cache_mb=", 11) == 0) set_cache(std::stoi(argv[i] + 11));
    if (std::strncmp(argv[i], "--submaps=", 10) == 0) sizes = {std::stoi(argv[i] + 10)};
  }
  std::printf("| submaps | pairs | CPU s per new submap, mean | most | last | RMSE m, drift -> solved |\n");
  for (const int size : sizes) measure(size, drift_m);
  return 0;
}
