// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Eigenvalues>
#include <array>
#include <cmath>

#include "voxnav/submap/block_window.hpp"
#include "voxnav/submap/occupancy_filling.hpp"

namespace voxnav::submap {
namespace {

using containers::State;
using geometry::Vec3f;

/// What the 26 voxels around a leaf say.
struct Neighborhood {
  Vec3f towards_free = Vec3f::Zero();  ///< sum of unit directions
  int num_free = 0;
  Vec3f sum = Vec3f::Zero();
  Eigen::Matrix3f squares = Eigen::Matrix3f::Zero();
  int num_leaves = 0;
};

/// Unit vectors to the 26 neighbours, in the order of the loops below.
std::array<Vec3f, 27> make_directions() {
  std::array<Vec3f, 27> out;
  for (int i = 0; i < 27; ++i) {
    const Vec3f step(static_cast<float>(i % 3 - 1), static_cast<float>(i / 3 % 3 - 1), static_cast<float>(i / 9 - 1));
    out[static_cast<std::size_t>(i)] = i == 13 ? Vec3f(Vec3f::Zero()) : Vec3f(step.normalized());
  }
  return out;
}

Neighborhood look_around(const BlockWindow& window, const WindowLeaf& leaf) {
  static const std::array<Vec3f, 27> directions = make_directions();
  Neighborhood out;
  for (int i = 0; i < 27; ++i) {
    const int dx = i % 3 - 1;
    const int dy = i / 3 % 3 - 1;
    const int dz = i / 9 - 1;
    const State state = window.state(leaf.x + dx, leaf.y + dy, leaf.z + dz);
    if (state == State::kFree) {
      out.towards_free += directions[static_cast<std::size_t>(i)];
      ++out.num_free;
    } else if (state == State::kOccupied) {
      const WindowLeaf& other = window.leaves()[window.leaf_at(leaf.x + dx, leaf.y + dy, leaf.z + dz)];
      const Vec3f p = other.mean() + Vec3f(dx, dy, dz);
      out.sum += p;
      out.squares += p * p.transpose();
      ++out.num_leaves;
    }
  }
  return out;
}

/// Normal of the plane through the neighbouring surface points; zero when they do not lie in one.
Vec3f plane_normal(const Neighborhood& around) {
  constexpr int kMinLeaves = 5;
  constexpr float kMaxThickness = 0.2f;  // voxel edges, RMS
  constexpr float kMinWidth = 0.35f;
  if (around.num_leaves < kMinLeaves) return Vec3f::Zero();
  const Vec3f mean = around.sum / around.num_leaves;
  const Eigen::Matrix3f covariance = around.squares / around.num_leaves - mean * mean.transpose();
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f> solver;
  solver.computeDirect(covariance);
  const Vec3f spread = solver.eigenvalues().cwiseMax(0.f).cwiseSqrt();
  if (!(spread[0] < kMaxThickness && spread[1] > kMinWidth)) return Vec3f::Zero();
  return solver.eigenvectors().col(0);
}

State state_behind(const BlockWindow& window, const WindowLeaf& leaf, const Vec3f& normal) {
  const Vec3f step = -normal / normal.cwiseAbs().maxCoeff();
  const auto round = [](float c) { return static_cast<int>(std::lround(c)); };
  return window.state(leaf.x + round(step.x()), leaf.y + round(step.y()), leaf.z + round(step.z()));
}

void classify(const BlockWindow& window, const WindowLeaf& seen, FilledLeaf* leaf) {
  constexpr float kOneSided = 0.25f;
  const Neighborhood around = look_around(window, seen);
  if (around.num_free == 0) return;  // deep inside: no surface is seen from here
  const float strength = around.towards_free.norm() / around.num_free;
  const Vec3f free_side = strength > 1e-3f ? around.towards_free.normalized() : Vec3f::Zero();
  Vec3f normal = plane_normal(around);
  if (normal.dot(free_side) < 0.f) normal = -normal;
  if (!normal.isZero() && strength > kOneSided && normal.dot(free_side) > 0.3f &&
      state_behind(window, seen, normal) != State::kFree) {
    leaf->normal = normal;
    leaf->quality = kPlanarQuality;
  } else if (strength > kOneSided) {
    leaf->normal = free_side;
    const bool is_solid = state_behind(window, seen, free_side) == State::kOccupied;
    leaf->quality = is_solid ? kSolidQuality : kOneSidedQuality;
  } else {
    // Seen from all around: the hits lie on the side they came from.
    const Vec3f offset = seen.mean();
    leaf->normal = offset.norm() > 0.05f ? offset.normalized() : !free_side.isZero() ? free_side : Vec3f::UnitX();
    leaf->quality = kThinQuality;
  }
}

}  // namespace

void estimate_normals(std::vector<FilledBlock>* blocks) {
  const BlockIndex index(*blocks);
  for (FilledBlock& block : *blocks) {
    if (block.leaves.empty()) continue;
    BlockWindow window(index, block.index, 1);
    window.load_states();
    for (FilledLeaf& leaf : block.leaves) {
      const geometry::Index3 at = geometry::voxel_at({0, 0, 0}, leaf.offset);
      classify(window, {at.x, at.y, at.z, &leaf}, &leaf);
    }
  }
}

}  // namespace voxnav::submap
