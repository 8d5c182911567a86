// SPDX-License-Identifier: BSD-3-Clause
#include "site.hpp"

namespace voxnav_simulation {
namespace {

void append_part(WorldMesh* mesh, const Vec3& center, const Vec3& size_m) {
  Pose T_V_part = Pose::Identity();
  T_V_part.translation() = center;
  append_box(mesh, T_V_part, size_m, SurfaceClass::kVehicle);
}

}  // namespace

WorldMesh make_fire_truck() {
  WorldMesh mesh;
  append_part(&mesh, {-1.1, 0.0, 1.85}, {5.6, 2.5, 2.3});   // body with pump and lockers
  append_part(&mesh, {2.9, 0.0, 1.70}, {2.1, 2.5, 2.0});    // cab
  append_part(&mesh, {4.05, 0.0, 0.75}, {0.3, 2.4, 0.4});   // bumper
  append_part(&mesh, {-0.4, 0.0, 3.25}, {7.2, 0.7, 0.25});  // ladder
  for (const double x : {-2.6, 2.6}) {
    for (const double y : {-1.05, 1.05}) append_part(&mesh, {x, y, 0.5}, {1.0, 0.35, 1.0});  // wheels
  }
  for (const double side : {-1.35, 1.35}) append_part(&mesh, {3.6, side, 2.1}, {0.1, 0.2, 0.35});  // mirrors
  return mesh;
}

}  // namespace voxnav_simulation
