// SPDX-License-Identifier: BSD-3-Clause
#include "submap/registration/move_to_middles.hpp"

#include <algorithm>
#include <cmath>
#include <memory>

#include "submap/content/content_window.hpp"
#include "submap/distance/surface_normals.hpp"

namespace voxnav::submap {
namespace {

using geometry::Index3;
using geometry::Vec3;

/// The hits on a rod lie on average 2 / pi of its radius before its axis: 0.1 m for a trunk with a radius of 0.15 m.
constexpr double kDepth_m = 0.1;

/// Returns the position of the sensor at each of the 256 times that surface points can have, in voxel edges.
std::vector<Vec3> places_over_time(const std::vector<geometry::StampedPose>& T_G_B, double resolution_m) {
  constexpr std::size_t kTimes = 256;
  const base::StampNs start_ns = T_G_B.front().stamp_ns;
  const auto span_ns = static_cast<double>(T_G_B.back().stamp_ns - start_ns);
  std::vector<Vec3> out;
  std::size_t next = 0;
  for (std::size_t time = 0; time < kTimes; ++time) {
    const auto stamp_ns = start_ns + static_cast<base::StampNs>(span_ns * static_cast<double>(time) / (kTimes - 1));
    while (next + 1 < T_G_B.size() && T_G_B[next].stamp_ns < stamp_ns) ++next;
    out.emplace_back(T_G_B[next].pose.translation() / resolution_m);
  }
  return out;
}

/// Returns for each surface point, by its number, whether it lies in a plane.
std::vector<bool> find_planar(const SubmapContent& content) {
  std::vector<bool> out(content.points().size());
  const auto window = std::make_unique<ContentWindow>();
  std::vector<std::uint16_t> inside;
  std::vector<SurfaceNormal> normals;
  for (std::size_t i = 0; i < content.states().size(); ++i) {
    if (!content.states().has_occupied(i)) continue;
    window->load(content, content.states().index(i), 1);
    inside = voxels_of_block(*window);
    estimate_normals(*window, inside, &normals);
    for (std::size_t k = 0; k < inside.size(); ++k) {
      out[window->numbers()[inside[k]]] = normals[k].quality >= kPlanarQuality;
    }
  }
  return out;
}

std::int8_t quantised(double mean) {
  return static_cast<std::int8_t>(std::lround(std::min(127.0, std::max(-127.0, mean * 254.0))));
}

}  // namespace

void move_to_middles(double resolution_m, const std::vector<geometry::StampedPose>& T_G_B, SubmapContent* content) {
  const std::vector<Vec3> places = places_over_time(T_G_B, resolution_m);
  const std::vector<bool> is_planar = find_planar(*content);
  std::vector<occupancy::VoxelPoint> moved = content->points().all_believed();
  std::size_t i = 0;
  content->for_each_voxel([&](const Index3& index, const occupancy::OccupiedVoxel& voxel) {
    const Vec3 point = surface_point(index, voxel.believed);
    Vec3 mean = point - geometry::center_of(index, 1.0);
    const Vec3 away = point - places[voxel.observed_time];
    if (!is_planar[i] && away.norm() > 1e-3) mean += away.normalized() * (kDepth_m / resolution_m);
    for (int k = 0; k < 3; ++k) moved[i].mean[static_cast<std::size_t>(k)] = quantised(mean[k]);
    ++i;
  });
  content->move_points(std::move(moved));
}

}  // namespace voxnav::submap
