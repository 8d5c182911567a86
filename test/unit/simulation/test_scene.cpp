// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <fstream>

#include "voxnav_simulation/random.hpp"
#include "voxnav_simulation/scene.hpp"
#include "world_test_tools.hpp"

namespace voxnav_simulation {
namespace {

Vec3 random_vector(Rng* rng, double reach) {
  return {rng->uniform(-reach, reach), rng->uniform(-reach, reach), rng->uniform(-reach, reach)};
}

TEST(Scene, RaysMeetAPlaneAtTheExactRange) {
  const Scene scene(World(empty_world(), 1));
  Rng rng(1);
  for (int i = 0; i < 300; ++i) {
    const Vec3 origin(rng.uniform(-20, 20), rng.uniform(-20, 20), rng.uniform(0.5, 20));
    Vec3 d = random_vector(&rng, 1.0).normalized();
    d.z() = -std::abs(d.z()) - 0.15;
    d.normalize();
    const Hit hit = cast_one(scene, origin, d, 500.0);
    ASSERT_TRUE(hit.is_hit());
    EXPECT_NEAR(hit.range_m, origin.z() / -d.z(), 1e-3);
    EXPECT_NEAR(hit.cos_incidence, -d.z(), 1e-4);
    EXPECT_FALSE(cast_one(scene, origin, -d, 500.0).is_hit());
    EXPECT_FALSE(cast_one(scene, origin, d, 0.9 * hit.range_m).is_hit()) << "beyond the range";
  }
}

TEST(Scene, RaysAgreeWithBruteForceInPacketsOfAnySize) {
  const Scene scene(World(small_world(), 6));
  const WorldMesh mesh = all_of(scene);
  Rng rng(2);
  std::vector<int> hits_of_class(kNumSurfaceClasses, 0);
  for (std::size_t size = 1; size <= 40; ++size) {
    const Vec3 origin(rng.uniform(-10, 10), rng.uniform(-10, 10), rng.uniform(1, 6));
    std::vector<Vec3f> directions;
    for (std::size_t i = 0; i < size; ++i) directions.emplace_back(random_vector(&rng, 1.0).normalized().cast<float>());
    std::vector<Hit> hits(size);
    scene.cast(origin.cast<float>(), directions.data(), size, 100.0F, hits.data());
    for (std::size_t i = 0; i < size; ++i) {
      double expected = 100.0;
      SurfaceClass expected_class{};
      for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const auto range = ray_triangle(origin, directions[i].cast<double>(), corner(mesh, t, 0), corner(mesh, t, 1),
                                        corner(mesh, t, 2));
        if (!range || *range >= expected) continue;
        expected = *range;
        expected_class = mesh.classes[t];
      }
      ASSERT_EQ(hits[i].is_hit(), expected < 100.0);
      if (!hits[i].is_hit()) continue;
      EXPECT_NEAR(hits[i].range_m, expected, 2e-3);
      EXPECT_EQ(hits[i].surface_class, expected_class);
      ++hits_of_class[static_cast<int>(expected_class)];
    }
  }
  for (const SurfaceClass c : {SurfaceClass::kTerrain, SurfaceClass::kTrunk, SurfaceClass::kVehicle}) {
    EXPECT_GT(hits_of_class[static_cast<int>(c)], 0) << name_of(c);
  }
}

TEST(Scene, ClearanceAgreesWithBruteForce) {
  const Scene scene(World(small_world(), 6));
  const WorldMesh mesh = all_of(scene);
  Rng rng(3);
  for (int i = 0; i < 150; ++i) {
    const Vec3 p(rng.uniform(-15, 15), rng.uniform(-15, 15), rng.uniform(-1, 15));
    double expected = 1e9;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      expected = std::min(expected, slow_distance(p, corner(mesh, t, 0), corner(mesh, t, 1), corner(mesh, t, 2)));
    }
    EXPECT_NEAR(scene.clearance(p, 100.0), expected, 1e-4);
    EXPECT_NEAR(scene.clearance(p, 0.5), std::min(expected, 0.5), 1e-4);
    EXPECT_EQ(scene.nearest(p, 0.5 * expected).has_value(), false);
  }
}

TEST(Scene, RefusesToMeasureFromAPointThatIsNotFinite) {
  const Scene scene(World(empty_world(), 1));
  EXPECT_THROW(scene.clearance({std::nan(""), 0, 0}, 1.0), std::invalid_argument);
  EXPECT_THROW(scene.clearance({0, 0, 0}, -1.0), std::invalid_argument);
}

TEST(Scene, VehicleIsWhereItWasMovedTo) {
  WorldConfig config = empty_world();
  config.has_vehicle = true;
  config.vehicle_position_m = {10.0, 0.0};
  config.vehicle_heading_rad = 0.0;
  Scene scene(World(config, 1));
  const Vec3 eye(0.0, 0.0, 1.8);
  const Hit before = cast_one(scene, eye, Vec3::UnitX(), 100.0);
  EXPECT_EQ(before.surface_class, SurfaceClass::kVehicle);
  EXPECT_NEAR(before.range_m, 10.0 - 1.1 - 2.8, 1e-3);
  EXPECT_LT(scene.clearance({10.0, 0.0, 4.0}, 10.0), 1.0);

  EXPECT_TRUE(scene.move_vehicle(0.0, 15.0, M_PI / 2));
  EXPECT_FALSE(cast_one(scene, eye, Vec3::UnitX(), 100.0).is_hit());
  EXPECT_NEAR(scene.clearance({10.0, 0.0, 4.0}, 10.0), 4.0, 1e-4);
  EXPECT_NEAR(cast_one(scene, eye, Vec3::UnitY(), 100.0).range_m, 15.0 - 1.1 - 2.8, 1e-3);

  EXPECT_FALSE(scene.move_vehicle(1e6, 0.0, 0.0));
  EXPECT_FALSE(scene.move_vehicle(0.0, 0.0, std::nan("")));
  EXPECT_NEAR(scene.vehicle_pose()->translation().y(), 15.0, 1e-9);
}

TEST(Scene, WithoutVehicleThereIsNothingToMove) {
  Scene scene(World(empty_world(), 1));
  EXPECT_FALSE(scene.vehicle_pose().has_value());
  EXPECT_FALSE(scene.move_vehicle(0, 0, 0));
}

TEST(SharedScene, IsOnePerFileAndSeed) {
  const std::string path = ::testing::TempDir() + "voxnav_shared_world.yaml";
  std::ofstream(path) << "trees_per_ha: 0\nbushes_per_ha: 0\nterrain_cell_m: 10\n";
  const auto a = shared_scene(path, 1), b = shared_scene(path, 1), c = shared_scene(path, 2);
  EXPECT_EQ(a.get(), b.get());
  EXPECT_NE(a.get(), c.get());
  EXPECT_EQ(a->world().config().trees_per_ha, 0.0);
}

}  // namespace
}  // namespace voxnav_simulation
