// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sensor_msgs/PointCloud2.h>

#include <vector>

#include "voxnav/cloud/cloud_filter.hpp"
#include "voxnav/cloud/cloud_layout.hpp"
#include "voxnav/cloud/sweep.hpp"
#include "voxnav/geometry/points_view.hpp"

namespace voxnav_ros {

voxnav::cloud::CloudLayout layout_of(const sensor_msgs::PointCloud2& msg);

/// Writes size and fields of a layout into a message, whose bytes are there already.
void set_layout(const voxnav::cloud::CloudLayout& layout, sensor_msgs::PointCloud2* msg);

/// Returns a view into a message, which must outlive the view.
/// @throws std::invalid_argument telling what is wrong with the message
voxnav::cloud::RawCloudView view_of(const sensor_msgs::PointCloud2& msg);

/// Makes a cloud of one row with the fields x y z intensity float32 and t uint32 (ns after the stamp).
sensor_msgs::PointCloud2Ptr to_msg(const std::vector<voxnav::cloud::Point>& points, const std_msgs::Header& header);

/// Makes such a cloud with a further row for each open beam. The row of a beam has no coordinates (NaN, so that readers
/// of points skip it) and its unit direction in beam_x, beam_y, beam_z, which are 0 in rows of points.
sensor_msgs::PointCloud2Ptr to_msg(const std::vector<voxnav::cloud::Point>& points,
                                   const std::vector<voxnav::geometry::Vec3f>& open_beams,
                                   const std_msgs::Header& header);

/// @throws std::invalid_argument saying what is wrong with the message
voxnav::cloud::Sweep sweep_of(const sensor_msgs::PointCloud2& msg);

/// Makes a cloud of one row with the fields x y z float32.
sensor_msgs::PointCloud2 xyz_cloud_of(const voxnav::geometry::PointsView& points, const std_msgs::Header& header);

}  // namespace voxnav_ros
