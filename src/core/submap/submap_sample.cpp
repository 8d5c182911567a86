// SPDX-License-Identifier: BSD-3-Clause
// Distances and gradients at any point of a submap.
#include <algorithm>
#include <array>
#include <cmath>

#include "submap/content/nearest_point.hpp"
#include "submap/distance/distance_cache.hpp"
#include "submap/voxel_walk.hpp"
#include "voxnav/submap/submap.hpp"

namespace voxnav::submap {
namespace {

using containers::VoxelState;
using geometry::Index3;
using geometry::Vec3;

constexpr double kMaxIndex = 1073741824.0;  // 2^30: beyond it voxel indices would overflow

struct Trilinear {
  double value;
  Vec3 gradient;
};

/// Trilinear interpolation and its gradient.
/// @param c  values at the corners of the cell, x fastest
/// @param t  position in the cell, 0 to 1 on each axis
Trilinear interpolate(const std::array<float, 8>& c, const Vec3& t) {
  const auto mix = [](double a, double b, double ratio) { return a + ratio * (b - a); };
  double x[4];   // interpolated along x, at (y, z) = 00 10 01 11
  double dx[4];  // difference along x
  for (std::size_t i = 0; i < 4; ++i) {
    dx[i] = static_cast<double>(c[2 * i + 1]) - c[2 * i];
    x[i] = c[2 * i] + t.x() * dx[i];
  }
  const double low = mix(x[0], x[1], t.y());
  const double high = mix(x[2], x[3], t.y());
  Trilinear out;
  out.value = mix(low, high, t.z());
  out.gradient.x() = mix(mix(dx[0], dx[1], t.y()), mix(dx[2], dx[3], t.y()), t.z());
  out.gradient.y() = mix(x[1] - x[0], x[3] - x[2], t.z());
  out.gradient.z() = high - low;
  return out;
}

}  // namespace

bool Submap::sample(const Vec3& p_S, double* distance_m, Vec3* gradient) const {
  return sample_in(*content(), p_S, distance_m, gradient);
}

bool Submap::sample_in(const SubmapContent& content, const Vec3& p_S, double* distance_m, Vec3* gradient) const {
  const Vec3 p = (T_G_S_ * p_S) / resolution_m_;
  if (!(p.array().abs() < kMaxIndex).all()) return false;
  const Index3 voxel = floor_index(p);
  const auto position = content.states().find(geometry::block_of(voxel));
  if (!position) return false;
  const VoxelState state = content.states().state(*position, geometry::offset_in_block(voxel));
  if (state == VoxelState::kUnknown) return false;
  double distance = 0.0;
  Vec3 slope = Vec3::Zero();
  if (config_.certified) {
    sample_certified(content, *position, p, &distance, &slope);
  } else if (!sample_near(content, *position, p, &distance, &slope)) {
    sample_far(content, p, &distance, &slope);
    if (state == VoxelState::kOccupied) {
      // This happens only where a projective submap ends right at the surface: the sign is that of the voxel.
      distance = -distance;
      slope = -slope;
    }
  }
  *distance_m = distance * resolution_m_;
  if (gradient) *gradient = T_S_G_.linear() * slope;
  return true;
}

bool Submap::sample_near(const SubmapContent& content, std::size_t position, const Vec3& p, double* distance,
                         Vec3* gradient) const {
  const Vec3 from_centers = p - Vec3::Constant(0.5);
  const Index3 lower = floor_index(from_centers);
  const Index3 local = lower - geometry::voxel_at(content.states().index(position), 0);
  std::array<float, 8> corners;
  if (!cache_->get(content, position)->corners(local.x, local.y, local.z, &corners)) return false;
  const Trilinear mixed = interpolate(corners, from_centers - Vec3(lower.x, lower.y, lower.z));
  *distance = mixed.value;
  *gradient = mixed.gradient;
  return true;
}

void Submap::sample_far(const SubmapContent& content, const Vec3& p, double* distance, Vec3* gradient) const {
  const double limit = config_.max_distance_m / resolution_m_;
  const NearestTarget target = config_.certified ? NearestTarget::kVoxelCube : NearestTarget::kSurfacePoint;
  const auto nearest = find_nearest(content, p, limit, target);
  *distance = nearest ? std::sqrt(nearest->squared) : limit;
  *gradient = nearest && *distance > 0.0 ? Vec3((p - nearest->point) / *distance) : Vec3::Zero();
}

void Submap::sample_certified(const SubmapContent& content, std::size_t position, const Vec3& p, double* distance,
                              Vec3* gradient) const {
  sample_far(content, p, distance, gradient);
  if (*distance > 0.0) return;
  double inside = 0.0;
  if (sample_near(content, position, p, &inside, gradient)) *distance = std::min(inside, 0.0);
}

}  // namespace voxnav::submap
