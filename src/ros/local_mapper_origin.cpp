// SPDX-License-Identifier: BSD-3-Clause
// The origin of the local map's frame, and what its jumps and changes mean for the map.
#include "local_mapper_nodelet.hpp"
#include "voxnav_ros/conversions.hpp"
#include "voxnav_ros/messages.hpp"

namespace voxnav_ros {
namespace {

/// How long the relation between two origins is looked for on tf, where both are only for as long as both run.
constexpr double kRelationWait_s = 0.5;

}  // namespace

/// Estimators are switched and reset by the MRS estimation manager, which counts both. After a reset the frame has the
/// same name but another origin.
void LocalMapperNodelet::on_uav_state(const mrs_msgs::UavStateConstPtr& msg) {
  const bool has_jumped = estimator_iteration_ && *estimator_iteration_ != msg->estimator_iteration;
  estimator_iteration_ = msg->estimator_iteration;
  const std::string frame = frame_name(msg->header.frame_id);
  if (follows_estimator_ && frame != frame_ && !frame.empty()) return follow_estimator(frame, msg->header.stamp);
  switched_ = ros::Time();
  if (!has_jumped) return;
  if (frame == frame_) {
    restart("estimator", "the estimator was reset");
  } else {
    mapper_->request_close("estimator");
  }
}

/// Takes over another origin. The content of the map goes to the global map, which can be expressed in any origin; the
/// map itself begins anew.
void LocalMapperNodelet::follow_estimator(const std::string& frame, const ros::Time& stamp) {
  const std::string previous = frame_;
  std::optional<voxnav::geometry::Pose> T_O_previous;
  if (!previous.empty()) {
    T_O_previous = tf_->between(frame, previous, stamp);
    if (switched_.isZero() || stamp < switched_) switched_ = stamp;
    if (!T_O_previous && (stamp - switched_).toSec() < kRelationWait_s) return;
    restart("estimator", "the estimator was switched from " + previous + " to " + frame +
                             (T_O_previous ? "" : ", to which tf has no transform"));
  }
  switched_ = ros::Time();
  frame_ = frame;
  tf_->set_odometry_frame(frame);
  announce_origin(stamp, previous, T_O_previous);
  process();
}

void LocalMapperNodelet::announce_origin(const ros::Time& stamp, const std::string& previous,
                                         const std::optional<voxnav::geometry::Pose>& T_O_previous) {
  msg::OdometryOrigin out;
  out.header = header(stamp);
  out.previous_frame = previous;
  out.is_related = T_O_previous.has_value();
  out.T_O_previous =
      to_msg(voxnav::geometry::gravity_aligned(T_O_previous.value_or(voxnav::geometry::Pose::Identity())));
  origin_.publish(out);
}

}  // namespace voxnav_ros
