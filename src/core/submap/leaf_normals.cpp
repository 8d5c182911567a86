// SPDX-License-Identifier: BSD-3-Clause
#include <array>
#include <cmath>

#include "voxnav/submap/field_window.hpp"

namespace voxnav::submap {
namespace {

using containers::State;
using geometry::Vec3f;

/// What the 26 voxels around a leaf say.
struct Neighborhood {
  Vec3f towards_free = Vec3f::Zero();  ///< sum of unit directions
  int num_free = 0;
  Vec3f sum = Vec3f::Zero();
  std::array<float, 6> squares{};  ///< xx yy zz xy xz yz
  int num_leaves = 0;
};

/// Sums of the unit vectors to the free ones of three voxels above each other, for each of the nine columns.
using ColumnSums = std::array<std::array<Vec3f, 8>, 9>;
ColumnSums make_sums() {
  ColumnSums out;
  for (int column = 0; column < 9; ++column) {
    for (int bits = 0; bits < 8; ++bits) {
      Vec3f sum = Vec3f::Zero();
      for (int k = 0; k < 3; ++k) {
        const Vec3f step(static_cast<float>(column % 3 - 1), static_cast<float>(column / 3 - 1),
                         static_cast<float>(k - 1));
        if (((bits >> k) & 1) && !step.isZero()) sum += step.normalized();
      }
      out[static_cast<std::size_t>(column)][static_cast<std::size_t>(bits)] = sum;
    }
  }
  return out;
}

void add_point(const Vec3f& p, Neighborhood* out) {
  out->sum += p;
  out->squares[0] += p.x() * p.x();
  out->squares[1] += p.y() * p.y();
  out->squares[2] += p.z() * p.z();
  out->squares[3] += p.x() * p.y();
  out->squares[4] += p.x() * p.z();
  out->squares[5] += p.y() * p.z();
  ++out->num_leaves;
}

Neighborhood look_around(const FieldWindow& window, const WindowLeaf& leaf) {
  static const ColumnSums sums = make_sums();
  static constexpr int kCount[8] = {0, 1, 1, 2, 1, 2, 2, 3};
  Neighborhood out;
  const int shift = leaf.z - 1 + FieldWindow::kHalo;
  for (int column = 0; column < 9; ++column) {
    const int x = leaf.x + column % 3 - 1;
    const int y = leaf.y + column / 3 - 1;
    const unsigned free = (window.free(x, y) >> shift) & 7u;
    out.towards_free += sums[static_cast<std::size_t>(column)][free];
    out.num_free += kCount[free];
    const unsigned occupied = (window.occupied(x, y) >> shift) & 7u;
    for (int k = 0; k < 3; ++k) {
      if (!((occupied >> k) & 1)) continue;
      const WindowLeaf& other = window.leaf_at(x, y, leaf.z - 1 + k);
      add_point(other.mean + Vec3f(column % 3 - 1, column / 3 - 1, k - 1), &out);
    }
  }
  return out;
}

/// Symmetric 3 x 3 matrix: xx yy zz xy xz yz.
using Symmetric = std::array<float, 6>;

Vec3f times(const Symmetric& m, const Vec3f& v) {
  return {m[0] * v.x() + m[3] * v.y() + m[4] * v.z(), m[3] * v.x() + m[1] * v.y() + m[5] * v.z(),
          m[4] * v.x() + m[5] * v.y() + m[2] * v.z()};
}

/// Adjugate: the eigenvectors of the matrix, the one of the smallest eigenvalue now being the strongest.
Symmetric adjugate(const Symmetric& m) {
  return {m[1] * m[2] - m[5] * m[5], m[0] * m[2] - m[4] * m[4], m[0] * m[1] - m[3] * m[3],
          m[4] * m[5] - m[3] * m[2], m[3] * m[5] - m[4] * m[1], m[3] * m[4] - m[5] * m[0]};
}

/// Unit vector of the thinnest direction of a covariance; zero when it has none.
Vec3f thinnest_direction(const Symmetric& covariance) {
  const Symmetric adj = adjugate(covariance);
  const int largest = adj[0] >= adj[1] ? (adj[0] >= adj[2] ? 0 : 2) : (adj[1] >= adj[2] ? 1 : 2);
  Vec3f v = times(adj, Vec3f::Unit(largest));
  for (int i = 0; i < 3; ++i) {  // the share of other directions shrinks by the ratio of the two smallest spreads
    const float norm = v.norm();
    if (!(norm > 0.f)) return Vec3f::Zero();
    v = times(adj, v / norm);
  }
  const float norm = v.norm();
  return norm > 0.f ? Vec3f(v / norm) : Vec3f(Vec3f::Zero());
}

/// Normal of the plane through the neighbouring surface points; zero when they do not lie in one.
Vec3f plane_normal(const Neighborhood& around) {
  constexpr int kMinLeaves = 5;
  constexpr float kMaxThickness = 0.2f;  // voxel edges, RMS
  constexpr float kMinWidth = 0.35f;
  if (around.num_leaves < kMinLeaves) return Vec3f::Zero();
  const float n = 1.f / static_cast<float>(around.num_leaves);
  const Vec3f mean = around.sum * n;
  const Symmetric covariance = {
      around.squares[0] * n - mean.x() * mean.x(), around.squares[1] * n - mean.y() * mean.y(),
      around.squares[2] * n - mean.z() * mean.z(), around.squares[3] * n - mean.x() * mean.y(),
      around.squares[4] * n - mean.x() * mean.z(), around.squares[5] * n - mean.y() * mean.z()};
  const Vec3f normal = thinnest_direction(covariance);
  const float thin = normal.dot(times(covariance, normal));
  // Of the other two variances the sum and the product are known, so also the smaller one.
  const float sum = covariance[0] + covariance[1] + covariance[2] - thin;
  const Symmetric adj = adjugate(covariance);
  const float product = adj[0] + adj[1] + adj[2] - thin * sum;
  const float middle = 0.5f * (sum - std::sqrt(std::max(0.f, sum * sum - 4.f * product)));
  const bool is_plane = thin < kMaxThickness * kMaxThickness && middle > kMinWidth * kMinWidth;
  return is_plane ? normal : Vec3f(Vec3f::Zero());
}

State state_behind(const FieldWindow& window, const WindowLeaf& leaf, const Vec3f& normal) {
  const Vec3f step = -normal / normal.cwiseAbs().maxCoeff();
  const auto round = [](float c) { return static_cast<int>(std::lround(c)); };
  return window.state(leaf.x + round(step.x()), leaf.y + round(step.y()), leaf.z + round(step.z()));
}

}  // namespace

LeafNormal estimate_normal(const FieldWindow& window, const WindowLeaf& leaf) {
  constexpr float kOneSided = 0.25f;
  const Neighborhood around = look_around(window, leaf);
  if (around.num_free == 0) return {};  // deep inside: no surface is seen from here
  const float strength = around.towards_free.norm() / static_cast<float>(around.num_free);
  const Vec3f free_side = strength > 1e-3f ? around.towards_free.normalized() : Vec3f::Zero();
  Vec3f normal = plane_normal(around);
  if (normal.dot(free_side) < 0.f) normal = -normal;
  if (!normal.isZero() && strength > kOneSided && normal.dot(free_side) > 0.3f &&
      state_behind(window, leaf, normal) != State::kFree) {
    return {normal, kPlanarQuality};
  }
  if (strength > kOneSided) {
    const bool is_solid = state_behind(window, leaf, free_side) == State::kOccupied;
    return {free_side, is_solid ? kSolidQuality : kOneSidedQuality};
  }
  // Seen from all around: the hits lie on the side they came from.
  const bool has_side = leaf.mean.norm() > 0.05f;
  return {has_side              ? Vec3f(leaf.mean.normalized())
          : !free_side.isZero() ? free_side
                                : Vec3f(Vec3f::UnitX()),
          kThinQuality};
}

}  // namespace voxnav::submap
