// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "leaves.hpp"
#include "site.hpp"
#include "streams.hpp"

namespace voxnav_simulation {
namespace {

constexpr int kTrunkSides = 12;
constexpr int kBranchSides = 4;
constexpr int kTwigSides = 3;
constexpr double kRootDepthM = 0.4;  // depth of trunks below the ground, so that no gap shows on slopes
constexpr double kTopRadiusRatio = 0.3;

struct Tree {
  Rod trunk;  ///< axis and radius from the ground to the top
  double height_m;
  double crown_base_m;  ///< length along the trunk at which the crown begins
  double crown_radius_m;
  bool is_conifer;

  Vec3 axis() const { return (trunk.b - trunk.a).normalized(); }
  double radius_at(double along_m) const {
    return trunk.radius_a_m + (trunk.radius_b_m - trunk.radius_a_m) * along_m / height_m;
  }
  /// Returns the radius of the crown at a length along the trunk.
  double crown_reach(double along_m) const {
    const double t = std::clamp((along_m - crown_base_m) / (height_m - crown_base_m), 0.0, 1.0);
    if (is_conifer) return crown_radius_m * (1.0 - 0.95 * t);
    return crown_radius_m * std::sqrt(std::max(0.05, 1.0 - (2.0 * t - 1.0) * (2.0 * t - 1.0)));
  }
};

Vec3 horizontal(double angle_rad) { return {std::cos(angle_rad), std::sin(angle_rad), 0.0}; }

/// Makes a tree of random size. Small sizes are more frequent than large ones, as in a forest.
Tree make_tree(const WorldConfig& config, const Vec3& ground, Rng* rng) {
  const double size = std::pow(rng->uniform(), 1.5);
  const double radius = config.trunk_radius_min_m + (config.trunk_radius_max_m - config.trunk_radius_min_m) * size;
  const double lean = config.trunk_lean_max_rad * std::sqrt(rng->uniform());
  const Vec3 side = horizontal(rng->uniform(0.0, 2.0 * M_PI));
  const Vec3 axis = std::cos(lean) * Vec3::UnitZ() + std::sin(lean) * side;
  Tree tree;
  tree.crown_base_m = rng->uniform(config.crown_base_min_m, config.crown_base_max_m);
  tree.height_m = tree.crown_base_m + (2.5 + 24.0 * radius) * rng->uniform(0.85, 1.15);
  tree.crown_radius_m = config.crown_radius_max_m * rng->uniform(0.45, 1.0) * (0.55 + 0.45 * size);
  tree.is_conifer = rng->uniform() < config.conifer_ratio;
  tree.trunk = {ground, ground + tree.height_m * axis, radius, kTopRadiusRatio * radius};
  return tree;
}

void append_trunk(const Tree& tree, WorldMesh* mesh) {
  Rod rod = tree.trunk;
  rod.a -= kRootDepthM * tree.axis();
  rod.radius_a_m = tree.radius_at(-kRootDepthM);
  append_rod(mesh, rod, kTrunkSides, SurfaceClass::kTrunk);
}

void append_branch(const Tree& tree, double along_m, double length_m, Rng* rng, WorldMesh* mesh) {
  const double rise = rng->uniform(-0.1, 0.5);
  const Vec3 direction = (horizontal(rng->uniform(0.0, 2.0 * M_PI)) + rise * Vec3::UnitZ()).normalized();
  const Vec3 root = tree.trunk.a + along_m * tree.axis();
  const double radius = std::clamp(0.25 * tree.radius_at(along_m), 0.012, 0.05);
  append_rod(mesh, {root, root + length_m * direction, radius, 0.4 * radius}, kBranchSides, SurfaceClass::kBranch);
}

void append_branches(const WorldConfig& config, const Tree& tree, Rng* rng, WorldMesh* mesh) {
  for (int i = 0; i < config.branches_per_tree; ++i) {
    const double along = rng->uniform(tree.crown_base_m, 0.92 * tree.height_m);
    append_branch(tree, along, std::max(0.3, 0.9 * tree.crown_reach(along)), rng, mesh);
  }
  if (rng->uniform() >= config.low_branch_ratio) return;
  const int num_low = 1 + static_cast<int>(rng->uniform(0.0, 3.0));
  for (int i = 0; i < num_low; ++i) {
    append_branch(tree, rng->uniform(1.0, tree.crown_base_m), rng->uniform(0.4, 1.2), rng, mesh);
  }
}

/// Appends the leaves of a tree in the outer part of its crown, where the light is.
void append_crown(const WorldConfig& config, const Tree& tree, Rng* rng, WorldMesh* mesh) {
  const double low = tree.crown_base_m + config.leaf_size_m;
  for (int i = 0; i < config.leaves_per_tree; ++i) {
    // The area of a cone grows towards its base, and so does the density of the leaves.
    const double t = tree.is_conifer ? 1.0 - std::sqrt(rng->uniform()) : rng->uniform();
    const double along = low + t * (tree.height_m - low);
    const double out = tree.crown_reach(along) * std::sqrt(rng->uniform(0.1, 1.0));
    const Vec3 center = tree.trunk.a + along * tree.axis() + out * horizontal(rng->uniform(0.0, 2.0 * M_PI));
    append_random_leaf(center, config.leaf_size_m, rng, mesh);
  }
}

/// Twigs grow outwards in the outer half of the crown, and beyond it.
void append_twigs(const WorldConfig& config, const Tree& tree, Rng* rng, WorldMesh* mesh) {
  for (int i = 0; i < config.twigs_per_tree; ++i) {
    const double along = rng->uniform(tree.crown_base_m, tree.height_m);
    const Vec3 outwards = horizontal(rng->uniform(0.0, 2.0 * M_PI));
    const Vec3 root = tree.trunk.a + along * tree.axis() + tree.crown_reach(along) * rng->uniform(0.5, 1.0) * outwards;
    const Vec3 direction = (outwards + 0.8 * random_direction(rng)).normalized();
    const Vec3 tip = root + rng->uniform(0.2, 0.6) * direction;
    append_rod(mesh, {root, tip, config.twig_radius_m, 0.5 * config.twig_radius_m}, kTwigSides, SurfaceClass::kBranch);
  }
}

}  // namespace

int plant_trees(Site* site) {
  const WorldConfig& config = site->config;
  const int wanted = static_cast<int>(std::lround(config.trees_per_ha * site->hectares()));
  Rng rng(site->seed, kTreeStream);
  for (int i = 0; i < wanted; ++i) {
    const auto place = site->ground_plan.find(0.0, config.tree_spacing_m, &rng);
    if (!place) return i;
    // Each tree has a stream of its own, so that its shape does not depend on the number of leaves of other trees.
    Rng shape(rng.next(), kTreeStream);
    const Tree tree = make_tree(config, site->on_ground(*place), &shape);
    append_trunk(tree, site->mesh);
    append_branches(config, tree, &shape, site->mesh);
    append_crown(config, tree, &shape, site->mesh);
    append_twigs(config, tree, &shape, site->mesh);
    site->stems->push_back({tree.trunk, SurfaceClass::kTrunk});
  }
  return wanted;
}

}  // namespace voxnav_simulation
