// SPDX-License-Identifier: BSD-3-Clause
// What pilots, other nodes and the estimation manager do to a vehicle beside those who send it to places.
#include <mrs_msgs/TransformReferenceSrv.h>
#include <std_srvs/SetBool.h>

#include "commands.hpp"
#include "messages.hpp"
#include "voxnav_ros/conversions.hpp"

namespace voxnav_ros {
namespace {

/// MRS takes references in this frame, of which tf knows nothing: x is the latitude and y the longitude [deg].
constexpr const char* kLatLon = "latlon_origin";
constexpr const char* kWorld = "world_origin";

}  // namespace

using voxnav_simulation::HeadedPoint;
using voxnav_simulation::ServiceTimes;

void UavCommands::set_bool(ros::NodeHandle& nh, const std::string& name, const std::function<Result(bool)>& command) {
  using Set = std_srvs::SetBool;
  using Callback = boost::function<bool(Set::Request&, Set::Response&)>;
  services_.push_back(
      nh.advertiseService(name, Callback([this, command](Set::Request& request, Set::Response& response) {
                            const std::lock_guard<std::mutex> lock(*shared_.mutex);
                            const Result result = command(request.data != 0);
                            response.success = result.success;
                            response.message = result.message;
                            return true;
                          })));
}

/// The reference is relative to the tracker's command, in the control frame, as in the MRS control manager.
UavCommands::Result UavCommands::go_to_relative(const mrs_msgs::Vec4::Request& request) {
  const std::lock_guard<std::mutex> lock(*shared_.mutex);
  const auto state = transformed(frames_.T_C_O(), shared_.uav->tracker().state());
  const voxnav::geometry::Vec3 way(request.goal[0], request.goal[1], request.goal[2]);
  const HeadedPoint goal{state.position + way, state.heading_rad + request.goal[3]};
  return go_to(transformed(frames_.T_C_O().inverse(), goal));
}

UavCommands::Result UavCommands::transform(const std::string& to, const mrs_msgs::ReferenceStamped& from,
                                           mrs_msgs::ReferenceStamped* out) {
  const mrs_msgs::Reference& reference = from.reference;
  const auto& p = reference.position;
  HeadedPoint point{voxnav_ros::from_msg(p), reference.heading};
  std::string frame = from.header.frame_id;
  if (frame == kLatLon) {
    point.position = uav_messages::place_of(p.x, p.y, config_.node) + voxnav::geometry::Vec3(0, 0, p.z);
    frame = kWorld;
  }
  const auto T_O_from = frames_.T_O(frame), T_O_to = frames_.T_O(to);
  if (!T_O_from || !T_O_to) return {false, "the reference could not be transformed"};
  const HeadedPoint answer = transformed(T_O_to->inverse() * *T_O_from, point);
  out->header = from.header;
  out->header.frame_id = to.empty() ? frames_.control() : to;
  out->reference.position = to_msg(answer.position);
  out->reference.heading = answer.heading_rad;
  return {true, "transformation successful"};
}

void UavCommands::advertise_others(ros::NodeHandle& nh) {
  set_bool(nh, "control_manager/enable_callbacks", [this](bool is_enabled) {
    shared_.uav->enable_callbacks(is_enabled);
    return Result{true, is_enabled ? "callbacks enabled" : "callbacks disabled"};
  });
  // On a real vehicle this is a switch of the transmitter.
  set_bool(nh, "uav_simulator/remote_control", [this](bool is_remote) { return shared_.uav->set_remote(is_remote); });
  using Relative = boost::function<bool(mrs_msgs::Vec4::Request&, mrs_msgs::Vec4::Response&)>;
  services_.push_back(
      nh.advertiseService("control_manager/goto_relative",
                          Relative([this](mrs_msgs::Vec4::Request& request, mrs_msgs::Vec4::Response& response) {
                            let_pass(&ServiceTimes::command_ns);
                            const Result result = go_to_relative(request);
                            response.success = result.success;
                            response.message = result.message;
                            return true;
                          })));
  using Transform = mrs_msgs::TransformReferenceSrv;
  services_.push_back(nh.advertiseService("control_manager/transform_reference",
                                          boost::function<bool(Transform::Request&, Transform::Response&)>(
                                              [this](Transform::Request& request, Transform::Response& response) {
                                                const Result result =
                                                    transform(request.frame_id, request.reference, &response.reference);
                                                response.success = result.success;
                                                response.message = result.message;
                                                return true;
                                              })));
  serve_string(nh, "estimation_manager/change_estimator", [this](const std::string& name) {
    const std::string problem = frames_.switch_to(name);
    return Result{problem.empty(), problem.empty() ? "Estimator switch successful" : problem};
  });
}

}  // namespace voxnav_ros
