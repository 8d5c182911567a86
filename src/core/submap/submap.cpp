// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/submap/submap.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "voxnav/submap/occupancy_filling.hpp"
#include "voxnav/submap/surface_sampling.hpp"
#include "voxnav/submap/voxel_walk.hpp"

namespace voxnav::submap {
namespace {

using containers::State;
using geometry::Index3;
using geometry::Vec3;

constexpr double kMaxIndex = 1073741824.0;  // 2^30: beyond it voxel indices would overflow

struct Trilinear {
  double value;
  Vec3 gradient;
};

/// @param c values at the corners, x fastest  @param t position in the cell, 0 to 1
Trilinear interpolate(const std::array<float, 8>& c, const Vec3& t) {
  const auto mix = [](double a, double b, double ratio) { return a + ratio * (b - a); };
  double x[4];   // interpolated along x, at (y, z) = 00 10 01 11
  double dx[4];  // difference along x
  for (int i = 0; i < 4; ++i) {
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

std::shared_ptr<Submap> Submap::from_content(const occupancy::MapContent& content, const geometry::Pose& T_S_G,
                                             const SubmapConfig& config) {
  base::checked(config);
  return std::make_shared<Submap>(fill_from_occupancy(content, config), content.resolution_m, T_S_G, config);
}

Submap::Submap(const std::vector<FilledBlock>& blocks, double resolution_m, const geometry::Pose& T_S_G,
               const SubmapConfig& config)
    : resolution_m_(resolution_m),
      config_(base::checked(config)),
      T_S_G_(T_S_G),
      T_G_S_(T_S_G.inverse(Eigen::Isometry)),
      field_(blocks, config.band_voxels),
      surface_points_(sample_surface(blocks, resolution_m, T_S_G, config.max_surface_points)) {
  if (!(resolution_m > 0.0) || !std::isfinite(resolution_m))
    throw std::invalid_argument("resolution_m must be positive");
  if (!geometry::is_valid(T_S_G)) throw std::invalid_argument("T_S_G must be a finite rigid transform");
  update_bounds();
}

void Submap::update_bounds() {
  for (const geometry::SurfacePoint& point : surface_points_) surface_bounds_.extend(point.position.cast<double>());
  geometry::Aabb known_G;
  const double side_m = geometry::kBlockSide * resolution_m_;
  for (std::size_t i = 0; i < field_.num_blocks(); ++i) {
    const Index3& b = field_.block_index(i);
    known_G.extend(Vec3(b.x, b.y, b.z) * side_m);
    known_G.extend(Vec3(b.x + 1, b.y + 1, b.z + 1) * side_m);
  }
  known_bounds_ = known_G.transformed(T_S_G_);
}

bool Submap::sample(const Vec3& p_S, double* distance_m, Vec3* gradient) const {
  const Vec3 p = (T_G_S_ * p_S) / resolution_m_;
  if (!(p.array().abs() < kMaxIndex).all()) return false;
  const State state = field_.state(floor_index(p));
  if (state == State::kUnknown) return false;
  double distance = 0.0;
  Vec3 slope = Vec3::Zero();
  if (config_.certified) {
    sample_certified(p, &distance, &slope);
  } else if (!sample_near(p, &distance, &slope)) {
    sample_far(p, CompressedField::Target::kSurfacePoint, &distance, &slope);
    if (state == State::kOccupied) {
      // Only where a projective submap ends right at the surface: the sign is that of the voxel.
      distance = -distance;
      slope = -slope;
    }
  }
  *distance_m = distance * resolution_m_;
  if (gradient) *gradient = T_S_G_.linear() * slope;
  return true;
}

bool Submap::sample_near(const Vec3& p, double* distance, Vec3* gradient) const {
  const Vec3 from_centers = p - Vec3::Constant(0.5);
  const Index3 lower = floor_index(from_centers);
  std::array<float, 8> corners;
  if (!field_.corners(lower, &corners)) return false;
  const Trilinear mixed = interpolate(corners, from_centers - Vec3(lower.x, lower.y, lower.z));
  *distance = mixed.value;
  *gradient = mixed.gradient;
  return true;
}

void Submap::sample_far(const Vec3& p, CompressedField::Target target, double* distance, Vec3* gradient) const {
  const double limit = config_.max_distance_m / resolution_m_;
  const auto nearest = field_.nearest(p, limit, target);
  *distance = nearest ? std::sqrt(nearest->squared) : limit;
  *gradient = nearest && *distance > 0.0 ? Vec3((p - nearest->point) / *distance) : Vec3::Zero();
}

void Submap::sample_certified(const Vec3& p, double* distance, Vec3* gradient) const {
  sample_far(p, CompressedField::Target::kVoxelCube, distance, gradient);
  if (*distance > 0.0) return;
  double inside = 0.0;
  if (sample_near(p, &inside, gradient)) *distance = std::min(inside, 0.0);
}

State Submap::state(const Vec3& p_S) const {
  const Vec3 p = (T_G_S_ * p_S) / resolution_m_;
  if (!(p.array().abs() < kMaxIndex).all()) return State::kUnknown;
  return field_.state(floor_index(p));
}

std::vector<geometry::Vec3f> Submap::occupied_points() const {
  std::vector<geometry::Vec3f> out;
  out.reserve(field_.num_leaves());
  field_.for_each_leaf([&](const Index3& voxel, const CompressedField::Leaf& leaf) {
    out.push_back((T_S_G_ * (surface_point(voxel, leaf) * resolution_m_)).cast<float>());
  });
  return out;
}

std::size_t Submap::memory_bytes() const {
  return sizeof(*this) - sizeof(field_) + field_.memory_bytes() +
         surface_points_.capacity() * sizeof(geometry::SurfacePoint);
}

}  // namespace voxnav::submap
