// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sensor_msgs/PointCloud2.h>
#include <visualization_msgs/Marker.h>
#include <visualization_msgs/MarkerArray.h>

#include <vector>

#include "voxnav/SceneChanges.h"
#include "voxnav/submap/mesh.hpp"
#include "voxnav/submap/submap_collection.hpp"
#include "voxnav_ros/messages.hpp"

namespace voxnav_ros {

using Blocks = std::vector<voxnav::geometry::Index3>;

/// Returns an empty marker of the given type at the identity pose.
visualization_msgs::Marker blank_marker(const char* ns, std::int32_t type, double scale_m);

/// How voxels that hold a believed surface are shown as cubes.
struct CubeStyle {
  int min_hits = 1;           ///< surfaces that were hit by fewer scans are left out
  bool is_by_submap = false;  ///< whether each submap has a colour of its own; else colours show height
  voxnav::submap::HeightScale heights;
};

/// Adds the voxels of some blocks that hold a believed surface point, as cubes.
void add_cubes(const voxnav::submap::EvidenceMap& evidence, const Blocks& blocks, const CubeStyle& style,
               visualization_msgs::Marker* marker);

/// Adds the triangles of the merged mesh in some blocks, coloured by height.
void add_mesh(const voxnav::submap::EvidenceMap& evidence, const Blocks& blocks,
              const voxnav::submap::HeightScale& heights, std::size_t max_triangles,
              visualization_msgs::Marker* marker);

/// Makes a cloud of distances to the nearest believed surface (field `intensity`) on a horizontal plane through the
/// known space of `bounds`; it is coarser than the voxels if more than max_points would be needed.
sensor_msgs::PointCloud2 distance_slice(const voxnav::submap::EvidenceMap& evidence,
                                        const voxnav::geometry::Aabb& bounds, double height_m, double max_distance_m,
                                        std::size_t max_points, const std_msgs::Header& header);

/// Returns the centres of occupied voxels. If there are more than max_points, every n-th one is taken, evenly over the
/// map.
sensor_msgs::PointCloud2 occupied_cloud(const voxnav::containers::StateGrid& grid, std::size_t max_points,
                                        const std_msgs::Header& header);

/// Makes the message of at most `max_changes` changes, the largest first; it tells how many were left out.
msg::SceneChanges to_msg(std::vector<voxnav::submap::SceneChange> changes, std::size_t max_changes,
                         const std_msgs::Header& header);

/// Makes a green box around everything that appeared and a red one around everything that disappeared. The first marker
/// deletes those of the message before.
visualization_msgs::MarkerArray boxes_of(const msg::SceneChanges& changes);

}  // namespace voxnav_ros
