// SPDX-License-Identifier: BSD-3-Clause
#include "submap_octomap.hpp"

#include "voxnav_ros/octomap_messages.hpp"

namespace voxnav_ros {

void SubmapOctomap::advertise(ros::NodeHandle* nh) {
  full_.publisher = nh->advertise<octomap_msgs::Octomap>("octomap_out", 1);
  binary_.publisher = nh->advertise<octomap_msgs::Octomap>("octomap_binary_out", 1);
}

bool SubmapOctomap::has_readers() const {
  return full_.publisher.getNumSubscribers() + binary_.publisher.getNumSubscribers() > 0;
}

void SubmapOctomap::mark_changed() {
  full_.last.reset();
  binary_.last.reset();
}

void SubmapOctomap::publish(const MergedMap& map, const std_msgs::Header& header) {
  publish(map, header, &full_);
  publish(map, header, &binary_);
}

void SubmapOctomap::publish(const MergedMap& map, const std_msgs::Header& header, Topic* topic) {
  if (topic->publisher.getNumSubscribers() == 0) return;
  if (!topic->last) {
    const submap::EvidenceMap& evidence = map.collection().evidence();
    topic->last = octomap_message(submap::octomap_message_data(evidence, topic->is_binary), topic->is_binary,
                                  evidence.resolution_m(), header);
  }
  topic->last->header = header;
  topic->publisher.publish(*topic->last);
}

}  // namespace voxnav_ros
