// SPDX-License-Identifier: BSD-3-Clause
#include "body_learning.hpp"

namespace voxnav_ros {
namespace {

constexpr double kControlTimeout_s = 2.0;

}  // namespace

BodyLearning::BodyLearning(ros::NodeHandle nh, const voxnav::cloud::BodyMaskConfig& config)
    : config_(config), control_topic_(nh.resolveName("control_diagnostics_in")) {
  service_ = nh.advertiseService("learn_body_in", &BodyLearning::on_learn, this);
}

void BodyLearning::start(ros::NodeHandle nh) {
  control_ = nh.subscribe("control_diagnostics_in", 1, &BodyLearning::on_control, this);
}

std::optional<voxnav::cloud::BodyMask> BodyLearning::add(const voxnav::cloud::RawCloudView& cloud) {
  if (!learner_) return std::nullopt;
  if (const std::string reason = refusal(); !reason.empty()) {
    ROS_WARN_STREAM("[CloudFilter]: learning the body given up: " << reason);
    learner_.reset();
    return std::nullopt;
  }
  learner_->add(cloud);
  if (!learner_->is_done()) return std::nullopt;
  voxnav::cloud::BodyMask mask = learner_->finish();
  learner_.reset();
  return mask;
}

/// Tells why the body may not be learnt now; empty if it may.
std::string BodyLearning::refusal() const {
  if (!heard_ || (ros::SteadyTime::now() - *heard_).toSec() > kControlTimeout_s)
    return "nothing on " + control_topic_ + " says that the UAV stands on the ground";
  return is_flying_ ? "the UAV flies; land first" : "";
}

void BodyLearning::on_control(const mrs_msgs::ControlManagerDiagnosticsConstPtr& msg) {
  is_flying_ = msg->flying_normally || msg->output_enabled;
  heard_ = ros::SteadyTime::now();
}

bool BodyLearning::on_learn(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
  response.message = refusal();
  response.success = response.message.empty();
  if (!response.success) return true;
  learner_ = std::make_unique<voxnav::cloud::BodyMaskLearner>(config_);
  response.message = "learning from the next " + std::to_string(config_.num_clouds) + " clouds";
  return true;
}

}  // namespace voxnav_ros
