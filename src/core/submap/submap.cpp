// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/submap/submap.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "submap/content/make_content.hpp"
#include "submap/content/thin_voxels.hpp"
#include "submap/distance/distance_cache.hpp"
#include "submap/registration/surface_sampling.hpp"
#include "submap/voxel_walk.hpp"

namespace voxnav::submap {
namespace {

using containers::VoxelState;
using geometry::Index3;
using geometry::Vec3;

constexpr double kMaxIndex = 1073741824.0;  // 2^30: beyond it voxel indices would overflow

constexpr double kFinest_m = 1e-3;  // limit of the file format; below it distances in voxels may overflow
constexpr double kCoarsest_m = 1e3;

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
  return from_packed(make_content(content, config.band_voxels), content.resolution_m, T_S_G, config);
}

std::shared_ptr<Submap> Submap::from_packed(SubmapContent content, double resolution_m, const geometry::Pose& T_S_G,
                                            const SubmapConfig& config) {
  check_frame(resolution_m, T_S_G);
  std::shared_ptr<Submap> out(new Submap());
  out->resolution_m_ = resolution_m;
  out->config_ = config;
  out->T_S_G_ = T_S_G;
  out->T_G_S_ = T_S_G.inverse(Eigen::Isometry);
  out->take_content(std::move(content));
  return out;
}

Submap::Submap() = default;

Submap::~Submap() {
  if (!page_path_.empty()) std::remove(page_path_.c_str());
}

void Submap::take_content(SubmapContent content) {
  geometry::Aabb known_G;
  const double side_m = geometry::kBlockSide * resolution_m_;
  for (std::size_t i = 0; i < content.states().size(); ++i) {
    const Index3& b = content.states().index(i);
    known_G.extend(Vec3(b.x, b.y, b.z) * side_m);
    known_G.extend(Vec3(b.x + 1, b.y + 1, b.z + 1) * side_m);
  }
  known_bounds_ = known_G.transformed(T_S_G_);
  cache_ = std::make_unique<DistanceCache>(content.states().size());
  content_ = std::make_shared<const SubmapContent>(std::move(content));
}

void Submap::set_surface_points(std::vector<geometry::SurfacePoint> points) {
  auto surface = std::make_unique<Surface>();
  surface->points = std::move(points);
  for (const geometry::SurfacePoint& point : surface->points) surface->bounds.extend(point.position.cast<double>());
  const std::lock_guard<std::mutex> lock(mutex_);
  surface_ = std::move(surface);
}

const Submap::Surface& Submap::surface() const {
  const auto held = content();
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!surface_) {
    auto made = std::make_unique<Surface>();
    made->points = sample_surface(*held, resolution_m_, T_S_G_, config_.max_surface_points);
    for (const geometry::SurfacePoint& point : made->points) made->bounds.extend(point.position.cast<double>());
    surface_ = std::move(made);
  }
  return *surface_;
}

const std::vector<geometry::SurfacePoint>& Submap::surface_points() const { return surface().points; }

geometry::Aabb Submap::surface_bounds() const { return surface().bounds; }

const std::vector<bool>& Submap::thin_voxels() const {
  const auto held = content();
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!thin_) thin_ = std::make_unique<std::vector<bool>>(find_thin(held->states()));
  return *thin_;
}

std::shared_ptr<const DistanceBlock> Submap::distances(const SubmapContent& content, std::size_t position) const {
  return cache_->get(content, position);
}

void Submap::set_distance_cache_bytes(std::size_t bytes) { DistanceCache::set_limit_bytes(bytes); }

VoxelState Submap::state(const Vec3& p_S) const {
  const Vec3 p = (T_G_S_ * p_S) / resolution_m_;
  if (!(p.array().abs() < kMaxIndex).all()) return VoxelState::kUnknown;
  return content()->states().state(floor_index(p));
}

std::vector<geometry::Vec3f> Submap::occupied_points() const {
  const auto held = content();
  std::vector<geometry::Vec3f> out;
  out.reserve(held->points().size());
  held->for_each_voxel([&](const Index3& index, const occupancy::OccupiedVoxel& voxel) {
    out.emplace_back((T_S_G_ * (surface_point(index, voxel.believed) * resolution_m_)).cast<float>());
  });
  return out;
}

std::size_t Submap::memory_bytes() const {
  const auto held = std::atomic_load(&content_);
  const std::lock_guard<std::mutex> lock(mutex_);
  const std::size_t surface = surface_ ? surface_->points.capacity() * sizeof(geometry::SurfacePoint) : 0;
  const std::size_t thin = thin_ ? thin_->capacity() / 8 : 0;
  return sizeof(*this) + (held ? held->memory_bytes() : 0) + surface + thin;
}

}  // namespace voxnav::submap
