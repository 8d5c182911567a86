// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cmath>

#include "kernels/neighborhood.hpp"
#include "submap/content/field_window.hpp"

namespace voxnav::submap {
namespace {

using containers::State;
using geometry::Vec3f;
using kernels::Neighborhood;

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
  normals->assign(leaves.size(), {});
  kernels::NeighborhoodBatch batch;
  kernels::PlaneNormals planes;
  std::array<std::uint16_t, kernels::kTogether> which, place;  // of the batch: leaves, and where their normals go
  std::array<kernels::WindowVoxel, kernels::kTogether> asked;
  std::size_t count = 0;
  const auto finish = [&] {
    for (std::size_t k = count; k < kernels::kTogether; ++k) which[k] = which[0];
    for (std::size_t k = 0; k < kernels::kTogether; ++k) {
      const WindowLeaf& leaf = window.leaves()[which[k]];
      asked[k] = {leaf.x, leaf.y, leaf.z};
    }
    kernels::look_around(window.view(), asked, &batch);
    kernels::fit_planes(batch, &planes);
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
    if (count == kernels::kTogether) finish();
  }
  if (count > 0) finish();
}

}  // namespace voxnav::submap
