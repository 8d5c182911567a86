// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/submap/submap.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "submap/content/thin_leaves.hpp"
#include "submap/registration/surface_sampling.hpp"
#include "submap/voxel_walk.hpp"

namespace voxnav::submap {
namespace {

using containers::State;
using geometry::Index3;
using geometry::Vec3;

constexpr double kMaxIndex = 1073741824.0;  // 2^30: beyond it voxel indices would overflow

constexpr double kFinest_m = 1e-3;  // as in files: beyond, distances in voxels are no numbers any more
constexpr double kCoarsest_m = 1e3;

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

void check_frame(double resolution_m, const geometry::Pose& T_S_G) {
  if (!(resolution_m >= kFinest_m && resolution_m <= kCoarsest_m))
    throw std::invalid_argument("resolution_m must be from 0.001 to 1000");
  if (!geometry::is_valid(T_S_G)) throw std::invalid_argument("T_S_G must be a finite rigid transform");
}

}  // namespace

std::shared_ptr<Submap> Submap::from_content(const occupancy::MapContent& content, const geometry::Pose& T_S_G,
                                             const SubmapConfig& config) {
  base::checked(config);
  check_frame(content.resolution_m, T_S_G);
  return from_field(CompressedField(content, config.band_voxels), content.resolution_m, T_S_G, config);
}

std::shared_ptr<Submap> Submap::from_field(CompressedField field, double resolution_m, const geometry::Pose& T_S_G,
                                           const SubmapConfig& config) {
  check_frame(resolution_m, T_S_G);
  std::shared_ptr<Submap> out(new Submap());
  out->resolution_m_ = resolution_m;
  out->config_ = config;
  out->T_S_G_ = T_S_G;
  out->T_G_S_ = T_S_G.inverse(Eigen::Isometry);
  out->take_field(std::move(field));
  return out;
}

Submap::Submap(const std::vector<FilledBlock>& blocks, double resolution_m, const geometry::Pose& T_S_G,
               const SubmapConfig& config)
    : resolution_m_(resolution_m),
      config_(base::checked(config)),
      T_S_G_(T_S_G),
      T_G_S_(T_S_G.inverse(Eigen::Isometry)),
      surface_(std::make_unique<Surface>()) {
  check_frame(resolution_m, T_S_G);
  take_field(CompressedField(blocks, config.band_voxels));
  surface_->points = sample_surface(blocks, resolution_m, T_S_G, config.max_surface_points);
  update_bounds(surface_.get());
}

void Submap::take_field(CompressedField field) {
  geometry::Aabb known_G;
  const double side_m = geometry::kBlockSide * resolution_m_;
  for (std::size_t i = 0; i < field.num_blocks(); ++i) {
    const Index3& b = field.block_index(i);
    known_G.extend(Vec3(b.x, b.y, b.z) * side_m);
    known_G.extend(Vec3(b.x + 1, b.y + 1, b.z + 1) * side_m);
  }
  known_bounds_ = known_G.transformed(T_S_G_);
  cache_ = std::make_unique<DistanceCache>(field.num_blocks());
  field_ = std::make_shared<const CompressedField>(std::move(field));
}

void Submap::update_bounds(Surface* surface) {
  for (const geometry::SurfacePoint& point : surface->points) surface->bounds.extend(point.position.cast<double>());
}

const Submap::Surface& Submap::surface() const {
  const auto content = field();
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!surface_) {
    auto made = std::make_unique<Surface>();
    made->points = sample_surface(*content, resolution_m_, T_S_G_, config_.max_surface_points);
    update_bounds(made.get());
    surface_ = std::move(made);
  }
  return *surface_;
}

const std::vector<bool>& Submap::thin_leaves() const {
  const auto content = field();
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!thin_) thin_ = std::make_unique<std::vector<bool>>(find_thin(*content));
  return *thin_;
}

bool Submap::sample_in(const CompressedField& content, const Vec3& p_S, double* distance_m, Vec3* gradient) const {
  const Vec3 p = (T_G_S_ * p_S) / resolution_m_;
  if (!(p.array().abs() < kMaxIndex).all()) return false;
  const Index3 voxel = floor_index(p);
  const int position = content.position_of(geometry::block_of(voxel));
  if (position < 0) return false;
  const State state = content.state(position, geometry::offset_in_block(voxel));
  if (state == State::kUnknown) return false;
  double distance = 0.0;
  Vec3 slope = Vec3::Zero();
  if (config_.certified) {
    sample_certified(content, position, p, &distance, &slope);
  } else if (!sample_near(content, position, p, &distance, &slope)) {
    sample_far(content, p, CompressedField::Target::kSurfacePoint, &distance, &slope);
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

bool Submap::sample_near(const CompressedField& content, int position, const Vec3& p, double* distance,
                         Vec3* gradient) const {
  const Vec3 from_centers = p - Vec3::Constant(0.5);
  const Index3 lower = floor_index(from_centers);
  const Index3 local = lower - geometry::voxel_at(content.block_index(static_cast<std::size_t>(position)), 0);
  std::array<float, 8> corners;
  if (!cache_->get(content, position)->corners(local.x, local.y, local.z, &corners)) return false;
  const Trilinear mixed = interpolate(corners, from_centers - Vec3(lower.x, lower.y, lower.z));
  *distance = mixed.value;
  *gradient = mixed.gradient;
  return true;
}

void Submap::sample_far(const CompressedField& content, const Vec3& p, CompressedField::Target target, double* distance,
                        Vec3* gradient) const {
  const double limit = config_.max_distance_m / resolution_m_;
  const auto nearest = content.nearest(p, limit, target);
  *distance = nearest ? std::sqrt(nearest->squared) : limit;
  *gradient = nearest && *distance > 0.0 ? Vec3((p - nearest->point) / *distance) : Vec3::Zero();
}

void Submap::sample_certified(const CompressedField& content, int position, const Vec3& p, double* distance,
                              Vec3* gradient) const {
  sample_far(content, p, CompressedField::Target::kVoxelCube, distance, gradient);
  if (*distance > 0.0) return;
  double inside = 0.0;
  if (sample_near(content, position, p, &inside, gradient)) *distance = std::min(inside, 0.0);
}

State Submap::state(const Vec3& p_S) const {
  const Vec3 p = (T_G_S_ * p_S) / resolution_m_;
  if (!(p.array().abs() < kMaxIndex).all()) return State::kUnknown;
  return field()->state(floor_index(p));
}

std::vector<geometry::Vec3f> Submap::occupied_points() const {
  const auto content = field();
  std::vector<geometry::Vec3f> out;
  out.reserve(content->num_leaves());
  content->for_each_leaf([&](const Index3& voxel, const CompressedField::Leaf& leaf) {
    out.push_back((T_S_G_ * (surface_point(voxel, leaf) * resolution_m_)).cast<float>());
  });
  return out;
}

std::size_t Submap::memory_bytes() const {
  const auto content = std::atomic_load(&field_);
  const std::lock_guard<std::mutex> lock(mutex_);
  const std::size_t surface = surface_ ? surface_->points.capacity() * sizeof(geometry::SurfacePoint) : 0;
  const std::size_t thin = thin_ ? thin_->capacity() / 8 : 0;
  return sizeof(*this) + (content ? content->memory_bytes() : 0) + surface + thin;
}

}  // namespace voxnav::submap
