// SPDX-License-Identifier: BSD-3-Clause
#include "submap/projective/projective_volume.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "submap/voxel_walk.hpp"

namespace voxnav::submap {
namespace {

using geometry::Index3;
using geometry::Vec3;

/// A ray of the fast rule stops after this many voxels in a row that other rays of the scan have seen.
constexpr int kMaxSeenInARow = 2;

}  // namespace

ProjectiveIntegrator::Counts ProjectiveIntegrator::Volume::integrate(const std::vector<geometry::Vec3f>& points_L,
                                                                     const geometry::Pose& T_S_L) {
  if (!geometry::is_valid(T_S_L)) throw std::invalid_argument("T_S_L must be a finite rigid transform");
  if (T_S_L.translation().cwiseAbs().maxCoeff() > 1e6) throw std::invalid_argument("T_S_L is farther than 1000 km");
  Counts counts;
  counts.points = points_L.size();
  scan_ = scan_ % 0x3FFFFFFFu + 1;
  std::vector<Ray> rays = rays_of(points_L, T_S_L, &counts);
  if (config_.use_anti_grazing) mark_ends(rays);
  if (config_.rule == RayRule::kMerged) merge(&rays);
  if (config_.rule == RayRule::kFast) thin(&rays);
  for (const Ray& ray : rays) cast(T_S_L.translation(), ray, &counts);
  counts.rays = rays.size();
  return counts;
}

std::vector<ProjectiveIntegrator::Volume::Ray> ProjectiveIntegrator::Volume::rays_of(
    const std::vector<geometry::Vec3f>& points_L, const geometry::Pose& T_S_L, Counts* counts) const {
  std::vector<Ray> out;
  out.reserve(points_L.size());
  for (const geometry::Vec3f& point : points_L) {
    const double range = point.cast<double>().norm();
    if (!std::isfinite(range) || range < std::max(config_.min_range_m, 1e-6)) {
      ++counts->dropped;
      continue;
    }
    const float weight =
        config_.weighting == RangeWeighting::kConstant ? 1.f : static_cast<float>(1.0 / (range * range));
    const bool is_clearing = range > config_.max_range_m;
    const double length = std::min(range, config_.max_range_m + config_.truncation_m);
    out.push_back({T_S_L * Vec3(point.cast<double>() * (length / range)), weight, is_clearing});
  }
  return out;
}

/// Returns the group of rays that end in a cell; a new group gets the next number.
std::uint32_t ProjectiveIntegrator::Volume::group_of(const Index3& cell) {
  const auto next = static_cast<std::uint32_t>(group_cells_.size());
  const auto cell_of_group = [this](std::uint32_t group) { return group_cells_[group]; };
  const std::uint32_t group = groups_.insert(cell, next, cell_of_group);
  if (group == next) group_cells_.push_back(cell);
  return group;
}

/// Merges rays to one for each end voxel, with the weighted mean point and the summed weight. Of clearing rays the
/// first one stands for all.
void ProjectiveIntegrator::Volume::merge(std::vector<Ray>* rays) {
  std::vector<Ray> out;  // in order of first points, so that the result is deterministic
  group_cells_.clear();
  for (const bool is_clearing : {false, true}) {
    groups_.reset(rays->size());
    for (const Ray& ray : *rays) {
      if (ray.is_clearing != is_clearing) continue;
      const auto next = static_cast<std::uint32_t>(out.size());
      const std::uint32_t group = group_of(floor_index(ray.end / config_.resolution_m));
      if (group == next) {
        out.push_back(ray);
      } else if (!is_clearing) {
        Ray& mean = out[group];
        const double ratio = ray.weight / (mean.weight + ray.weight);
        mean.end += ratio * (ray.end - mean.end);
        mean.weight += ray.weight;
      }
    }
  }
  rays->swap(out);
}

/// Keeps the first ray of each cell of half a voxel.
void ProjectiveIntegrator::Volume::thin(std::vector<Ray>* rays) {
  groups_.reset(rays->size());
  group_cells_.clear();
  std::vector<Ray> out;
  for (const Ray& ray : *rays) {
    const auto next = static_cast<std::uint32_t>(out.size());
    if (group_of(floor_index(ray.end / (0.5 * config_.resolution_m))) == next) out.push_back(ray);
  }
  rays->swap(out);
}

void ProjectiveIntegrator::Volume::mark_ends(const std::vector<Ray>& rays) {
  for (const Ray& ray : rays) {
    if (ray.is_clearing) continue;
    const Index3 voxel = floor_index(ray.end / config_.resolution_m);
    Block* block = open(geometry::block_of(voxel));
    if (block) (*block)[static_cast<std::size_t>(geometry::offset_in_block(voxel))].mark = (scan_ << 2) | kEnd;
  }
}

void ProjectiveIntegrator::Volume::cast(const Vec3& origin, const Ray& ray, Counts* counts) {
  const double v = config_.resolution_m;
  const double tau = config_.truncation_m;
  const double range = (ray.end - origin).norm();
  if (!(range > 1e-6) || (ray.is_clearing && !config_.use_carving)) return;
  const Vec3 direction = (ray.end - origin) / range;
  const double from = config_.use_carving ? 0.0 : std::max(0.0, range - tau);
  const double to = ray.is_clearing ? config_.max_range_m - tau : range + tau;
  if (to <= from) return;
  const Index3 end_voxel = floor_index(ray.end / v);
  const bool is_fast = config_.rule == RayRule::kFast;
  // Rays are walked from the end to the sensor, so that the fast rule can stop in space that the scan has cleared.
  VoxelWalk walk((origin + to * direction) / v, (origin + from * direction) / v);
  double distance = range - (geometry::center_of(walk.index(), v) - origin).dot(direction);
  Index3 at{1 << 30, 0, 0};
  Block* block = nullptr;
  int seen_in_a_row = 0;
  for (int axis = 0; axis >= 0;) {
    if (geometry::block_of(walk.index()) != at) {
      at = geometry::block_of(walk.index());
      block = open(at);
    }
    Visit visit = Visit::kRefused;
    if (block) {
      Voxel& voxel = (*block)[static_cast<std::size_t>(geometry::offset_in_block(walk.index()))];
      visit = update(distance, ray.weight, walk.index() == end_voxel, &voxel);
    }
    counts->refused += visit == Visit::kRefused;
    counts->voxels += visit == Visit::kNew || visit == Visit::kSeen;
    if (visit != Visit::kLeftAlone) seen_in_a_row = visit == Visit::kSeen ? seen_in_a_row + 1 : 0;
    if (is_fast && distance > tau && seen_in_a_row > kMaxSeenInARow) return;
    axis = walk.advance();
    if (axis >= 0) distance -= walk.step(axis) * direction[axis] * v;
  }
}

ProjectiveIntegrator::Volume::Visit ProjectiveIntegrator::Volume::update(double distance, float weight, bool is_own_end,
                                                                         Voxel* voxel) const {
  const double v = config_.resolution_m;
  const double tau = config_.truncation_m;
  const std::uint32_t done = voxel->mark >> 2 == scan_ ? voxel->mark & 3u : 0u;
  if (config_.use_anti_grazing && (done & kEnd) && !is_own_end) return Visit::kLeftAlone;
  if (config_.use_drop_off && distance < -v) weight *= static_cast<float>(std::max(0.0, (tau + distance) / (tau - v)));
  if (weight < 1e-6f) return Visit::kLeftAlone;
  voxel->mark = (scan_ << 2) | done | kSeen;
  fuse(static_cast<float>(std::min(tau, std::max(-tau, distance))), weight, voxel);
  return done & kSeen ? Visit::kSeen : Visit::kNew;
}

void ProjectiveIntegrator::Volume::fuse(float distance, float weight, Voxel* voxel) const {
  const float sum = voxel->weight + weight;
  // Most voxels are far in front of all surfaces and stay at the truncation distance.
  if (distance != voxel->distance || voxel->weight == 0.f)
    voxel->distance = (voxel->weight * voxel->distance + weight * distance) / sum;
  voxel->weight = std::min(sum, static_cast<float>(config_.max_weight));
}

ProjectiveIntegrator::Volume::Block* ProjectiveIntegrator::Volume::open(const Index3& index) {
  const auto it = blocks_.find(index);
  if (it != blocks_.end()) return it->second.get();
  if (blocks_.size() >= static_cast<std::size_t>(config_.max_blocks)) return nullptr;
  return blocks_.emplace(index, std::make_unique<Block>()).first->second.get();
}

bool ProjectiveIntegrator::Volume::voxel(const Index3& index, float* distance_m, float* weight) const {
  const auto it = blocks_.find(geometry::block_of(index));
  if (it == blocks_.end()) return false;
  const Voxel& found = (*it->second)[static_cast<std::size_t>(geometry::offset_in_block(index))];
  if (!(found.weight > 0.f)) return false;
  *distance_m = found.distance;
  *weight = found.weight;
  return true;
}

}  // namespace voxnav::submap
