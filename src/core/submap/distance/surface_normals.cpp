// SPDX-License-Identifier: BSD-3-Clause
#include "submap/distance/surface_normals.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "kernels/neighborhood.hpp"

namespace voxnav::submap {
namespace {

using containers::VoxelState;
using geometry::Vec3f;
using kernels::Neighborhood;

VoxelState state_behind(const ContentWindow& window, const geometry::Index3& voxel, const Vec3f& normal) {
  const float half = 0.5f * normal.cwiseAbs().maxCoeff();
  const auto step = [&](float c) { return (c <= -half ? 1 : 0) - (c >= half ? 1 : 0); };
  return window.state(voxel.x + step(normal.x()), voxel.y + step(normal.y()), voxel.z + step(normal.z()));
}

/// Chooses the side and the quality of a normal.
/// @param normal  normal of the plane through the surface points around, of either sign; zero if there is no plane
SurfaceNormal judge(const ContentWindow& window, std::size_t i, const Neighborhood& around, Vec3f normal) {
  const geometry::Index3& voxel = window.voxels()[i];
  constexpr float kOneSided = 0.25f;
  const float num_free = around.towards_free[3];
  const Vec3f towards_free(around.towards_free[0], around.towards_free[1], around.towards_free[2]);
  const float length = towards_free.norm();
  const float strength = length / num_free;
  const Vec3f free_side = strength > 1e-3f ? Vec3f(towards_free * (1.f / length)) : Vec3f(Vec3f::Zero());
  if (strength > kOneSided) {
    const float along = normal.dot(free_side);  // zero if there is no plane
    if (along < 0.f) normal = -normal;
    if (std::abs(along) > 0.3f && state_behind(window, voxel, normal) != VoxelState::kFree)
      return {normal, kPlanarQuality};
    const bool is_solid = state_behind(window, voxel, free_side) == VoxelState::kOccupied;
    return {free_side, is_solid ? kSolidQuality : kOneSidedQuality};
  }
  // A thin thing was seen from all around. Its mean hit lies towards the side from which most hits came.
  const Vec3f mean = window.mean(i);
  const bool has_side = mean.norm() > 0.05f;
  return {has_side ? Vec3f(mean.normalized()) : !free_side.isZero() ? free_side : Vec3f(Vec3f::UnitX()), kThinQuality};
}

/// Returns true if any of the 26 neighbours of a voxel is free.
bool is_seen(const ContentWindow& window, const geometry::Index3& voxel) {
  std::uint32_t free = 0;
  for (int row = 0; row < 9; ++row) free |= window.free(voxel.y + row % 3 - 1, voxel.z + row / 3 - 1);
  return ((free >> (voxel.x - 1 + ContentWindow::kHalo)) & 7u) != 0;
}

}  // namespace

void estimate_normals(const ContentWindow& window, const std::vector<std::uint16_t>& voxels,
                      std::vector<SurfaceNormal>* normals) {
  normals->assign(voxels.size(), {});
  kernels::NeighborhoodBatch batch;
  kernels::PlaneNormals planes;
  std::array<std::uint16_t, kernels::kTogether> which, place;  // voxels of the batch, and the indices of their normals
  std::array<geometry::Index3, kernels::kTogether> asked;
  std::size_t count = 0;
  const auto finish = [&] {
    for (std::size_t k = count; k < kernels::kTogether; ++k) which[k] = which[0];
    for (std::size_t k = 0; k < kernels::kTogether; ++k) asked[k] = window.voxels()[which[k]];
    kernels::look_around(window.view(), asked, &batch);
    kernels::fit_planes(batch, &planes);
    for (std::size_t k = 0; k < count; ++k) {
      (*normals)[place[k]] = judge(window, which[k], batch[k], Vec3f(planes[0][k], planes[1][k], planes[2][k]));
    }
    count = 0;
  };
  for (std::size_t i = 0; i < voxels.size(); ++i) {
    if (!is_seen(window, window.voxels()[voxels[i]])) continue;  // deep inside
    which[count] = voxels[i];
    place[count++] = static_cast<std::uint16_t>(i);
    if (count == kernels::kTogether) finish();
  }
  if (count > 0) finish();
}

}  // namespace voxnav::submap
