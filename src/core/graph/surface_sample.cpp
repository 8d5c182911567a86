// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/graph/surface_sample.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "voxnav/geometry/voxel.hpp"
#include "voxnav/graph/coarse_field.hpp"

namespace voxnav::graph {
namespace {

using geometry::SurfacePoint;

constexpr double kPhaseCell_m = 1.6;
constexpr float kUprightNormalZ = 0.7f;  // 45 degrees
constexpr float kPlanarWeight = 0.5f;    // only points in planes weigh more

bool is_usable(const SurfacePoint& point) {
  return point.position.allFinite() && point.normal.allFinite() && std::isfinite(point.weight) && point.weight > 0;
}

std::uint32_t scatter(std::uint32_t i) {
  i = (i ^ (i >> 16)) * 0x45d9f3bu;
  i = (i ^ (i >> 16)) * 0x45d9f3bu;
  return i ^ (i >> 16);
}

/// Order in which the points of one class are taken: one from every cell, then a second from every cell, ...
std::vector<std::uint32_t> round_robin(std::map<geometry::Index3, std::vector<std::uint32_t>>* cells,
                                       std::size_t limit) {
  for (auto& [index, members] : *cells) {
    std::sort(members.begin(), members.end(), [](std::uint32_t a, std::uint32_t b) { return scatter(a) < scatter(b); });
  }
  std::vector<std::uint32_t> out;
  for (std::size_t round = 0; out.size() < limit; ++round) {
    const std::size_t before = out.size();
    for (const auto& [index, members] : *cells) {
      if (round < members.size()) out.push_back(members[round]);
    }
    if (out.size() == before) break;
  }
  return out;
}

}  // namespace

SurfaceSample draw_sample(std::shared_ptr<const geometry::DistanceField> field, int max_points, double cell_m) {
  const std::vector<SurfacePoint>& all = field->surface_points();
  std::map<geometry::Index3, std::vector<std::uint32_t>> cells[2];
  for (std::uint32_t i = 0; i < all.size(); ++i) {
    if (!is_usable(all[i])) continue;
    const bool is_upright = std::abs(all[i].normal.z()) < kUprightNormalZ;
    cells[is_upright][geometry::index_of(all[i].position.cast<double>(), cell_m)].push_back(i);
  }
  const auto limit = static_cast<std::size_t>(max_points);
  const std::vector<std::uint32_t> order[2] = {round_robin(&cells[0], limit), round_robin(&cells[1], limit)};
  SurfaceSample out;
  for (std::size_t k = 0; k < limit; ++k) {
    for (const int is_upright : {1, 0}) {
      if (k >= order[is_upright].size() || out.points.size() >= limit) continue;
      const SurfacePoint& point = all[order[is_upright][k]];
      const geometry::Vec3 position = point.position.cast<double>();
      double own = 0.0;
      // A surface point lies within a voxel of its surface; a larger own distance is a fault of the field.
      if (!field->sample(position, &own, nullptr) || std::abs(own) > field->resolution_m()) own = 0.0;
      out.points.push_back({position, static_cast<double>(point.weight), own, is_upright == 1,
                            point.normal.cast<double>(), point.weight > kPlanarWeight, point.phase});
    }
  }
  out.phases = PhaseGrid(all);
  out.field = std::move(field);
  return out;
}

PhaseGrid::PhaseGrid(const std::vector<SurfacePoint>& points) {
  for (const SurfacePoint& point : points) {
    if (!point.position.allFinite()) continue;
    Mean& mean = cells_[geometry::index_of(point.position.cast<double>(), kPhaseCell_m)];
    mean.sum += static_cast<double>(point.phase);
    mean.count += 1.0;
  }
}

double PhaseGrid::at(const geometry::Vec3& p_S) const {
  const auto found = cells_.find(geometry::index_of(p_S, kPhaseCell_m));
  return found == cells_.end() ? 0.5 : found->second.sum / found->second.count;
}

SurfaceSample coarsen(const SurfaceSample& sample, int max_points, double cell_m, double reach_m) {
  SurfaceSample out;
  out.field = std::make_shared<CoarseField>(sample.field->surface_points(), cell_m, reach_m);
  for (const SamplePoint& point : sample.points) {
    if (out.points.size() >= static_cast<std::size_t>(max_points)) break;
    out.points.push_back(point);
    double& own_m = out.points.back().own_distance_m;
    if (!out.field->sample(point.position_S, &own_m, nullptr)) out.points.pop_back();
  }
  return out;
}

}  // namespace voxnav::graph
