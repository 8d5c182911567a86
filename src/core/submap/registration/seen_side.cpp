// SPDX-License-Identifier: BSD-3-Clause
#include "submap/registration/seen_side.hpp"

#include <memory>

#include "submap/content/field_window.hpp"

namespace voxnav::submap {
namespace {

using geometry::Index3;
using geometry::Vec3;

/// The hits on a rod lie 2 / pi of its radius before its axis, on average: 0.1 m where it is a trunk of 0.15 m.
constexpr double kDepth_m = 0.1;

/// Where the sensor was at each of the times that leaves have, in voxel edges.
std::vector<Vec3> places_over_time(const std::vector<geometry::StampedPose>& T_G_B, double resolution_m) {
  constexpr std::size_t kTimes = 256;
  const base::StampNs start_ns = T_G_B.front().stamp_ns;
  const auto span_ns = static_cast<double>(T_G_B.back().stamp_ns - start_ns);
  std::vector<Vec3> out;
  std::size_t next = 0;
  for (std::size_t time = 0; time < kTimes; ++time) {
    const auto stamp_ns = start_ns + static_cast<base::StampNs>(span_ns * static_cast<double>(time) / (kTimes - 1));
    while (next + 1 < T_G_B.size() && T_G_B[next].stamp_ns < stamp_ns) ++next;
    out.push_back(T_G_B[next].pose.translation() / resolution_m);
  }
  return out;
}

/// For each leaf whether it lies in a plane; in the order of for_each_leaf().
std::vector<bool> find_planar(const CompressedField& field) {
  std::vector<bool> out;
  const auto window = std::make_unique<FieldWindow>();
  std::vector<std::uint16_t> inside;
  std::vector<LeafNormal> normals;
  for (std::size_t i = 0; i < field.num_blocks(); ++i) {
    if (!field.has_surface(static_cast<int>(i))) continue;
    window->load(field, field.block_index(i), 1);
    inside = leaves_of_block(*window);
    estimate_normals(*window, inside, &normals);
    std::vector<bool> is_planar(geometry::kBlockVolume);
    for (std::size_t k = 0; k < inside.size(); ++k) {
      const WindowLeaf& leaf = window->leaves()[inside[k]];
      is_planar[static_cast<std::size_t>(leaf.x | (leaf.y << 4) | (leaf.z << 8))] =
          normals[k].quality >= kPlanarQuality;
    }
    field.for_each_leaf_in(field.block_index(i), [&](const Index3& voxel, const CompressedField::Leaf&) {
      out.push_back(is_planar[static_cast<std::size_t>(geometry::offset_in_block(voxel))]);
    });
  }
  return out;
}

}  // namespace

void move_to_middles(double resolution_m, const std::vector<geometry::StampedPose>& T_G_B, CompressedField* field) {
  const std::vector<Vec3> places = places_over_time(T_G_B, resolution_m);
  const std::vector<bool> is_planar = find_planar(*field);
  std::size_t i = 0;
  field->move_points([&](const Index3& voxel, const CompressedField::Leaf& leaf, std::uint8_t time) {
    Vec3 mean = surface_point(voxel, leaf) - geometry::center_of(voxel, 1.0);
    const Vec3 away = surface_point(voxel, leaf) - places[time];
    if (!is_planar[i++] && away.norm() > 1e-3) mean += away.normalized() * (kDepth_m / resolution_m);
    return mean;
  });
}

}  // namespace voxnav::submap
