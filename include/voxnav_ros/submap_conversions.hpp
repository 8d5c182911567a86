// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "voxnav/FinishedSubmap.h"
#include "voxnav/Handover.h"
#include "voxnav/SubmapPoses.h"
#include "voxnav/geometry/pose.hpp"
#include "voxnav/pipeline/submap_scheduler.hpp"
#include "voxnav/submap/submap_collection.hpp"
#include "voxnav_ros/messages.hpp"

namespace voxnav_ros {

/// Returns the handover of a message.
/// @throws std::invalid_argument if a pose or the content is not valid or the pose lists differ in length
voxnav::pipeline::Handover from_msg(const msg::Handover& msg);

/// Makes the message of a finished submap for the optimiser.
msg::FinishedSubmap to_msg(const voxnav::submap::SubmapEntry& entry, const std::string& odometry_frame);

/// Returns the submap of a message, with T_O_S as T_W_S, which messages do not have.
/// @throws std::invalid_argument if a pose or the data are not valid
voxnav::submap::SubmapEntry from_msg(const msg::FinishedSubmap& msg);

/// Returns the poses of a list. @throws std::invalid_argument naming `name` if one of them is not valid
std::vector<voxnav::geometry::Pose> valid_poses(const std::vector<geometry_msgs::Pose>& msgs, const char* name);

/// Returns the bend of each submap, in the order of the message; without bends in the message all are rigid.
/// @throws std::invalid_argument if a pose is not valid or the lists differ in length
std::vector<voxnav::geometry::Bend> bends_of(const msg::SubmapPoses& msg);

}  // namespace voxnav_ros
