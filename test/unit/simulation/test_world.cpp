// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <fstream>
#include <queue>

#include "voxnav_simulation/flat_yaml.hpp"
#include "voxnav_simulation/random.hpp"
#include "voxnav_simulation/world.hpp"
#include "world_test_tools.hpp"

namespace voxnav_simulation {
namespace {

using voxnav::base::ConfigError;
using voxnav::base::Value;

bool same_mesh(const WorldMesh& a, const WorldMesh& b) {
  return a.vertices == b.vertices && a.triangles == b.triangles && a.classes == b.classes;
}

TEST(World, IsTheSameForTheSameSeedOnly) {
  const World first(small_world(), 7), again(small_world(), 7), other(small_world(), 8);
  EXPECT_TRUE(same_mesh(first.mesh(), again.mesh()));
  EXPECT_FALSE(same_mesh(first.mesh(), other.mesh()));
}

TEST(World, MoreRocksLeaveTheTreesWhereTheyWere) {
  WorldConfig config = small_world();
  const World before(config, 3);
  config.rocks_per_ha *= 3;
  const World after(config, 3);
  ASSERT_GT(before.counts().num_trees, 5);
  for (int i = 0; i < before.counts().num_trees; ++i) {
    EXPECT_EQ(before.stems()[i].rod.a, after.stems()[i].rod.a) << i;
  }
}

TEST(World, PlantsAsManyTreesAsAskedAndKeepsThemApart) {
  for (const double density : {100.0, 300.0, 600.0}) {
    WorldConfig config;
    config.trees_per_ha = density;
    config.leaves_per_tree = 1;
    const World world(config, 11);
    const double hectares = config.size_m[0] * config.size_m[1] / 1e4;
    EXPECT_EQ(world.counts().num_trees, std::lround(density * hectares)) << density;
    const auto& stems = world.stems();
    for (std::size_t i = 0; i < stems.size(); ++i) {
      if (stems[i].surface_class != SurfaceClass::kTrunk) continue;
      EXPECT_GE(stems[i].rod.radius_a_m, config.trunk_radius_min_m);
      EXPECT_LE(stems[i].rod.radius_a_m, config.trunk_radius_max_m);
      EXPECT_GE(stems[i].rod.a.head<2>().norm(), config.clear_radius_m);
      for (std::size_t j = 0; j < i; ++j) {
        if (stems[j].surface_class != SurfaceClass::kTrunk) continue;
        EXPECT_GE((stems[i].rod.a - stems[j].rod.a).head<2>().norm(), config.tree_spacing_m);
      }
    }
  }
}

TEST(World, CountsTheTreesThatFoundRoom) {
  WorldConfig config = small_world();
  config.tree_spacing_m = 12.0;
  const World world(config, 1);
  EXPECT_GT(world.counts().num_trees, 0);
  EXPECT_LT(world.counts().num_trees, 18);
}

TEST(World, GroundIsAtZeroAtTheStartAndUnknownOutside) {
  const World world(small_world(), 5);
  EXPECT_NEAR(world.ground_height(0, 0).value(), 0.0, 1e-12);
  EXPECT_FALSE(world.ground_height(1000, 0).has_value());
  EXPECT_FALSE(world.ground_height(std::nan(""), 0).has_value());
}

TEST(World, GroundHeightIsTheHeightOfTheMesh) {
  WorldConfig config = empty_world();
  config.terrain_margin_m = 0.0;
  config.terrain_cell_m = 1.0;
  config.terrain_amplitude_m = 2.0;
  config.terrain_roughness_m = 0.1;
  const Scene scene(World(config, 9));
  Rng rng(4);
  for (int i = 0; i < 500; ++i) {
    const Vec3 above(rng.uniform(-29, 29), rng.uniform(-29, 29), 50.0);
    const Hit hit = cast_one(scene, above, -Vec3::UnitZ(), 100.0);
    ASSERT_TRUE(hit.is_hit());
    EXPECT_NEAR(above.z() - hit.range_m, scene.world().ground_height(above.x(), above.y()).value(), 1e-4);
  }
}

TEST(World, StemsLieOnTheMesh) {
  WorldConfig config = small_world();
  config.low_branch_ratio = 0.0;
  const Scene scene(World(config, 2));
  ASSERT_GT(scene.world().stems().size(), 10u);
  for (const Stem& stem : scene.world().stems()) {
    const Rod& rod = stem.rod;
    const Vec3 axis = (rod.b - rod.a).normalized(), side = axis.cross(Vec3::UnitX()).normalized();
    for (const double along_m : {1.0, 2.0, 3.0}) {  // these lengths are above the ground and below the crown
      const double t = along_m / (rod.b - rod.a).norm();
      const double radius = rod.radius_a_m + t * (rod.radius_b_m - rod.radius_a_m);
      const Vec3 center = rod.a + t * (rod.b - rod.a);
      const auto nearest = scene.nearest(center + radius * side, 1.0);
      ASSERT_TRUE(nearest.has_value());
      EXPECT_LT(nearest->distance_m, 0.05 * radius + 1e-3);
      // Inside a stem the nearest surface must be its own.
      EXPECT_NEAR(scene.clearance(center, 1.0), radius, 0.06 * radius + 1e-3);
    }
  }
}

/// Returns whether a sphere of this radius can move from start to goal 2 m above the ground.
bool is_flyable(const Scene& scene, double radius_m) {
  const WorldConfig& c = scene.world().config();
  constexpr double kStepM = 0.5;
  const int nx = static_cast<int>(c.size_m[0] / kStepM), ny = static_cast<int>(c.size_m[1] / kStepM);
  const auto cell_of = [&](const std::array<double, 2>& p) {
    return std::pair<int, int>((p[0] - c.min_corner_m[0]) / kStepM, (p[1] - c.min_corner_m[1]) / kStepM);
  };
  std::vector<char> seen(static_cast<std::size_t>(nx) * ny, 0);
  std::queue<std::pair<int, int>> open({cell_of(c.start_m)});
  const auto goal = cell_of(c.goal_m);
  while (!open.empty()) {
    const auto [x, y] = open.front();
    open.pop();
    if (x < 0 || y < 0 || x >= nx || y >= ny || seen[y * nx + x]) continue;
    seen[y * nx + x] = 1;
    const double px = c.min_corner_m[0] + x * kStepM, py = c.min_corner_m[1] + y * kStepM;
    const double pz = scene.world().ground_height(px, py).value() + 2.0;
    if (scene.clearance({px, py, pz}, 2.0) < radius_m) continue;
    if (std::make_pair(x, y) == goal) return true;
    for (const auto& [dx, dy] : {std::pair<int, int>{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) open.push({x + dx, y + dy});
  }
  return false;
}

TEST(World, DefaultForestCanBeFlownWithRoomToSpare) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Scene scene(World(WorldConfig(), seed));
    EXPECT_TRUE(is_flyable(scene, 1.0)) << "seed " << seed;
    EXPECT_FALSE(is_flyable(scene, 1.999)) << "the forest is no obstacle, seed " << seed;
  }
}

TEST(World, PlyHoldsSeedAndAllFaces) {
  const World world(small_world(), 42);
  const std::string path = ::testing::TempDir() + "voxnav_world.ply";
  save_ply(world, std::nullopt, path);
  std::ifstream file(path, std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(file)), {});
  EXPECT_EQ(bytes.rfind("ply\nformat binary_little_endian 1.0\n", 0), 0u);
  EXPECT_NE(bytes.find("comment seed 42\n"), std::string::npos);
  EXPECT_NE(bytes.find("comment trees_per_ha 200\n"), std::string::npos);
  const std::size_t body = bytes.find("end_header\n") + 11;
  EXPECT_EQ(bytes.size() - body, 12 * world.mesh().vertices.size() + 17 * world.mesh().triangles.size());
}

TEST(World, RefusesContradictions) {
  WorldConfig config;
  config.trunk_radius_min_m = 0.5;
  config.goal_m = {500.0, 0.0};
  try {
    const World world(config, 1);
    FAIL() << "accepted";
  } catch (const ConfigError& error) {
    EXPECT_EQ(error.problems().size(), 2u) << error.what();
  }
}

TEST(FlatYaml, ReadsAllKindsOfParameters) {
  const auto values =
      parse_flat_yaml("# text\na: 1\nb: -2.5e-1  # unit\nc: [1, 2.5]\nd: true\ne: \"x # y\"\nf: name\n", "t");
  EXPECT_EQ(values.at("a"), Value(std::int64_t{1}));
  EXPECT_EQ(values.at("b"), Value(-0.25));
  EXPECT_EQ(values.at("c"), Value(std::vector<double>{1.0, 2.5}));
  EXPECT_EQ(values.at("d"), Value(true));
  EXPECT_EQ(values.at("e"), Value(std::string("x # y")));
  EXPECT_EQ(values.at("f"), Value(std::string("name")));
}

std::vector<std::string> problems_of(const std::string& text) {
  try {
    parse_flat_yaml(text, "set.yaml");
  } catch (const ConfigError& error) {
    return error.problems();
  }
  return {};
}

TEST(FlatYaml, NamesEveryLineItCannotRead) {
  const auto problems = problems_of("a: 1\nb:\nc: {x: 1}\na: 2\nd: [[1]]\ne: [1, x]\n");
  ASSERT_EQ(problems.size(), 5u);
  for (std::size_t i = 0; i < problems.size(); ++i) {
    EXPECT_EQ(problems[i].rfind("set.yaml:" + std::to_string(i + 2) + ": ", 0), 0u) << problems[i];
  }
  EXPECT_NE(problems[2].find("twice"), std::string::npos) << problems[2];
  EXPECT_THROW(load_world_config("/nowhere/at/all.yaml"), ConfigError);
}

TEST(FlatYaml, NamesTheLineOfASyntaxError) {
  EXPECT_EQ(problems_of("a: 1\nb\nc: {x: 1}\n").at(0).rfind("set.yaml:3: ", 0), 0u);
  EXPECT_EQ(problems_of("a: [1, 2\nb: 3\n").at(0).rfind("set.yaml:2: ", 0), 0u);
  EXPECT_EQ(problems_of("a: 1\n\tb: 2\n").at(0).rfind("set.yaml:2: ", 0), 0u);
  EXPECT_EQ(problems_of("- 1\n- 2\n").at(0).rfind("set.yaml:1: ", 0), 0u);
}

TEST(FlatYaml, QuotedTextIsNoNumber) {
  const auto values = parse_flat_yaml("a: '1'\nb: \"true\"\nc: ['1', \"2\"]\n", "t");
  EXPECT_EQ(values.at("a"), Value(std::string("1")));
  EXPECT_EQ(values.at("b"), Value(std::string("true")));
  EXPECT_EQ(values.at("c"), Value(std::vector<std::string>{"1", "2"}));
}

}  // namespace
}  // namespace voxnav_simulation
