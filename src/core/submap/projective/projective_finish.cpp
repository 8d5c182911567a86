// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <limits>

#include "submap/content/field_window.hpp"
#include "voxnav/submap/projective_integrator.hpp"

namespace voxnav::submap {
namespace {

using containers::State;
using geometry::Index3;
using geometry::Vec3f;

}  // namespace

bool ProjectiveIntegrator::observed(const Index3& index, float* distance) const {
  float weight = 0.f;
  return voxel(index, distance, &weight) && weight >= config_.min_weight;
}

/// Central difference in metres per voxel, one-sided where one side is missing; false where an axis has neither.
bool ProjectiveIntegrator::gradient(const Index3& index, float distance, Vec3f* out) const {
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

/// A 6-neighbour in front of the surface that does not hold the surface itself.
bool ProjectiveIntegrator::has_free_neighbor(const Index3& index) const {
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

FilledBlock ProjectiveIntegrator::fill(const Index3& index, const Block& block) const {
  FilledBlock out;
  out.index = index;
  out.values.assign(geometry::kBlockVolume, std::numeric_limits<float>::quiet_NaN());
  const auto v = static_cast<float>(config_.resolution_m);
  const auto saturated = static_cast<float>(0.999 * config_.truncation_m);
  for (int offset = 0; offset < geometry::kBlockVolume; ++offset) {
    const auto i = static_cast<std::size_t>(offset);
    const float distance = block[i].distance;
    if (!(block[i].weight >= config_.min_weight)) continue;
    if (std::abs(distance) < saturated) out.values[i] = distance / v;
    const Index3 voxel = geometry::voxel_at(index, offset);
    Vec3f slope = Vec3f::Zero();
    const bool has_slope = gradient(voxel, distance, &slope);
    // Foot of the voxel centre on the zero level, in voxel edges.
    Vec3f foot = has_slope ? Vec3f(-distance * slope / slope.squaredNorm()) : Vec3f::Zero();
    // At a thin thing the slope says nothing, but the distance is small or a free neighbour shows its skin.
    const bool is_near = std::abs(distance) <= 0.5f * v || (has_slope && foot.cwiseAbs().maxCoeff() <= 0.5f);
    const bool is_surface = is_near || (distance <= 0.f && has_free_neighbor(voxel));
    foot = foot.cwiseMax(-0.5f).cwiseMin(0.5f);
    if (is_surface) {
      FilledLeaf leaf;
      leaf.offset = static_cast<std::uint16_t>(offset);
      for (int k = 0; k < 3; ++k)
        leaf.mean[static_cast<std::size_t>(k)] = static_cast<std::int8_t>(std::lround(foot[k] * 254.f));
      leaf.hits = static_cast<std::uint8_t>(std::min(255.f, std::ceil(block[i].weight)));
      leaf.normal = has_slope ? Vec3f(slope.normalized()) : Vec3f::Zero();
      leaf.quality = has_slope ? kPlanarQuality : 0.f;
      out.leaves.push_back(leaf);
      out.states.set(offset, State::kOccupied);
    } else if (distance > 0.f) {
      out.states.set(offset, State::kFree);
    }
  }
  return out;
}

std::shared_ptr<Submap> ProjectiveIntegrator::finish(const SubmapConfig& config, const geometry::Pose& T_S_G) {
  std::vector<FilledBlock> filled;
  filled.reserve(blocks_.size());
  for (const auto& entry : blocks_) filled.push_back(fill(entry.first, *entry.second));
  std::sort(filled.begin(), filled.end(), [](const FilledBlock& a, const FilledBlock& b) { return a.index < b.index; });
  auto submap = std::make_shared<Submap>(filled, config_.resolution_m, T_S_G, config);
  blocks_.clear();
  scan_ = 0;
  return submap;
}

}  // namespace voxnav::submap
