// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sensor_msgs/PointCloud2.h>
#include <visualization_msgs/Marker.h>
#include <visualization_msgs/MarkerArray.h>

#include <vector>

#include "voxnav/submap/submap_collection.hpp"

namespace voxnav_ros {

/// Voxels that hold a believed surface, as one CUBE_LIST per submap in the submap's colour; the first marker deletes
/// what was shown before. Beyond max_cubes every n-th voxel is left out, evenly.
visualization_msgs::MarkerArray occupancy_markers(const voxnav::submap::SubmapCollection& collection,
                                                  const std_msgs::Header& header, std::size_t max_cubes);

/// Mesh of one submap as TRIANGLE_LIST at its pose; the marker id is the submap id.
visualization_msgs::Marker mesh_marker(const voxnav::submap::SubmapEntry& entry, const std_msgs::Header& header,
                                       std::size_t max_triangles);

/// Distances to the nearest believed surface (field `intensity`) on a horizontal plane through known space of `bounds`.
sensor_msgs::PointCloud2 distance_slice(const voxnav::submap::EvidenceMap& evidence,
                                        const voxnav::geometry::Aabb& bounds, double height_m, double max_distance_m,
                                        std::size_t max_points, const std_msgs::Header& header);

/// Centres of occupied voxels; beyond max_points every n-th is left out, evenly.
sensor_msgs::PointCloud2 occupied_cloud(const voxnav::containers::StateGrid& grid, std::size_t max_points,
                                        const std_msgs::Header& header);

}  // namespace voxnav_ros
