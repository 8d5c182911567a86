// SPDX-License-Identifier: BSD-3-Clause
// Planners in dense forests: 100 x 100 x 10 m, 1600 trunks, 0.8 m of safety distance, 18 queries per seed. Prints CPU
// times, lengths over the best path known, and what keeping the field up to date takes.
//   benchmark_path_planner [--seeds=3] [--resolution=0.4] [--without-yardsticks]
// Without the yardsticks, which take minutes, the best path known is the planner's own, shortened further: compare the
// mean length of two builds instead.
#include "voxnav/planning/path_planner.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <functional>
#include <random>

#include "box_grid.hpp"
#include "lazy_theta_star.hpp"
#include "planning/path/shorten.hpp"
#include "voxnav/planning/a_star.hpp"
#include "voxnav/planning/corridor.hpp"

using namespace voxnav;  // NOLINT: benchmark
using containers::VoxelState;
using geometry::Index3;
using geometry::Vec3;

namespace {

constexpr double kSafety = 0.8;
constexpr int kQueries = 18;

struct Options {
  int num_seeds = 3;
  double resolution_m = 0.0;  ///< 0: 0.4 m with all seeds, and 0.2 m with one
  bool with_yardsticks = true;
};

Options options_of(int argc, char** argv) {
  Options out;
  for (int i = 1; i < argc; ++i) {
    if (std::strncmp(argv[i], "--seeds=", 8) == 0) out.num_seeds = std::max(1, std::atoi(argv[i] + 8));
    if (std::strncmp(argv[i], "--resolution=", 13) == 0) out.resolution_m = std::atof(argv[i] + 13);
    if (std::strcmp(argv[i], "--without-yardsticks") == 0) out.with_yardsticks = false;
  }
  return out;
}

double cpu_ms() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) * 1e3 + static_cast<double>(now.tv_nsec) * 1e-6;
}

double timed(const std::function<void()>& work) {
  const double begin = cpu_ms();
  work();
  return cpu_ms() - begin;
}

void print(const char* name, std::vector<double> values) {
  if (values.empty()) return;
  std::sort(values.begin(), values.end());
  std::printf("| %s | %.3f | %.3f | %.3f |\n", name, values[values.size() / 2], values[values.size() * 95 / 100],
              values.back());
}

class Forest {
 public:
  Forest(unsigned seed, double resolution_m) : rng_(seed), resolution_m_(resolution_m) {
    const int side = static_cast<int>(std::lround(100.0 / resolution_m));
    height_ = static_cast<int>(std::lround(10.0 / resolution_m));
    grid = test::box_grid({0, 0, 0}, {side - 1, side - 1, height_ - 1}, resolution_m);
    for (int i = 0; i < 1600; ++i) plant(side, number(0.0, 100.0), number(0.0, 100.0), number(0.1, 0.3));
  }
  double number(double low, double high) { return low + (high - low) * (rng_() / 4294967296.0); }
  Vec3 point() {
    const double x = number(2.0, 98.0), y = number(2.0, 98.0);
    return {x, y, number(1.0, 9.0)};
  }
  /// What one scan changes: forty voxels around one place.
  std::vector<Index3> change() {
    std::vector<Index3> blocks;
    const Vec3 at = point();
    for (int i = 0; i < 40; ++i) {
      const Vec3 near = at + Vec3(number(-25.0, 25.0), number(-25.0, 25.0), number(-3.0, 3.0));
      const Index3 voxel = geometry::index_of(near, resolution_m_);
      const VoxelState state = grid->state(voxel);
      if (state == VoxelState::kUnknown) continue;
      grid->set(voxel, state == VoxelState::kOccupied ? VoxelState::kFree : VoxelState::kOccupied);
      blocks.push_back(geometry::block_of(voxel));
    }
    return blocks;
  }

  std::shared_ptr<containers::StateGrid> grid;

