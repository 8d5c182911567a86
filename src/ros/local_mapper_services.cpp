// SPDX-License-Identifier: BSD-3-Clause
#include "local_mapper_nodelet.hpp"
#include "voxnav_ros/conversions.hpp"

namespace voxnav_ros {
namespace {

/// A refused request is answered with a reason; the call itself does not fail.
template <class Response, class Action>
bool answer(Response* response, const std::string& done, Action action) {
  try {
    action();
    response->success = true;
    response->message = done;
  } catch (const std::exception& error) {
    response->success = false;
    response->message = error.what();
  }
  return true;
}

}  // namespace

bool LocalMapperNodelet::on_get_map(voxnav::GetGrid::Request&, voxnav::GetGrid::Response& response) {
  response.success = true;
  response.grid = update_msg(mapper_->map().snapshot(), to_ros(mapper_->newest_stamp_ns().value_or(0)));
  return true;
}

bool LocalMapperNodelet::on_save(mrs_msgs::String::Request& request, mrs_msgs::String::Response& response) {
  return answer(&response, "saved to " + request.value, [&] { mapper_->map().save(request.value); });
}

bool LocalMapperNodelet::on_load(mrs_msgs::String::Request& request, mrs_msgs::String::Response& response) {
  return answer(&response, "loaded from " + request.value, [&] {
    occupancy::LocalMap loaded = occupancy::LocalMap::load(request.value);
    if (loaded.config().resolution_m != mapper_->map().config().resolution_m) {
      throw std::invalid_argument("its resolution is not that of this map");
    }
    restart("shutdown", "replaced by " + request.value);
    mapper_->map() = std::move(loaded);
    last_snapshot_ = ros::Time();
  });
}

bool LocalMapperNodelet::on_reset(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
  return answer(&response, "cleared", [&] { restart("shutdown", "by service"); });
}

bool LocalMapperNodelet::on_close_submap(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
  return answer(&response, "closed", [&] {
    const auto handovers = mapper_->finish("shutdown");
    if (handovers.empty()) throw std::runtime_error("no submap is open");
    hand_over(handovers);
  });
}

}  // namespace voxnav_ros
