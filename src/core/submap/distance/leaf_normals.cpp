// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cmath>

#include "kernels/lanes.hpp"
#include "kernels/bits.hpp"
#include "submap/content/field_window.hpp"

namespace voxnav::submap {
namespace {

using namespace kernels::lanes;  // NOLINT: the vector types of this file
using containers::State;
using geometry::Vec3f;

using Quad = float __attribute__((vector_size(16)));

/// What the 26 voxels around a leaf say.
struct Neighborhood {
  std::array<float, 4> towards_free;  ///< sum of unit directions, and how many they are
  std::array<float, 4> sum;           ///< x y z of the surface points from the leaf's centre, and how many they are
  std::array<float, 4> squares;       ///< xx yy zz
  std::array<float, 4> products;      ///< xy yz zx
};
using Batch = std::array<Neighborhood, kLanes>;

/// Sums of the unit vectors to the free ones of three voxels beside each other, and their number, for each of the nine
/// rows.
using RowSums = std::array<std::array<std::array<float, 4>, 8>, 9>;
RowSums make_sums() {
  RowSums out;
  for (int row = 0; row < 9; ++row) {
    for (int bits = 0; bits < 8; ++bits) {
      Eigen::Vector4f sum = Eigen::Vector4f::Zero();
      for (int k = 0; k < 3; ++k) {
        const Vec3f step(static_cast<float>(k - 1), static_cast<float>(row % 3 - 1), static_cast<float>(row / 3 - 1));
        if (((bits >> k) & 1) && !step.isZero()) sum += step.normalized().homogeneous();
      }
      out[static_cast<std::size_t>(row)][static_cast<std::size_t>(bits)] = {sum[0], sum[1], sum[2], sum[3]};
    }
  }
  return out;
}

/// Neighbours are listed first and summed up then: without branches but one.
VOXNAV_INLINE void look_around(const FieldWindow& window, const WindowLeaf& leaf, const RowSums& sums,
                               Neighborhood* out) {
  constexpr unsigned kCount[8] = {0, 1, 1, 2, 1, 2, 2, 3};
  unsigned others[27 + 3];
  unsigned num_others = 0;
  Quad towards_free{};
  const int shift = leaf.x - 1 + FieldWindow::kHalo;
  for (int row = 0; row < 9; ++row) {
    const int y = leaf.y + row % 3 - 1;
    const int z = leaf.z + row / 3 - 1;
    towards_free += loaded<Quad>(&sums[static_cast<std::size_t>(row)][(window.free(y, z) >> shift) & 7u]);
    const std::uint32_t occupied = window.occupied(y, z);
    const unsigned first = window.first_leaf(y, z) + kernels::count_bits(occupied & ((1u << shift) - 1u));
    for (unsigned k = 0; k < 3; ++k) others[num_others + k] = first + k;
    num_others += kCount[(occupied >> shift) & 7u];
  }
  const auto x = static_cast<float>(leaf.x), y = static_cast<float>(leaf.y), z = static_cast<float>(leaf.z);
  const Quad center = {x, y, z, 0.f}, turned_center = {y, z, x, 0.f};
  Quad sum{}, squares{}, products{};
  for (unsigned i = 0; i < num_others; ++i) {
    const FieldWindow::Point& point = window.points()[others[i]];
    const Quad p = loaded<Quad>(point.data()) - center;
    sum += p;
    squares += p * p;
    products += p * (loaded<Quad>(point.data() + 4) - turned_center);
  }
  store(towards_free, out->towards_free.data());
  store(sum, out->sum.data());
  store(squares, out->squares.data());
  store(products, out->products.data());
}

struct Vec {
  Floats x, y, z;
};
VOXNAV_INLINE Floats dot(const Vec& a, const Vec& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

/// Symmetric 3 x 3 matrices.
struct Symmetric {
  Floats xx, yy, zz, xy, xz, yz;
};
VOXNAV_INLINE Vec times(const Symmetric& m, const Vec& v) {
  return {m.xx * v.x + m.xy * v.y + m.xz * v.z, m.xy * v.x + m.yy * v.y + m.yz * v.z,
          m.xz * v.x + m.yz * v.y + m.zz * v.z};
}
/// Adjugate: the eigenvectors of the matrix, the one of the smallest eigenvalue now being the strongest.
VOXNAV_INLINE Symmetric adjugate(const Symmetric& m) {
  return {m.yy * m.zz - m.yz * m.yz, m.xx * m.zz - m.xz * m.xz, m.xx * m.yy - m.xy * m.xy,
          m.xz * m.yz - m.xy * m.zz, m.xy * m.yz - m.xz * m.yy, m.xy * m.xz - m.yz * m.xx};
}

/// The thinnest directions of covariances, of a length that is not far from one, from their adjugates.
VOXNAV_INLINE Vec thinnest_direction(const Symmetric& adj, Floats largest) {
  const Floats scale = 1.0f / largest;
  const Symmetric m = {adj.xx * scale, adj.yy * scale, adj.zz * scale, adj.xy * scale, adj.xz * scale, adj.yz * scale};
  const Ints is_x = adj.xx >= largest, is_y = adj.yy >= largest;
  Vec v = {is_x ? m.xx : is_y ? m.xy : m.xz, is_x ? m.xy : is_y ? m.yy : m.yz, is_x ? m.xz : is_y ? m.yz : m.zz};
  // The share of other directions shrinks by the ratio of the two smallest spreads.
  for (int i = 0; i < 3; ++i) v = times(m, v);
  return v;
}

template <std::size_t kSize>
VOXNAV_INLINE Floats across(const Batch& batch, std::array<float, kSize> Neighborhood::*member, std::size_t i) {
  Floats out;
  for (std::size_t k = 0; k < kLanes; ++k) out[k] = (batch[k].*member)[i];
  return out;
}

/// Normals of the planes through the neighbouring surface points, either way up; zero where these do not lie in one.
using Normals = std::array<std::array<float, kLanes>, 3>;
VOXNAV_INLINE void fit_planes(const Batch& batch, Normals* normals) {
  constexpr float kMinLeaves = 5.0f;
  constexpr float kMaxThickness = 0.2f;  // voxel edges, RMS
  constexpr float kMinWidth = 0.35f;
  const Floats count = across(batch, &Neighborhood::sum, 3), n = 1.0f / count;
  const Vec mean = {across(batch, &Neighborhood::sum, 0) * n, across(batch, &Neighborhood::sum, 1) * n,
                    across(batch, &Neighborhood::sum, 2) * n};
  const Symmetric covariance = {across(batch, &Neighborhood::squares, 0) * n - mean.x * mean.x,
                                across(batch, &Neighborhood::squares, 1) * n - mean.y * mean.y,
                                across(batch, &Neighborhood::squares, 2) * n - mean.z * mean.z,
                                across(batch, &Neighborhood::products, 0) * n - mean.x * mean.y,
                                across(batch, &Neighborhood::products, 2) * n - mean.x * mean.z,
                                across(batch, &Neighborhood::products, 1) * n - mean.y * mean.z};
  const Symmetric adj = adjugate(covariance);
  const Floats largest = larger(adj.xx, larger(adj.yy, adj.zz));
  const Vec v = thinnest_direction(adj, largest);
  const Floats squared = dot(v, v);
  const Floats thin = dot(v, times(covariance, v)) / squared;
  // Of the other two variances the sum and the product are known, so also the smaller one,
  // (sum - sqrt(sum^2 - 4 product)) / 2; it is compared without taking the root.
  const Floats sum = covariance.xx + covariance.yy + covariance.zz - thin;
  const Floats product = adj.xx + adj.yy + adj.zz - thin * sum;
  const Floats room = sum - 2.0f * kMinWidth * kMinWidth;
  const Ints is_plane = (count >= kMinLeaves) & (largest > 0.0f) & (thin < kMaxThickness * kMaxThickness) &
                        (room > 0.0f) & (room * room > sum * sum - 4.0f * product);
  const Floats scale = 1.0f / exact_root(squared);
  store(is_plane ? v.x * scale : Floats{}, (*normals)[0].data());
  store(is_plane ? v.y * scale : Floats{}, (*normals)[1].data());
  store(is_plane ? v.z * scale : Floats{}, (*normals)[2].data());
}

/// For a whole batch of leaves.
VOXNAV_INLINE void look_at(const FieldWindow& window, const std::uint16_t* leaves, const RowSums& sums, Batch* batch,
                           Normals* normals) {
  for (std::size_t k = 0; k < kLanes; ++k) look_around(window, window.leaves()[leaves[k]], sums, &(*batch)[k]);
  fit_planes(*batch, normals);
}
void look_at_plain(const FieldWindow& window, const std::uint16_t* leaves, const RowSums& sums, Batch* batch,
                   Normals* normals) {
  look_at(window, leaves, sums, batch, normals);
}
VOXNAV_WIDE void look_at_wide(const FieldWindow& window, const std::uint16_t* leaves, const RowSums& sums, Batch* batch,
                              Normals* normals) {
  look_at(window, leaves, sums, batch, normals);
}

State state_behind(const FieldWindow& window, const WindowLeaf& leaf, const Vec3f& normal) {
  const float half = 0.5f * normal.cwiseAbs().maxCoeff();
  const auto step = [&](float c) { return (c <= -half ? 1 : 0) - (c >= half ? 1 : 0); };
  return window.state(leaf.x + step(normal.x()), leaf.y + step(normal.y()), leaf.z + step(normal.z()));
}

LeafNormal judge(const FieldWindow& window, const WindowLeaf& leaf, const Neighborhood& around, Vec3f normal) {
  constexpr float kOneSided = 0.25f;
  const float num_free = around.towards_free[3];
  const Vec3f towards_free(around.towards_free[0], around.towards_free[1], around.towards_free[2]);
  const float length = towards_free.norm();
  const float strength = length / num_free;
  const Vec3f free_side = strength > 1e-3f ? Vec3f(towards_free * (1.f / length)) : Vec3f(Vec3f::Zero());
  if (strength > kOneSided) {
    const float along = normal.dot(free_side);  // zero where there is no plane
    if (along < 0.f) normal = -normal;
    if (std::abs(along) > 0.3f && state_behind(window, leaf, normal) != State::kFree) return {normal, kPlanarQuality};
    const bool is_solid = state_behind(window, leaf, free_side) == State::kOccupied;
    return {free_side, is_solid ? kSolidQuality : kOneSidedQuality};
  }
  // Seen from all around: the hits lie on the side they came from.
  const bool has_side = leaf.mean().norm() > 0.05f;
  return {has_side              ? Vec3f(leaf.mean().normalized())
          : !free_side.isZero() ? free_side
                                : Vec3f(Vec3f::UnitX()),
          kThinQuality};
}

/// Whether anything around a leaf is free.
bool is_seen(const FieldWindow& window, const WindowLeaf& leaf) {
  std::uint32_t free = 0;
  for (int row = 0; row < 9; ++row) free |= window.free(leaf.y + row % 3 - 1, leaf.z + row / 3 - 1);
  return ((free >> (leaf.x - 1 + FieldWindow::kHalo)) & 7u) != 0;
}

}  // namespace

void estimate_normals(const FieldWindow& window, const std::vector<std::uint16_t>& leaves,
                      std::vector<LeafNormal>* normals) {
  static const RowSums sums = make_sums();
  normals->assign(leaves.size(), {});
  Batch batch;
  Normals planes;
  std::array<std::uint16_t, kLanes> which, place;  // of the batch: leaves, and where their normals go
  std::size_t count = 0;
  const auto finish = [&] {
    for (std::size_t k = count; k < kLanes; ++k) which[k] = which[0];
    (kernels::is_wide() ? look_at_wide : look_at_plain)(window, which.data(), sums, &batch, &planes);
    for (std::size_t k = 0; k < count; ++k) {
      (*normals)[place[k]] =
          judge(window, window.leaves()[which[k]], batch[k], Vec3f(planes[0][k], planes[1][k], planes[2][k]));
    }
    count = 0;
  };
  for (std::size_t i = 0; i < leaves.size(); ++i) {
    if (!is_seen(window, window.leaves()[leaves[i]])) continue;  // deep inside
    which[count] = leaves[i];
    place[count++] = static_cast<std::uint16_t>(i);
    if (count == kLanes) finish();
  }
  if (count > 0) finish();
}

}  // namespace voxnav::submap