 private:
  void plant(int side, double x, double y, double radius) {
    const auto cell = [&](double value) { return static_cast<int>(std::floor(value / resolution_m_)); };
    for (int i = std::max(0, cell(x - radius)); i <= std::min(side - 1, cell(x + radius)); ++i) {
      for (int j = std::max(0, cell(y - radius)); j <= std::min(side - 1, cell(y + radius)); ++j) {
        const double dx = std::max({i * resolution_m_ - x, 0.0, x - (i + 1) * resolution_m_});
        const double dy = std::max({j * resolution_m_ - y, 0.0, y - (j + 1) * resolution_m_});
        if (dx * dx + dy * dy > radius * radius) continue;
        test::fill(grid.get(), {i, j, 0}, {i, j, height_ - 1}, VoxelState::kOccupied);
      }
    }
  }

  std::mt19937 rng_;
  double resolution_m_;
  int height_ = 0;
};

/// The best that is known of a path's own choice of sides: shortened without a limit on checks.
double shortened_length(const planning::ClearanceField& field, const std::vector<Vec3>& path) {
  const planning::PathPlannerConfig config;
  const planning::RunCosts costs(field, config, path.front());
  planning::RunGraph graph(&costs, std::size_t{1} << 30);
  const double v = field.resolution_m();
  const planning::SegmentClearance clearance(field.impl(), kSafety / v);
  std::vector<Vec3> points;
  points.reserve(path.size());
  for (const Vec3& p : path) points.emplace_back(p / v);
  for (int i = 0; i < 4; ++i) points = planning::PathShortening(&graph, &clearance, ~std::uint64_t{0}).run(points);
  return planning::length_of(points) * v;
}

struct Table {
  std::vector<double> plan_ms, costs_ms, quick_ms, a_star_ms, theta_ms, impossible_ms, update_ms;
  std::vector<double> plan_ratio, costs_ratio, quick_ratio, a_star_ratio, theta_ratio;
  std::vector<double> length_m;
  int num_unsafe = 0;
};

planning::ClearanceField make_field(const planning::OccupancyView& view) {
  planning::ClearanceFieldConfig config;
  config.safety_distance_m = kSafety;
  config.radius_m = 2.0;
  planning::ClearanceField field(config);
  field.update(view);
  return field;
}

struct Query {
  Vec3 start;
  Vec3 goal;
};

/// Times the planner as it is by default, with costs of nearness, and with both these and `quick` as it flies.
planning::AnyAnglePlan measure_planner(const planning::ClearanceField& field, const planning::OccupancyView& view,
                                       const Query& query, Table* table) {
  planning::PathPlannerConfig with_costs;
  with_costs.clearance_distance_m = 2.0;
  planning::PathPlannerConfig quick = with_costs;
  quick.quick = true;
  planning::AnyAnglePlan plan, dear, fast;
  const auto planned = [&](const planning::PathPlannerConfig& config) {
    return planning::PathPlanner(config).plan(field, query.start, query.goal);
  };
  table->plan_ms.push_back(timed([&] { plan = planned({}); }));
  table->costs_ms.push_back(timed([&] { dear = planned(with_costs); }));
  table->quick_ms.push_back(timed([&] { fast = planned(quick); }));
  table->costs_ratio.push_back(dear.cost_m / dear.lower_bound_m);
  table->quick_ratio.push_back(fast.cost_m / dear.cost_m);
  table->length_m.push_back(plan.length_m);
  for (const planning::AnyAnglePlan* each : {&plan, &dear, &fast}) {
    const auto corridor = check_corridor(view, each->path, kSafety - 1e-6, planning::CorridorRule::kNotOccupied);
    table->num_unsafe += each->status != planning::PlanStatus::kComplete || !corridor.is_safe ? 1 : 0;
  }
  return plan;
}

