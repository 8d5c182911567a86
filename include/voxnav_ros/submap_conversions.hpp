// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "voxnav/Handover.h"
#include "voxnav/Submap.h"
#include "voxnav/SubmapPoses.h"
#include "voxnav/geometry/pose.hpp"
#include "voxnav/pipeline/submap_scheduler.hpp"
#include "voxnav/submap/submap_collection.hpp"

namespace voxnav_ros {

/// The handover that a message holds.
/// @throws std::invalid_argument when a pose or the content is not valid or the pose lists differ in length
voxnav::pipeline::Handover from_msg(const voxnav::Handover& msg);

/// A finished submap as the optimiser gets it.
voxnav::Submap to_msg(const voxnav::submap::SubmapEntry& entry, const std::string& odometry_frame);

/// The submap that a message holds, with T_O_S in place of the T_W_S that messages do not have.
/// @throws std::invalid_argument when a pose or the data are not valid
voxnav::submap::SubmapEntry from_msg(const voxnav::Submap& msg);

/// The poses of a list. @throws std::invalid_argument that says `name` when one of them is not valid
std::vector<voxnav::geometry::Pose> valid_poses(const std::vector<geometry_msgs::Pose>& msgs, const char* name);

/// What drift did to each submap, in the order of the message; all are rigid where the message says nothing of it.
/// @throws std::invalid_argument when a pose is not valid or the lists differ in length
std::vector<voxnav::geometry::Bend> bends_of(const voxnav::SubmapPoses& msg);

}  // namespace voxnav_ros
