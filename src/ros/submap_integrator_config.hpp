// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <string>
#include <vector>

#include "voxnav/base/config.hpp"

namespace voxnav_ros {

/// The source of submaps: the content of the local map, or the scans themselves (submap::ProjectiveIntegrator).
enum class SubmapFilling { kOccupancy, kProjective };
constexpr auto words_of(SubmapFilling) { return std::array{"occupancy", "projective"}; }

/// Section `node` of voxnav/SubmapIntegrator.
struct SubmapIntegratorConfig {
  std::string map_frame = "map";
  std::string odometry_frame = "odom";
  SubmapFilling filling = SubmapFilling::kOccupancy;
  double safety_distance_m = 1.5;
  double snapshot_period_s = 20.0;
  int max_queue = 32;
  int max_open_handovers = 4;
  double projective_period_s = 0.0;
  double tf_timeout_s = 0.3;
  double picture_period_s = 0.2;
  int max_markers = 20000;
  int min_marker_hits = 2;
  double color_min_m = -4.0;
  double color_max_m = 12.0;
  int max_mesh_triangles = 20000;
  int max_cloud_points = 200000;
  int max_changes = 100;
  double slice_offset_m = 0.0;
  double slice_max_distance_m = 6.0;
  double octomap_period_s = 1.0;
  std::string autosave_dir;

  template <class V>
  static void fields(V&& v) {
    namespace base = voxnav::base;
    using C = SubmapIntegratorConfig;
    v("map_frame", &C::map_frame, base::any(), "", "frame W, until the optimiser names it");
    v("odometry_frame", &C::odometry_frame, base::any(), "", "frame O, until a handover names it");
    v("filling", &C::filling, base::one_of<SubmapFilling>(), "", "what submaps are made of");
    v("safety_distance_m", &C::safety_distance_m, base::in(0.0, 10.0), "m",
      "voxels nearer to a surface than this are obstacles");
    v("snapshot_period_s", &C::snapshot_period_s, base::in(1.0, 3600.0), "s",
      "obstacles are published as a whole this often (wall time)");
    v("max_queue", &C::max_queue, base::in(2, 1000), "",
      "inputs waiting for the worker; newer ones are refused beyond");
    v("max_open_handovers", &C::max_open_handovers, base::in(1, 100), "",
      "submaps with early content; the oldest is dropped beyond");
    v("projective_period_s", &C::projective_period_s, base::in(0.0, 3600.0), "s",
      "projective filling closes a submap this often; 0 = with the handovers of the local mapper");
    v("tf_timeout_s", &C::tf_timeout_s, base::in(0.0, 5.0), "s",
      "how long a cloud waits for its pose (projective filling)");
    v("picture_period_s", &C::picture_period_s, base::in(0.05, 10.0), "s",
      "pictures are sent piece by piece, one piece per topic this often (wall time)");
    v("max_markers", &C::max_markers, base::in(1, 1000000), "", "cubes per occupancy message");
    v("min_marker_hits", &C::min_marker_hits, base::in(1, 255), "",
      "surfaces that fewer scans have hit are not shown as cubes");
    v("color_min_m", &C::color_min_m, base::in(-1000.0, 1000.0), "m",
      "height in W of the lower end of the colours (red), as in rviz/*.rviz");
    v("color_max_m", &C::color_max_m, base::in(-1000.0, 1000.0), "m",
      "height in W of the upper end of the colours (magenta)");
    v("max_mesh_triangles", &C::max_mesh_triangles, base::in(1, 1000000), "", "triangles per turn of the mesh");
    v("max_cloud_points", &C::max_cloud_points, base::in(1, 10000000), "", "points per obstacle cloud or slice");
    v("max_changes", &C::max_changes, base::in(1, 10000), "", "appeared and disappeared things per message");
    v("slice_offset_m", &C::slice_offset_m, base::in(-100.0, 100.0), "m",
      "height of the slice above the end of the newest submap");
    v("slice_max_distance_m", &C::slice_max_distance_m, base::in(0.5, 50.0), "m",
      "distances in the slice saturate here");
    v("octomap_period_s", &C::octomap_period_s, base::in(0.1, 1000.0), "s",
      "period of OctoMaps of the whole map on ~octomap_out (log-odds) and ~octomap_binary_out (occupied or free), each "
      "sent while somebody subscribes (wall time)");
    v("autosave_dir", &C::autosave_dir, base::any(), "", "where the map is saved after every submap; empty = nowhere");
  }
  std::vector<std::string> problems() const {
    if (color_max_m > color_min_m) return {};
    return {"color_max_m must be above color_min_m"};
  }
};

}  // namespace voxnav_ros
