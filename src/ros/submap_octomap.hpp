// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <octomap_msgs/Octomap.h>
#include <ros/ros.h>

#include <optional>

#include "submap_integrator_map.hpp"

namespace voxnav_ros {

/// Publishes the merged map as OctoMaps, for programs that know nothing of submaps. A map that did not change is sent
/// again with a new stamp, since readers such as planners of MRS take an old map for a lost one. Not thread-safe.
class SubmapOctomap {
 public:
  void advertise(ros::NodeHandle* nh);
  bool has_readers() const;
  /// Tells that the map has changed since the last message.
  void mark_changed();
  /// @throws std::length_error for a map beyond the reach of an OctoMap
  void publish(const MergedMap& map, const std_msgs::Header& header);

 private:
  struct Topic {
    bool is_binary;
    ros::Publisher publisher;
    std::optional<octomap_msgs::Octomap> last;  ///< made of the present map
  };
  static void publish(const MergedMap& map, const std_msgs::Header& header, Topic* topic);

  Topic full_{false, {}, {}}, binary_{true, {}, {}};
};

}  // namespace voxnav_ros
