// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/submap/projective_integrator.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "voxnav/submap/voxel_walk.hpp"

namespace voxnav::submap {
namespace {

using geometry::Index3;
using geometry::Vec3;

/// A ray of the fast rule stops after this many voxels in a row that other rays of the scan have seen.
constexpr int kMaxSeenInARow = 2;

}  // namespace

std::vector<std::string> ProjectiveConfig::problems() const {
  std::vector<std::string> out;
  if (truncation_m < 2.0 * resolution_m) out.push_back("truncation_m must be at least two voxels");
  if (min_range_m >= max_range_m) out.push_back("min_range_m must be below max_range_m");
  if (max_range_m / resolution_m > 20000.0) out.push_back("max_range_m is more than 20000 voxels");
  return out;
}

ProjectiveIntegrator::ProjectiveIntegrator(const ProjectiveConfig& config) : config_(base::checked(config)) {}

ProjectiveIntegrator::Counts ProjectiveIntegrator::integrate(const std::vector<geometry::Vec3f>& points_L,
                                                             const geometry::Pose& T_S_L) {
  if (!geometry::is_valid(T_S_L)) throw std::invalid_argument("T_S_L must be a finite rigid transform");
  if (T_S_L.translation().cwiseAbs().maxCoeff() > 1e6) throw std::invalid_argument("T_S_L is farther than 1000 km");
  Counts counts;
  counts.points = points_L.size();
  ++scan_;
  std::vector<Ray> rays = rays_of(points_L, T_S_L, &counts);
  ends_.clear();
  if (config_.use_anti_grazing) {
    for (const Ray& ray : rays) {
      if (!ray.is_clearing) ends_.insert(geometry::index_of(ray.end, config_.resolution_m));
    }
  }
  if (config_.rule == "merged") rays = merged(rays);
  if (config_.rule == "fast") rays = thinned(rays);
  for (const Ray& ray : rays) cast(T_S_L.translation(), ray, &counts);
  counts.rays = rays.size();
  return counts;
}

std::vector<ProjectiveIntegrator::Ray> ProjectiveIntegrator::rays_of(const std::vector<geometry::Vec3f>& points_L,
                                                                     const geometry::Pose& T_S_L,
                                                                     Counts* counts) const {
  std::vector<Ray> out;
  out.reserve(points_L.size());
  for (const geometry::Vec3f& point : points_L) {
    const double range = point.cast<double>().norm();
    if (!std::isfinite(range) || range < std::max(config_.min_range_m, 1e-6)) {
      ++counts->dropped;
      continue;
    }
    const float weight = config_.weighting == "constant" ? 1.f : static_cast<float>(1.0 / (range * range));
    const bool is_clearing = range > config_.max_range_m;
    const double length = std::min(range, config_.max_range_m + config_.truncation_m);
    out.push_back({T_S_L * Vec3(point.cast<double>() * (length / range)), weight, is_clearing});
  }
  return out;
}

/// One ray per end voxel: weighted mean point and summed weight; of clearing rays the first one stands for all.
std::vector<ProjectiveIntegrator::Ray> ProjectiveIntegrator::merged(const std::vector<Ray>& rays) const {
  std::unordered_map<Index3, std::size_t, geometry::Index3Hash> groups[2];
  std::vector<Ray> out;  // in order of first points, so that the result is deterministic
  for (const Ray& ray : rays) {
    auto& group = groups[ray.is_clearing ? 1 : 0];
    const auto found = group.try_emplace(geometry::index_of(ray.end, config_.resolution_m), out.size());
    if (found.second) {
      out.push_back(ray);
    } else if (!ray.is_clearing) {
      Ray& mean = out[found.first->second];
      const double ratio = ray.weight / (mean.weight + ray.weight);
      mean.end += ratio * (ray.end - mean.end);
      mean.weight += ray.weight;
    }
  }
  return out;
}

/// The first ray of each cell of half a voxel.
std::vector<ProjectiveIntegrator::Ray> ProjectiveIntegrator::thinned(const std::vector<Ray>& rays) const {
  VoxelSet taken;
  std::vector<Ray> out;
  for (const Ray& ray : rays) {
    if (taken.insert(geometry::index_of(ray.end, 0.5 * config_.resolution_m)).second) out.push_back(ray);
  }
  return out;
}

void ProjectiveIntegrator::cast(const Vec3& origin, const Ray& ray, Counts* counts) {
  const double v = config_.resolution_m;
  const double range = (ray.end - origin).norm();
  if (!(range > 1e-6)) return;
  const Vec3 direction = (ray.end - origin) / range;
  const double tau = config_.truncation_m;
  const double from = config_.use_carving ? 0.0 : std::max(0.0, range - tau);
  const double to = ray.is_clearing ? config_.max_range_m - tau : range + tau;
  if (ray.is_clearing && !config_.use_carving) return;
  if (to <= from) return;
  const Index3 end_voxel = geometry::index_of(ray.end, v);
  const bool is_fast = config_.rule == "fast";
  int seen_in_a_row = 0;
  // From the end to the sensor, so that the fast rule may stop early in what is already known to be free.
  walk_voxels((origin + to * direction) / v, (origin + from * direction) / v, [&](const Index3& voxel) {
    if (config_.use_anti_grazing && voxel != end_voxel && ends_.count(voxel)) return true;
    const double distance = range - (geometry::center_of(voxel, v) - origin).dot(direction);
    float weight = ray.weight;
    if (config_.use_drop_off && distance < -v)
      weight *= static_cast<float>(std::max(0.0, (tau + distance) / (tau - v)));
    if (weight < 1e-6f) return true;
    const bool is_seen = update(voxel, std::min(tau, std::max(-tau, distance)), weight, counts);
    seen_in_a_row = is_seen ? seen_in_a_row + 1 : 0;
    return !(is_fast && distance > tau && seen_in_a_row > kMaxSeenInARow);
  });
}

/// @return whether this scan has been in the voxel before
bool ProjectiveIntegrator::update(const Index3& index, double distance, float weight, Counts* counts) {
  Block* block = open(geometry::block_of(index));
  if (!block) {
    ++counts->refused;
    return false;
  }
  const auto i = static_cast<std::size_t>(geometry::offset_in_block(index));
  const bool is_seen = block->seen[i] == scan_;
  block->seen[i] = scan_;
  const float sum = block->weight[i] + weight;
  block->distance[i] = (block->weight[i] * block->distance[i] + weight * static_cast<float>(distance)) / sum;
  block->weight[i] = std::min(sum, static_cast<float>(config_.max_weight));
  ++counts->voxels;
  return is_seen;
}

ProjectiveIntegrator::Block* ProjectiveIntegrator::open(const Index3& index) {
  const auto it = blocks_.find(index);
  if (it != blocks_.end()) return it->second.get();
  if (blocks_.size() >= static_cast<std::size_t>(config_.max_blocks)) return nullptr;
  return blocks_.emplace(index, std::make_unique<Block>()).first->second.get();
}

bool ProjectiveIntegrator::voxel(const Index3& index, float* distance_m, float* weight) const {
  const auto it = blocks_.find(geometry::block_of(index));
  if (it == blocks_.end()) return false;
  const auto i = static_cast<std::size_t>(geometry::offset_in_block(index));
  if (!(it->second->weight[i] > 0.f)) return false;
  *distance_m = it->second->distance[i];
  *weight = it->second->weight[i];
  return true;
}

}  // namespace voxnav::submap
