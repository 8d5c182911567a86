// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <limits>

#include "submap/projective/projective_volume.hpp"

namespace voxnav::submap {
namespace {

using containers::VoxelState;
using geometry::Index3;
using geometry::Vec3f;

}  // namespace

bool ProjectiveIntegrator::Volume::observed(const Index3& index, float* distance) const {
  float weight = 0.f;
  return voxel(index, distance, &weight) && weight >= config_.min_weight;
}

/// Computes the gradient by central differences [m per voxel], one-sided if one neighbour is missing; returns false if
/// both neighbours on an axis are missing.
bool ProjectiveIntegrator::Volume::gradient(const Index3& index, float distance, Vec3f* out) const {
  for (int axis = 0; axis < 3; ++axis) {
    const Index3 step{axis == 0, axis == 1, axis == 2};
    float ahead = 0.f;
    float behind = 0.f;
    const bool has_ahead = observed(index + step, &ahead);
    const bool has_behind = observed(index - step, &behind);
    if (!has_ahead && !has_behind) return false;
    (*out)[axis] = has_ahead && has_behind ? 0.5f * (ahead - behind) : has_ahead ? ahead - distance : distance - behind;
  }
  return out->norm() > 1e-6f;
}

/// Returns true if a 6-neighbour lies in front of the surface and does not contain it.
bool ProjectiveIntegrator::Volume::has_free_neighbor(const Index3& index) const {
  for (int i = 0; i < 6; ++i) {
    const int side = i % 2 == 0 ? 1 : -1;
    float distance = 0.f;
    if (observed(index + Index3{i / 2 == 0 ? side : 0, i / 2 == 1 ? side : 0, i / 2 == 2 ? side : 0}, &distance) &&
        distance > 0.5f * static_cast<float>(config_.resolution_m)) {
      return true;
    }
  }
  return false;
}

std::optional<ProjectiveIntegrator::Volume::Surface> ProjectiveIntegrator::Volume::surface_at(const Index3& voxel,
                                                                                              float distance) const {
  const auto v = static_cast<float>(config_.resolution_m);
  Vec3f slope = Vec3f::Zero();
  const bool has_slope = gradient(voxel, distance, &slope);
  const Vec3f foot = has_slope ? Vec3f(-distance * slope / slope.squaredNorm()) : Vec3f::Zero();
  // At a thin thing the gradient is meaningless, but the distance is small or a free neighbour shows its skin.
  const bool is_near = std::abs(distance) <= 0.5f * v || (has_slope && foot.cwiseAbs().maxCoeff() <= 0.5f);
  if (!is_near && !(distance <= 0.f && has_free_neighbor(voxel))) return std::nullopt;
  Surface out{foot.cwiseMax(-0.5f).cwiseMin(0.5f), {}};
  if (has_slope) out.normal = {slope.normalized(), kPlanarQuality};
  return out;
}

void ProjectiveIntegrator::Volume::add_measured(const Index3& index, const Block& block, Measured* out) const {
  occupancy::ContentBlock content;
  content.index = index;
  std::vector<SurfaceNormal> normals;
  std::vector<float> distances(geometry::kBlockVolume, std::numeric_limits<float>::quiet_NaN());
  const auto saturated = static_cast<float>(0.999 * config_.truncation_m);
  for (int offset = 0; offset < geometry::kBlockVolume; ++offset) {
    const auto i = static_cast<std::size_t>(offset);
    const float distance = block[i].distance;
    if (!(block[i].weight >= config_.min_weight)) continue;
    if (std::abs(distance) < saturated) distances[i] = distance / static_cast<float>(config_.resolution_m);
    const auto surface = surface_at(geometry::voxel_at(index, offset), distance);
    if (surface) {
      occupancy::OccupiedVoxel voxel;
      voxel.offset = static_cast<std::uint16_t>(offset);
      for (int k = 0; k < 3; ++k)
        voxel.believed.mean[static_cast<std::size_t>(k)] =
            static_cast<std::int8_t>(std::lround(surface->foot[k] * 254.f));
      voxel.believed.hits = static_cast<std::uint8_t>(std::min(255.f, std::ceil(block[i].weight)));
      voxel.observed = voxel.believed;
      content.occupied.push_back(voxel);
      content.states.set(offset, VoxelState::kOccupied);
      normals.push_back(surface->normal);
    } else if (distance > 0.f) {
      content.states.set(offset, VoxelState::kFree);
      content.observed_free[i / 64] |= std::uint64_t{1} << (i % 64);
    }
  }
  out->content.blocks.push_back(std::move(content));
  out->normals.push_back(std::move(normals));
  out->distances.push_back(std::move(distances));
}

ProjectiveIntegrator::Volume::Measured ProjectiveIntegrator::Volume::measured() const {
  std::vector<Index3> order;
  order.reserve(blocks_.size());
  for (const auto& entry : blocks_) order.push_back(entry.first);
  std::sort(order.begin(), order.end());
  Measured out;
  out.content.resolution_m = config_.resolution_m;
  for (const Index3& index : order) add_measured(index, *blocks_.at(index), &out);
  return out;
}

}  // namespace voxnav::submap
