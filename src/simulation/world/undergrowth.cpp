// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "leaves.hpp"
#include "site.hpp"
#include "streams.hpp"

namespace voxnav_simulation {
namespace {

constexpr int kPoleSides = 8;
constexpr double kBushGapM = 0.3;
constexpr double kPoleGapM = 1.0;
constexpr double kRockGapM = 0.3;

}  // namespace

int plant_bushes(Site* site) {
  const WorldConfig& config = site->config;
  const int wanted = static_cast<int>(std::lround(config.bushes_per_ha * site->hectares()));
  Rng rng(site->seed, kBushStream);
  for (int i = 0; i < wanted; ++i) {
    Rng shape(rng.next(), kBushStream);
    const double radius = shape.uniform(0.4, 1.0) * config.bush_radius_max_m;
    const auto place = site->ground_plan.find(radius, kBushGapM, &rng);
    if (!place) return i;
    const Vec3 ground = site->on_ground(*place);
    const Vec3 radii(radius, radius, radius * shape.uniform(0.8, 1.4));
    for (int leaf = 0; leaf < config.leaves_per_bush; ++leaf) {
      Vec3 offset = std::cbrt(shape.uniform(0.1, 1.0)) * random_direction(&shape).cwiseProduct(radii);
      offset.z() = std::abs(offset.z());
      append_random_leaf(ground + offset, 0.6 * config.leaf_size_m, &shape, site->mesh);
    }
  }
  return wanted;
}

int place_poles(Site* site) {
  const WorldConfig& config = site->config;
  Rng rng(site->seed, kPoleStream);
  for (int i = 0; i < config.num_poles; ++i) {
    const double radius = rng.uniform(config.pole_radius_min_m, config.pole_radius_max_m);
    const auto place = site->ground_plan.find(radius, kPoleGapM, &rng);
    if (!place) return i;
    const Vec3 ground = site->on_ground(*place);
    const Rod pole{ground, ground + config.pole_height_m * Vec3::UnitZ(), radius, radius};
    append_rod(site->mesh, {ground - 0.3 * Vec3::UnitZ(), pole.b, radius, radius}, kPoleSides, SurfaceClass::kPole);
    site->stems->push_back({pole, SurfaceClass::kPole});
  }
  return config.num_poles;
}

int place_rocks(Site* site) {
  const WorldConfig& config = site->config;
  const int wanted = static_cast<int>(std::lround(config.rocks_per_ha * site->hectares()));
  Rng rng(site->seed, kRockStream);
  for (int i = 0; i < wanted; ++i) {
    const double radius = config.rock_radius_max_m * (0.25 + 0.75 * std::pow(rng.uniform(), 2.0));
    const auto place = site->ground_plan.find(radius, kRockGapM, &rng);
    if (!place) return i;
    std::array<double, 42> bulge;
    for (double& b : bulge) b = rng.uniform(0.8, 1.1);
    const Vec3 radii = radius * Vec3(rng.uniform(0.7, 1.0), rng.uniform(0.7, 1.0), rng.uniform(0.5, 0.9));
    append_rock(site->mesh, site->on_ground(*place), radii, bulge);
  }
  return wanted;
}

}  // namespace voxnav_simulation
