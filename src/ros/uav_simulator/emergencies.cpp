// SPDX-License-Identifier: BSD-3-Clause
// Emergencies of the control manager, how a person ends them, and what its bumper hears.
#include "commands.hpp"

namespace voxnav_ros {
namespace {

constexpr const char* kNormalTracker = "MpcTracker";
constexpr const char* kNormalController = "Se3Controller";

/// Negative values say that there is no obstacle, or that nothing is known.
std::optional<double> range_of(double value) {
  if (!(value >= 0)) return std::nullopt;
  return value;
}

}  // namespace

void UavCommands::serve_string(ros::NodeHandle& nh, const std::string& name,
                               const std::function<Result(const std::string&)>& command) {
  using Callback = boost::function<bool(mrs_msgs::String::Request&, mrs_msgs::String::Response&)>;
  services_.push_back(nh.advertiseService(
      name, Callback([this, command](mrs_msgs::String::Request& request, mrs_msgs::String::Response& response) {
        const std::lock_guard<std::mutex> lock(*shared_.mutex);
        const Result result = command(request.value);
        response.success = result.success;
        response.message = result.message;
        return true;
      })));
}

void UavCommands::advertise_emergencies(ros::NodeHandle& nh) {
  trigger(nh, "control_manager/ehover", [this] { return shared_.uav->ehover(); });
  trigger(nh, "control_manager/eland", [this] { return shared_.uav->eland(); });
  trigger(nh, "control_manager/failsafe", [this] { return shared_.uav->failsafe(); });
  serve_string(nh, "control_manager/switch_tracker", [this](const std::string& name) {
    if (name != kNormalTracker) return Result{false, "the tracker '" + name + "' cannot be switched to"};
    return shared_.uav->switch_to_normal_tracker();
  });
  serve_string(nh, "control_manager/switch_controller", [this](const std::string& name) {
    if (name != kNormalController) return Result{false, "the controller '" + name + "' cannot be switched to"};
    return shared_.uav->switch_to_normal_controller();
  });
  subscribers_.push_back(nh.subscribe<mrs_msgs::ObstacleSectors>(
      "bumper/obstacle_sectors", 2, [this](const mrs_msgs::ObstacleSectorsConstPtr& msg) { hear_sectors(*msg); }));
}

void UavCommands::hear_sectors(const mrs_msgs::ObstacleSectors& msg) {
  const std::size_t count = msg.n_horizontal_sectors;
  if (count == 0 || msg.sectors.size() != count + 2) {
    ROS_WARN_THROTTLE(1.0, "[UavSimulator]: obstacle sectors refused: %zu values for %zu horizontal sectors",
                      msg.sectors.size(), count);
    return;
  }
  voxnav_simulation::SectorRanges sectors;
  for (std::size_t i = 0; i < count; ++i) sectors.horizontal_m.push_back(range_of(msg.sectors[i]));
  sectors.below_m = range_of(msg.sectors[count]);
  sectors.above_m = range_of(msg.sectors[count + 1]);
  const std::lock_guard<std::mutex> lock(*shared_.mutex);
  shared_.uav->set_sectors(sectors);
}

}  // namespace voxnav_ros
