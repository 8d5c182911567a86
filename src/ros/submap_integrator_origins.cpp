// SPDX-License-Identifier: BSD-3-Clause
// How the global map follows the origin of the odometry, or is closed where it cannot.
#include "submap_integrator_nodelet.hpp"
#include "voxnav_ros/conversions.hpp"
#include "voxnav_ros/messages.hpp"

namespace voxnav_ros {

void SubmapIntegratorNodelet::on_origin(const msg::OdometryOriginConstPtr& msg) {
  enqueue("origin", [this, msg] { take_origin(*msg); });
}

/// The message is sent again to those who come late, and a mapper that was restarted does not know the origin before.
void SubmapIntegratorNodelet::take_origin(const msg::OdometryOrigin& msg) {
  const std::string& frame = msg.header.frame_id;
  if (!has_origin_) {
    has_origin_ = true;
    return origins_.begin(frame);
  }
  if (frame == origins_.frame()) return;
  const auto T_new_previous = from_msg(msg.T_O_previous);
  if (!T_new_previous) throw std::invalid_argument("T_O_previous is not a valid pose");
  const auto T_now_previous = origins_.from(msg.previous_frame);
  if (!msg.is_related || !T_now_previous) {
    return close_map(frame, "the odometry changed from " + origins_.frame() + " to " + frame + ", which do not relate");
  }
  const voxnav::geometry::Pose T_new_now = *T_new_previous * T_now_previous->inverse();
  origins_.change(frame, T_new_now, newest_id_ + 1);
  T_W_O_ = T_W_O_ * T_new_now.inverse();
  NODELET_WARN_STREAM("[" << node() << "]: the map is expressed in " << frame << " from now on");
}

/// Returns the transform to the newest origin from that of a handover.
voxnav::geometry::Pose SubmapIntegratorNodelet::into_origin(const std::string& frame) {
  if (frame.empty()) return voxnav::geometry::Pose::Identity();
  if (!has_origin_) origins_.begin(frame);
  has_origin_ = true;
  const auto T_now_frame = origins_.from(frame);
  if (!T_now_frame) throw std::invalid_argument("frame " + frame + " does not relate to " + origins_.frame());
  return *T_now_frame;
}

/// Forgets all submaps, because nothing that comes from now on relates to them.
void SubmapIntegratorNodelet::close_map(const std::string& frame, const std::string& reason) {
  const std::string text = "the map of " + std::to_string(map_->collection().size()) + " submaps is closed: " + reason;
  NODELET_ERROR_STREAM("[" << node() << "]: " << text);
  map_->replace(submap::SubmapCollection(collection_config_));
  origins_.begin(frame);
  T_W_O_ = voxnav::geometry::Pose::Identity();
  refresh(last_stamp_);
  diagnostics().set_level(msg::NodeDiagnostics::WARN, text);
}

void SubmapIntegratorNodelet::express_now(const submap::SubmapEntry& entry, msg::FinishedSubmap* msg) const {
  msg->T_O_S = to_msg(expressed(origins_.from_that_of(entry.id), entry.T_O_S));
}

}  // namespace voxnav_ros
