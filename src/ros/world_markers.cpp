// SPDX-License-Identifier: BSD-3-Clause
#include "world_markers.hpp"

#include <algorithm>

#include "voxnav_ros/conversions.hpp"

namespace voxnav_ros {
namespace {

using visualization_msgs::Marker;
using voxnav_simulation::kNumSurfaceClasses;
using voxnav_simulation::SurfaceClass;
using voxnav_simulation::WorldMesh;

/// For each class the n of which every n-th triangle is shown; 0 hides the class.
using Strides = std::array<std::size_t, kNumSurfaceClasses>;

Strides strides_for(const WorldMesh& mesh, std::size_t max_triangles) {
  const auto leaves =
      static_cast<std::size_t>(std::count(mesh.classes.begin(), mesh.classes.end(), SurfaceClass::kFoliage));
  const std::size_t solid = mesh.classes.size() - leaves;
  const auto stride = [](std::size_t count, std::size_t room) { return room == 0 ? 0 : (count + room - 1) / room; };
  Strides out;
  out.fill(stride(solid, max_triangles));
  const std::size_t room = solid < max_triangles ? max_triangles - solid : 0;
  out[static_cast<std::size_t>(SurfaceClass::kFoliage)] = stride(leaves, room);
  return out;
}

Marker empty_marker(const std::string& frame_id, const std::string& ns, SurfaceClass surface_class) {
  Marker marker;
  marker.header.frame_id = frame_id;
  marker.ns = ns;
  marker.id = static_cast<int>(surface_class);
  marker.type = Marker::TRIANGLE_LIST;
  marker.action = Marker::ADD;
  marker.pose.orientation.w = 1.0;
  marker.scale.x = marker.scale.y = marker.scale.z = 1.0;
  const auto& rgb = voxnav_simulation::material_of(surface_class).rgb;
  marker.color.r = static_cast<float>(rgb[0]) / 255.0F;
  marker.color.g = static_cast<float>(rgb[1]) / 255.0F;
  marker.color.b = static_cast<float>(rgb[2]) / 255.0F;
  marker.color.a = 1.0F;
  return marker;
}

void append_triangle(const WorldMesh& mesh, std::size_t triangle, Marker* marker) {
  for (const std::uint32_t corner : mesh.triangles[triangle]) {
    marker->points.push_back(to_msg(voxnav::geometry::Vec3(mesh.vertices[corner].cast<double>())));
  }
}

}  // namespace

visualization_msgs::MarkerArray world_markers(const voxnav_simulation::Scene& scene, const std::string& frame_id,
                                              std::size_t max_triangles) {
  const WorldMesh& mesh = scene.world().mesh();
  const Strides strides = strides_for(mesh, max_triangles);
  visualization_msgs::MarkerArray out;
  for (int i = 0; i < kNumSurfaceClasses; ++i) {
    out.markers.push_back(empty_marker(frame_id, "world", static_cast<SurfaceClass>(i)));
  }
  Strides seen{};
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto kind = static_cast<std::size_t>(mesh.classes[t]);
    if (strides[kind] != 0 && seen[kind]++ % strides[kind] == 0) append_triangle(mesh, t, &out.markers[kind]);
  }
  const auto is_empty = [](const Marker& marker) { return marker.points.empty(); };
  out.markers.erase(std::remove_if(out.markers.begin(), out.markers.end(), is_empty), out.markers.end());
  if (const auto T_W_vehicle = scene.vehicle_pose()) {
    Marker vehicle = empty_marker(frame_id, "vehicle", SurfaceClass::kVehicle);
    vehicle.pose = to_msg(*T_W_vehicle);
    const WorldMesh& shape = scene.world().vehicle_mesh();
    for (std::size_t t = 0; t < shape.triangles.size(); ++t) append_triangle(shape, t, &vehicle);
    out.markers.push_back(std::move(vehicle));
  }
  return out;
}

visualization_msgs::MarkerArray mover_markers(const voxnav_simulation::Scene& scene, const std::string& frame_id,
                                              voxnav::base::StampNs stamp_ns) {
  visualization_msgs::MarkerArray out;
  for (const voxnav_simulation::Mover& mover : scene.world().movers()) {
    Marker marker = empty_marker(frame_id, "movers", mover.surface_class);
    marker.header.stamp = to_ros(stamp_ns);
    marker.id = static_cast<int>(out.markers.size());
    marker.type = Marker::CYLINDER;
    marker.pose.position = to_msg(mover.at(stamp_ns) + voxnav::geometry::Vec3(0, 0, 0.5 * mover.height_m));
    marker.scale.x = marker.scale.y = 2.0 * mover.radius_m;
    marker.scale.z = mover.height_m;
    out.markers.push_back(marker);
  }
  return out;
}

}  // namespace voxnav_ros
