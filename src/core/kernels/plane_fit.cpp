// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "kernels/lanes.hpp"
#include "kernels/neighborhood.hpp"

namespace voxnav::kernels {
namespace {

using namespace lanes;  // NOLINT: the vector types of this file

constexpr float kMinPoints = 5.0f;
constexpr float kMaxThickness = 0.2f;  // voxel edges, RMS
constexpr float kMinWidth = 0.35f;

/// The formulas of a plane fit, for eight planes (Number = Floats) or for one (Number = float).
template <class Number>
struct Vec {
  Number x, y, z;
};
template <class Number>
VOXNAV_INLINE Number dot(const Vec<Number>& a, const Vec<Number>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
/// A symmetric 3 x 3 matrix.
template <class Number>
struct Symmetric {
  Number xx, yy, zz, xy, xz, yz;
};
template <class Number>
VOXNAV_INLINE Vec<Number> times(const Symmetric<Number>& m, const Vec<Number>& v) {
  return {m.xx * v.x + m.xy * v.y + m.xz * v.z, m.xy * v.x + m.yy * v.y + m.yz * v.z,
          m.xz * v.x + m.yz * v.y + m.zz * v.z};
}
/// Returns the adjugate, which has the eigenvectors of the matrix, but that of its smallest eigenvalue now belongs to
/// the largest one.
template <class Number>
VOXNAV_INLINE Symmetric<Number> adjugate(const Symmetric<Number>& m) {
  return {m.yy * m.zz - m.yz * m.yz, m.xx * m.zz - m.xz * m.xz, m.xx * m.yy - m.xy * m.xy,
          m.xz * m.yz - m.xy * m.zz, m.xy * m.yz - m.xz * m.yy, m.xy * m.xz - m.yz * m.xx};
}

/// Computes the directions of least variance, of a length near one, from the adjugates of covariances.
VOXNAV_INLINE Vec<Floats> thinnest_direction(const Symmetric<Floats>& adj, Floats largest) {
  const Floats scale = 1.0f / largest;
  const Symmetric<Floats> m = {adj.xx * scale, adj.yy * scale, adj.zz * scale,
                               adj.xy * scale, adj.xz * scale, adj.yz * scale};
  const Ints is_x = adj.xx >= largest, is_y = adj.yy >= largest;
  Vec<Floats> v = {is_x   ? m.xx
                   : is_y ? m.xy
                          : m.xz,
                   is_x   ? m.xy
                   : is_y ? m.yy
                          : m.yz,
                   is_x   ? m.xz
                   : is_y ? m.yz
                          : m.zz};
  // Each step shrinks the components along other directions by the ratio of the two smallest variances.
  for (int i = 0; i < 3; ++i) v = times(m, v);
  return v;
}

VOXNAV_INLINE Floats across(const NeighborhoodBatch& batch, std::array<float, 4> Neighborhood::*member, std::size_t i) {
  Floats out;
  for (std::size_t k = 0; k < kTogether; ++k) out[k] = (batch[k].*member)[i];
  return out;
}

VOXNAV_INLINE void fit(const NeighborhoodBatch& batch, PlaneNormals* normals) {
  static_assert(kTogether == kLanes, "a lane for each voxel");
  const Floats count = across(batch, &Neighborhood::sum, 3), n = 1.0f / count;
  const Vec<Floats> mean = {across(batch, &Neighborhood::sum, 0) * n, across(batch, &Neighborhood::sum, 1) * n,
                            across(batch, &Neighborhood::sum, 2) * n};
  const Symmetric<Floats> covariance = {across(batch, &Neighborhood::squares, 0) * n - mean.x * mean.x,
                                        across(batch, &Neighborhood::squares, 1) * n - mean.y * mean.y,
                                        across(batch, &Neighborhood::squares, 2) * n - mean.z * mean.z,
                                        across(batch, &Neighborhood::products, 0) * n - mean.x * mean.y,
                                        across(batch, &Neighborhood::products, 2) * n - mean.x * mean.z,
                                        across(batch, &Neighborhood::products, 1) * n - mean.y * mean.z};
  const Symmetric<Floats> adj = adjugate(covariance);
  const Floats largest = larger(adj.xx, larger(adj.yy, adj.zz));
  const Vec<Floats> v = thinnest_direction(adj, largest);
  const Floats squared = dot(v, v);
  const Floats thin = dot(v, times(covariance, v)) / squared;
  // Of the other two variances the sum and the product are known, so also the smaller one,
  // (sum - sqrt(sum^2 - 4 product)) / 2; it is compared without taking the root.
  const Floats sum = covariance.xx + covariance.yy + covariance.zz - thin;
  const Floats product = adj.xx + adj.yy + adj.zz - thin * sum;
  const Floats room = sum - 2.0f * kMinWidth * kMinWidth;
  const Ints is_plane = (count >= kMinPoints) & (largest > 0.0f) & (thin < kMaxThickness * kMaxThickness) &
                        (room > 0.0f) & (room * room > sum * sum - 4.0f * product);
  const Floats scale = 1.0f / exact_root(squared);
  store(is_plane ? v.x * scale : Floats{}, (*normals)[0].data());
  store(is_plane ? v.y * scale : Floats{}, (*normals)[1].data());
  store(is_plane ? v.z * scale : Floats{}, (*normals)[2].data());
}
void fit_plain(const NeighborhoodBatch& batch, PlaneNormals* normals) { fit(batch, normals); }
VOXNAV_WIDE void fit_wide(const NeighborhoodBatch& batch, PlaneNormals* normals) { fit(batch, normals); }

}  // namespace

void fit_planes(const NeighborhoodBatch& batch, PlaneNormals* normals) {
  (is_wide() ? fit_wide : fit_plain)(batch, normals);
}

std::array<float, 3> reference::fit_plane(const Neighborhood& around) {
  const float count = around.sum[3], n = 1.0f / count;
  const Vec<float> mean{around.sum[0] * n, around.sum[1] * n, around.sum[2] * n};
  const Symmetric<float> covariance{around.squares[0] * n - mean.x * mean.x,  around.squares[1] * n - mean.y * mean.y,
                                    around.squares[2] * n - mean.z * mean.z,  around.products[0] * n - mean.x * mean.y,
                                    around.products[2] * n - mean.x * mean.z, around.products[1] * n - mean.y * mean.z};
  const Symmetric<float> adj = adjugate(covariance);
  const float largest = std::max(adj.xx, std::max(adj.yy, adj.zz));
  if (!(count >= kMinPoints && largest > 0.0f)) return {};
  // Power iteration with the scaled adjugate, from its longest column.
  const float scale = 1.0f / largest;
  const Symmetric<float> m{adj.xx * scale, adj.yy * scale, adj.zz * scale,
                           adj.xy * scale, adj.xz * scale, adj.yz * scale};
  Vec<float> v{m.xz, m.yz, m.zz};
  if (adj.yy >= largest) v = {m.xy, m.yy, m.yz};
  if (adj.xx >= largest) v = {m.xx, m.xy, m.xz};
  for (int i = 0; i < 3; ++i) v = times(m, v);
  const float squared = dot(v, v), thin = dot(v, times(covariance, v)) / squared;
  const float sum = covariance.xx + covariance.yy + covariance.zz - thin;
  const float product = adj.xx + adj.yy + adj.zz - thin * sum;
  const float room = sum - 2.0f * kMinWidth * kMinWidth;
  const bool is_wide_enough = room > 0.0f && room * room > sum * sum - 4.0f * product;
  if (!(thin < kMaxThickness * kMaxThickness) || !is_wide_enough) return {};
  const float length = 1.0f / std::sqrt(squared);
  return {v.x * length, v.y * length, v.z * length};
}

}  // namespace voxnav::kernels
