// SPDX-License-Identifier: BSD-3-Clause
#include "mapper_sensor.hpp"

#include <algorithm>

namespace voxnav_ros {
namespace {

/// No sensor is slower than this.
constexpr double kMaxSilence_s = 1.0;

bool is_heard(const MapperSensor& sensor, double now_s) {
  return sensor.heard_s && now_s - *sensor.heard_s <= kMaxSilence_s;
}

}  // namespace

std::string points_in(std::size_t sensor, const std::string& name) {
  return sensor == 0 ? "points_in" : name + "/points_in";
}

std::vector<std::string> silent_sensors(const std::vector<MapperSensor>& sensors, double now_s) {
  std::vector<std::string> out;
  const auto delivers = [&](const MapperSensor& sensor) { return is_heard(sensor, now_s); };
  if (std::none_of(sensors.begin(), sensors.end(), delivers)) return out;
  for (const MapperSensor& sensor : sensors) {
    if (delivers(sensor)) continue;
    const std::string since =
        sensor.heard_s ? "for " + std::to_string(now_s - *sensor.heard_s) + " s" : std::string("since the start");
    out.push_back("sensor '" + sensor.name + "' is silent: nothing came on " + sensor.topic + " " + since);
  }
  return out;
}

}  // namespace voxnav_ros
