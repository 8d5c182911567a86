// SPDX-License-Identifier: BSD-3-Clause
#include "graph/surface_sample.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "graph/coarse_field.hpp"
#include "voxnav/geometry/voxel.hpp"

namespace voxnav::graph {
namespace {

using geometry::SurfacePoint;

constexpr double kPhaseCell_m = 1.6;
constexpr double kMostPhaseCells = 1e5;
constexpr float kUprightNormalZ = 0.7f;  // 45 degrees
constexpr float kPlanarWeight = 0.5f;    // only points in planes have a larger weight

bool is_usable(const SurfacePoint& point) {
  return point.position.allFinite() && point.normal.allFinite() && std::isfinite(point.weight) && point.weight > 0;
}

std::uint32_t scatter(std::uint32_t i) {
  i = (i ^ (i >> 16)) * 0x45d9f3bu;
  i = (i ^ (i >> 16)) * 0x45d9f3bu;
  return i ^ (i >> 16);
}

/// Orders the points of one class: one point of every cell, then a second one of every cell, and so on.
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
      // A surface point lies within a voxel of its surface; a larger distance in its own field is an error of the
      // field.
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
  geometry::Aabb box;
  for (const SurfacePoint& point : points) {
    if (point.position.allFinite()) box.extend(point.position.cast<double>());
  }
  if (box.empty()) return;
  origin_ = box.min;
  const geometry::Vec3 span = box.max - box.min;
  cell_m_ = std::max({kPhaseCell_m, span.maxCoeff() / kMostPhaseCells, std::cbrt(span.prod() / kMostPhaseCells)});
  // The grid is shifted so that level ground, at the lowest height, does not lie on the border of two cells.
  origin_ -= geometry::Vec3::Constant(0.5 * cell_m_);
  size_ = (span / cell_m_).array().cast<int>() + 2;
  phases_.assign(static_cast<std::size_t>(size_.prod()), 0.0f);
  std::vector<float> counts(phases_.size(), 0.0f);
  for (const SurfacePoint& point : points) {
    if (!point.position.allFinite()) continue;
    const std::size_t cell = *cell_of(point.position.cast<double>());
    phases_[cell] += point.phase;
    counts[cell] += 1.0f;
  }
  for (std::size_t i = 0; i < phases_.size(); ++i) phases_[i] = counts[i] > 0.0f ? phases_[i] / counts[i] : 0.5f;
}

std::optional<std::size_t> PhaseGrid::cell_of(const geometry::Vec3& p_S) const {
  const Eigen::Array3d at = (p_S - origin_).array() / cell_m_;
  if (!((at >= 0.0) && (at < size_.cast<double>())).all()) return std::nullopt;
  const Eigen::Array3i i = at.cast<int>();
  return static_cast<std::size_t>(i.x() + size_.x() * (i.y() + size_.y() * i.z()));
}

double PhaseGrid::at(const geometry::Vec3& p_S) const {
  const std::optional<std::size_t> cell = cell_of(p_S);
  return cell ? static_cast<double>(phases_[*cell]) : 0.5;
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
