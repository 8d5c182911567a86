// SPDX-License-Identifier: BSD-3-Clause
#include "tf_locator.hpp"

#include <tf2/exceptions.h>

#include <utility>

#include "voxnav_ros/conversions.hpp"

namespace voxnav_ros {
namespace {

using voxnav::geometry::Pose;
using voxnav::pipeline::SweepLocation;

constexpr std::uint32_t kQueue = 1000;
constexpr double kMaxAge_s = 1.0;  ///< of a transform between two origins, which only drifts

}  // namespace

TfLocator::TfLocator(std::string odometry_frame, std::string body_frame)
    : odometry_frame_(std::move(odometry_frame)), body_frame_(std::move(body_frame)) {}

void TfLocator::start(ros::NodeHandle& nh, std::function<void()> on_change) {
  on_change_ = std::move(on_change);
  const auto hints = ros::TransportHints().tcpNoDelay();
  const auto subscribe = [&](const char* topic, bool is_static) {
    const auto callback = [this, is_static](const tf2_msgs::TFMessageConstPtr& msg) { take(*msg, is_static); };
    return nh.subscribe<tf2_msgs::TFMessage>(topic, kQueue, callback, nullptr, hints);
  };
  static_ = subscribe("/tf_static", true);
  dynamic_ = subscribe("/tf", false);
}

void TfLocator::take(const tf2_msgs::TFMessage& msg, bool is_static) {
  // The buffer is cleared, as tf2's own listener does: transforms of a future that was reset must not answer queries.
  const ros::Time now = ros::Time::now();
  if (now < newest_) buffer_.clear();
  newest_ = now;
  for (const geometry_msgs::TransformStamped& transform : msg.transforms) {
    buffer_.setTransform(transform, "tf", is_static);
  }
  on_change_();
}

SweepLocation TfLocator::locate(const voxnav::cloud::Sweep& sweep, std::uint32_t duration_ns) const {
  SweepLocation out;
  out.status = SweepLocation::Status::kKnown;
  const auto start = lookup(sweep.frame, sweep.start_ns, &out);
  const auto end = lookup(sweep.frame, sweep.start_ns + duration_ns, &out);
  const auto body = lookup(body_frame_, sweep.start_ns + duration_ns / 2, &out);
  if (start && end && body) out.poses = {{*start, *end, duration_ns}, *body};
  return out;
}

std::optional<Pose> TfLocator::between(const std::string& a, const std::string& b, const ros::Time& stamp) const {
  try {
    const geometry_msgs::TransformStamped found = buffer_.lookupTransform(a, b, ros::Time(0));
    const bool is_static = found.header.stamp.isZero();
    if (!is_static && (stamp - found.header.stamp).toSec() > kMaxAge_s) return std::nullopt;
    return from_msg(found.transform);
  } catch (const tf2::TransformException&) {
    return std::nullopt;
  }
}

std::optional<Pose> TfLocator::mount(const std::string& sensor_frame) const {
  try {
    return from_msg(buffer_.lookupTransform(body_frame_, sensor_frame, ros::Time(0)).transform);
  } catch (const tf2::TransformException&) {
    return std::nullopt;
  }
}

std::optional<Pose> TfLocator::lookup(const std::string& frame, voxnav::base::StampNs stamp_ns,
                                      Location* location) const {
  const ros::Time stamp = to_ros(stamp_ns);
  if (odometry_frame_.empty()) {
    location->problem = "no uav_state yet, whose frame is that of the map";
    location->status = Location::Status::kNotYet;
    return std::nullopt;
  }
  try {
    auto pose = from_msg(buffer_.lookupTransform(odometry_frame_, frame, stamp).transform);
    if (pose) return pose;
    location->problem = "tf from " + frame + " to " + odometry_frame_ + " is not a rigid transform";
    location->status = Location::Status::kNever;
  } catch (const tf2::ExtrapolationException& error) {
    location->problem = error.what();
    location->status = has_newer(frame, stamp) ? Location::Status::kNever : Location::Status::kNotYet;
  } catch (const tf2::TransformException& error) {
    location->problem = error.what();
    location->status = Location::Status::kNotYet;
  }
  return std::nullopt;
}

/// Transforms rise with time: when there is a newer one and still none for this stamp, none will come.
bool TfLocator::has_newer(const std::string& frame, const ros::Time& stamp) const {
  try {
    return buffer_.lookupTransform(odometry_frame_, frame, ros::Time(0)).header.stamp > stamp;
  } catch (const tf2::TransformException&) {
    return false;
  }
}

}  // namespace voxnav_ros
