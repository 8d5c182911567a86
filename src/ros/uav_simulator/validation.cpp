// SPDX-License-Identifier: BSD-3-Clause
// The answers of the control manager to those who ask whether a reference is within its safety area.
#include <mrs_msgs/ValidateReference.h>
#include <mrs_msgs/ValidateReferenceArray.h>

#include "commands.hpp"
#include "voxnav_ros/conversions.hpp"

namespace voxnav_ros {

using voxnav_simulation::SafetyLimits;

/// A reference is refused, too, if the straight way to it leaves the area.
UavCommands::Result UavCommands::validate(const std_msgs::Header& header, const mrs_msgs::Reference& reference,
                                          SafetyLimits limits) {
  const voxnav::geometry::Vec3 p = voxnav_ros::from_msg(reference.position);
  if (!p.allFinite() || !std::isfinite(reference.heading)) return {false, "NaNs/infs in input!"};
  const auto T_O_frame = frames_.T_O(header.frame_id);
  if (!T_O_frame) return {false, "the reference could not be transformed"};
  const voxnav::geometry::Vec3 there = *T_O_frame * p;
  if (!is_inside(config_.safety_area, there, limits)) return {false, "the point is outside of the safety area"};
  const std::lock_guard<std::mutex> lock(*shared_.mutex);
  if (!is_way_inside(config_.safety_area, shared_.uav->tracker().state().position, there, limits)) {
    return {false, "the path is going outside the safety area"};
  }
  return {true, "the reference is ok"};
}

void UavCommands::advertise_validation(ros::NodeHandle& nh) {
  using One = mrs_msgs::ValidateReference;
  const auto serve_one = [&](const std::string& name, SafetyLimits limits) {
    services_.push_back(nh.advertiseService(
        name, boost::function<bool(One::Request&, One::Response&)>(
                  [this, limits](One::Request& request, One::Response& response) {
                    const Result result = validate(request.reference.header, request.reference.reference, limits);
                    response.success = result.success;
                    response.message = result.message;
                    return true;
                  })));
  };
  serve_one("control_manager/validate_reference", SafetyLimits::kBorderAndHeights);
  serve_one("control_manager/validate_reference_2d", SafetyLimits::kBorder);
  using Many = mrs_msgs::ValidateReferenceArray;
  services_.push_back(nh.advertiseService(
      "control_manager/validate_reference_array",
      boost::function<bool(Many::Request&, Many::Response&)>([this](Many::Request& request, Many::Response& response) {
        if (!frames_.T_O(request.array.header.frame_id)) return false;
        for (const auto& each : request.array.array) {
          const Result result = validate(request.array.header, each, SafetyLimits::kBorderAndHeights);
          response.success.push_back(static_cast<std::uint8_t>(result.success));
        }
        response.message = "references were checked";
        return true;
      })));
}

}  // namespace voxnav_ros
