// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace voxnav {}

namespace voxnav_ros {

/// Messages of this package. ROS 1 generates them into the namespace of the core, so that msg::Handover is what is sent
/// of a voxnav::pipeline::Handover (docs/terminology.md, "Messages").
namespace msg = ::voxnav;

}  // namespace voxnav_ros
