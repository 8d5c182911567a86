// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/subscriber.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace voxnav_ros {

/// What the local mapper knows of one of its sensors.
struct MapperSensor {
  std::string name;
  std::string progress_part;                 ///< see TimeSeam::report_done()
  std::string topic;                         ///< of its filtered clouds
  std::optional<std::string> mounted_frame;  ///< frame whose mount the mapper knows
  std::optional<double> heard_s;             ///< when the last cloud came, by the clock of the node
  std::uint64_t num_mapped = 0, num_dropped = 0, num_late = 0, num_surplus = 0;
  ros::Subscriber points;
};

/// The private name, without its tilde, on which a sensor's filtered clouds arrive. The first sensor has the name that
/// the only one has.
std::string points_in(std::size_t sensor, const std::string& name);

/// Tells which sensors are silent although another one delivers, a sentence for each.
/// @param now_s  time of the clock that heard_s is of
std::vector<std::string> silent_sensors(const std::vector<MapperSensor>& sensors, double now_s);

}  // namespace voxnav_ros
