// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/node_handle.h>
#include <sensor_msgs/PointCloud2.h>

#include <atomic>
#include <memory>
#include <string>
#include <vector>

#include "map_tiles.hpp"
#include "submap_integrator_config.hpp"
#include "submap_integrator_map.hpp"

namespace voxnav_ros {

/// A publisher that tells when there is a new subscriber.
class PictureTopic {
 public:
  template <class Msg>
  void advertise(ros::NodeHandle* nh, const std::string& name) {
    constexpr std::uint32_t kQueue = 100;
    publisher_ = nh->advertise<Msg>(name, kQueue, [this](const ros::SingleSubscriberPublisher&) { has_new_ = true; });
  }
  bool is_heard() const { return publisher_.getNumSubscribers() > 0; }
  /// Returns true if there are new subscribers since the last call.
  bool take_new() { return has_new_.exchange(false); }
  template <class Msg>
  void publish(const Msg& message) const {
    publisher_.publish(message);
  }

 private:
  std::atomic<bool> has_new_{false};
  ros::Publisher publisher_;
};

/// The pictures of the map for people. Nothing is drawn without subscribers, and a late subscriber gets the whole
/// picture. Markers are sent only where they changed, and in bounded pieces, so that neither obstacles nor a slow link
/// wait for them.
class SubmapPictures {
 public:
  explicit SubmapPictures(const SubmapIntegratorConfig& config);
  void advertise(ros::NodeHandle* nh);

  /// Marks blocks of the map as changed.
  void mark(const MergedMap& map, const std::vector<voxnav::geometry::Index3>& changed);
  /// Sends the next piece of each picture that is due. @return true if any was due
  bool turn(const MergedMap& map, const std_msgs::Header& header);

 private:
  /// A picture that is sent tile by tile, with its topic.
  struct Tiled {
    PictureTopic topic;
    std::unique_ptr<TiledMarkers> markers;
  };
  /// A picture that is sent as a whole.
  struct Whole {
    PictureTopic topic;
    bool is_due = true;
    bool take_due();
  };
  bool prepare(Tiled* tiled);
  bool send_array(const std_msgs::Header& header, Tiled* tiled);
  bool send_mesh(const std_msgs::Header& header);
  bool send_changes(const MergedMap& map, const std_msgs::Header& header);
  sensor_msgs::PointCloud2 slice_of(const MergedMap& map, const std_msgs::Header& header) const;

  SubmapIntegratorConfig config_;
  std::string frame_id_;
  const voxnav::submap::EvidenceMap* evidence_ = nullptr;  ///< valid during a turn
  MapTiles tiles_;
  Tiled occupancy_, submaps_, mesh_;
  Whole obstacle_cloud_, slice_, changes_, change_boxes_;
};

}  // namespace voxnav_ros