void measure_query(const planning::ClearanceField& field, const planning::OccupancyView& view, const Query& query,
                   bool with_yardsticks, Table* table) {
  const planning::AnyAnglePlan plan = measure_planner(field, view, query, table);
  double best = std::min(plan.length_m, shortened_length(field, plan.path));
  if (with_yardsticks) {
    planning::AStarConfig a_star;
    a_star.safety_distance_m = kSafety;
    a_star.max_expansions = 10000000;
    a_star.max_memory_mib = 4096.0;
    a_star.timeout_s = 60.0;
    a_star.simplify = true;
    planning::PlanResult lattice;
    test::LazyThetaStar theta(&field);
    std::vector<Vec3> theta_path;
    table->a_star_ms.push_back(
        timed([&] { lattice = planning::AStarPlanner(a_star).plan(view, query.start, query.goal); }));
    table->theta_ms.push_back(timed([&] { theta_path = theta.plan(query.start, query.goal); }));
    best = std::min({best, shortened_length(field, lattice.path), shortened_length(field, theta_path)});
    table->a_star_ratio.push_back(planning::length_of(lattice.path) / best);
    table->theta_ratio.push_back(planning::length_of(theta_path) / best);
  }
  table->plan_ratio.push_back(plan.length_m / best);
}

void measure(double resolution_m, int num_seeds, bool with_yardsticks) {
  Table table;
  for (int seed = 0; seed < num_seeds; ++seed) {
    Forest forest(static_cast<unsigned>(seed), resolution_m);
    const planning::StateGridView view(forest.grid);
    planning::ClearanceField field = make_field(view);
    for (int found = 0; found < kQueries;) {
      const Vec3 start = geometry::center_of(geometry::index_of(forest.point(), resolution_m), resolution_m);
      const Vec3 goal = geometry::center_of(geometry::index_of(forest.point(), resolution_m), resolution_m);
      const std::uint32_t from = field.component(start), to = field.component(goal);
      if (from == 0 || to == 0 || (start - goal).norm() < 30.0) continue;
      if (from != to) {
        planning::PathPlannerConfig config;
        config.goal_search_radius_m = 0.0;
        table.impossible_ms.push_back(timed([&] { planning::PathPlanner(config).plan(field, start, goal); }));
        continue;
      }
      measure_query(field, view, {start, goal}, with_yardsticks, &table);
      ++found;
    }
    for (int scan = 0; scan < 30; ++scan) {
      const std::vector<Index3> blocks = forest.change();
      table.update_ms.push_back(timed([&] { field.update(view, blocks); }));
    }
    if (seed == 0)
      std::printf("memory of the field: %.1f MiB\n", static_cast<double>(field.memory_bytes()) / 1048576.0);
  }
  std::printf("\n%.1f m, %d seeds, unsafe or incomplete: %d\n", resolution_m, num_seeds, table.num_unsafe);
  std::printf("| CPU ms | median | p95 | max |\n|---|---|---|---|\n");
  print("PathPlanner", table.plan_ms);
  print("PathPlanner, clearance costs", table.costs_ms);
  print("PathPlanner, clearance costs, quick", table.quick_ms);
  print("A*, simplified", table.a_star_ms);
  print("Lazy Theta* (yardstick)", table.theta_ms);
  print("PathPlanner, impossible goals", table.impossible_ms);
  print("field update", table.update_ms);
  std::printf("| length / best known | median | p95 | max |\n|---|---|---|---|\n");
  print("PathPlanner", table.plan_ratio);
  print("A*, simplified", table.a_star_ratio);
  print("Lazy Theta*", table.theta_ratio);
  print("PathPlanner, clearance costs: cost / bound", table.costs_ratio);
  print("PathPlanner, clearance costs, quick: cost / cost", table.quick_ratio);
  double sum_m = 0.0;
  for (const double length_m : table.length_m) sum_m += length_m;
  std::printf("mean length of PathPlanner: %.4f m\n", sum_m / static_cast<double>(table.length_m.size()));
}

}  // namespace

int main(int argc, char** argv) {
  const Options options = options_of(argc, argv);
  const double resolution_m = options.resolution_m > 0.0 ? options.resolution_m : 0.4;
  measure(resolution_m, options.num_seeds, options.with_yardsticks);
  if (options.resolution_m == 0.0) measure(0.2, 1, options.with_yardsticks);
}
