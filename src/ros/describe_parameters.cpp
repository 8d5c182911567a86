// SPDX-License-Identifier: BSD-3-Clause
// Prints the parameters of all nodelets as JSON: {node: {section: [{name, default, min, max, choices, unit, doc}]}}.
// docs/parameters.md is generated from it, and test/python/test_parameters.py compares it with config/*.yaml.
#include <cmath>
#include <cstdio>
#include <iostream>
#include <sstream>

#include "lidar_odometry_config.hpp"
#include "local_mapper_config.hpp"
#include "submap_integrator_config.hpp"
#include "voxnav/cloud/body_mask.hpp"
#include "voxnav/cloud/cloud_filter_config.hpp"
#include "voxnav/cloud/depth_cloud.hpp"
#include "voxnav/cloud/open_beams.hpp"
#include "voxnav/cloud/pcl_filters.hpp"
#include "voxnav/occupancy/local_map_config.hpp"
#include "voxnav/occupancy/moving_things.hpp"
#include "voxnav/odometry/lidar_odometry_config.hpp"
#include "voxnav/pipeline/mapper_config.hpp"
#include "voxnav/pipeline/submap_scheduler.hpp"
#include "voxnav/pipeline/time_config.hpp"
#include "voxnav/submap/projective_integrator.hpp"
#include "voxnav/submap/submap_collection.hpp"
#ifdef VOXNAV_HAS_SIMULATION
#include "voxnav_simulation/depth_camera.hpp"
#include "voxnav_simulation/depth_camera_simulator_config.hpp"
#include "voxnav_simulation/estimator_switches.hpp"
#include "voxnav_simulation/lidar_config.hpp"
#include "voxnav_simulation/lidar_simulator_config.hpp"
#include "voxnav_simulation/losses.hpp"
#include "voxnav_simulation/safety_area.hpp"
#include "voxnav_simulation/service_times.hpp"
#include "voxnav_simulation/trajectory_generator.hpp"
#include "voxnav_simulation/uav.hpp"
#include "voxnav_simulation/uav_simulator_config.hpp"
#endif

namespace {

namespace base = voxnav::base;

std::string json(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + "\"";
}

std::string json(double value) {
  if (!std::isfinite(value)) return "null";
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.17g", value);
  return buffer;
}

std::string json(bool value) { return value ? "true" : "false"; }
std::string json(std::int64_t value) { return std::to_string(value); }

template <class T>
std::string json(const std::vector<T>& list) {
  std::string out;
  for (const T& item : list) out += (out.empty() ? "" : ", ") + json(item);
  return "[" + out + "]";
}

std::string json(const base::FieldInfo& f) {
  const std::string value = std::visit([](const auto& v) { return json(v); }, f.value);
  return "{\"name\": " + json(f.name) + ", \"default\": " + value + ", \"min\": " + json(f.rule.min) +
         ", \"max\": " + json(f.rule.max) + ", \"choices\": " + json(f.rule.choices) + ", \"unit\": " + json(f.unit) +
         ", \"doc\": " + json(f.doc) + "}";
}

template <class C>
std::string section(const char* name) {
  std::string fields;
  for (const base::FieldInfo& f : base::describe(C{})) fields += (fields.empty() ? "" : ",\n  ") + json(f);
  return json(std::string(name)) + ": [\n  " + fields + "]";
}

/// Prints the sections of a node and those that all nodes have.
void print(const char* node, std::vector<std::string> sections, bool is_last = false) {
  sections.push_back(section<voxnav::pipeline::TimeConfig>("time"));
  std::cout << json(std::string(node)) << ": {";
  for (std::size_t i = 0; i < sections.size(); ++i) std::cout << (i ? ",\n " : "\n ") << sections[i];
  std::cout << (is_last ? "}\n" : "},\n");
}

}  // namespace

int main() {
  namespace ros_ = voxnav_ros;
  std::cout << "{";
  print("cloud_filter",
        {section<voxnav::cloud::CloudFilterConfig>("filter"), section<voxnav::cloud::PclFiltersConfig>("pcl"),
         section<voxnav::cloud::OpenBeamsConfig>("open_beams"), section<voxnav::cloud::BodyMaskConfig>("body_mask")});
  print("depth_cloud", {section<voxnav::cloud::DepthCloudConfig>("depth")});
  print("lidar_odometry",
        {section<voxnav::odometry::LidarOdometryConfig>("odometry"), section<ros_::LidarOdometryNodeConfig>("node")});
  print("local_mapper",
        {section<voxnav::occupancy::LocalMapConfig>("map"), section<voxnav::occupancy::MovingThingsConfig>("moving"),
         section<voxnav::pipeline::SubmapSchedulerConfig>("submap"), section<voxnav::pipeline::MapperConfig>("mapper"),
         section<voxnav::pipeline::LoadControlConfig>("load"), section<voxnav::pipeline::SensorConfig>("lidar"),
         section<ros_::LocalMapperConfig>("node")});
#ifdef VOXNAV_HAS_SIMULATION
  namespace simulation = voxnav_simulation;
  print("lidar_simulator",
        {section<simulation::LidarConfig>("lidar"), section<simulation::LidarSimulatorConfig>("node")});
  print("depth_camera_simulator",
        {section<simulation::DepthCameraConfig>("camera"), section<simulation::DepthCameraSimulatorConfig>("node")});
  print("uav_simulator",
        {section<simulation::UavSimulatorConfig>("node"), section<simulation::UavConfig>("uav"),
         section<simulation::GnssDriftConfig>("drift"), section<simulation::ImuConfig>("imu"),
         section<simulation::UavConstraintsConfig>("constraints"),
         section<simulation::TrajectoryGeneratorConfig>("generator"), section<simulation::TrackingConfig>("tracking"),
         section<simulation::WindConfig>("wind"), section<simulation::StateNoiseConfig>("state_noise"),
         section<simulation::RefusalsConfig>("refusals"), section<simulation::AvoidanceConfig>("avoidance"),
         section<simulation::BumperConfig>("bumper"), section<simulation::EstimatorResetsConfig>("resets"),
         section<simulation::EstimatorSwitchesConfig>("switches"), section<simulation::SafetyAreaConfig>("safety_area"),
         section<simulation::ServiceTimesConfig>("services"), section<simulation::LossesConfig>("losses")});
#endif
  print("submap_integrator",
        {section<ros_::SubmapIntegratorConfig>("node"), section<voxnav::submap::SubmapConfig>("submap"),
         section<voxnav::submap::ProjectiveConfig>("projective"),
         section<voxnav::submap::SubmapCollectionConfig>("collection")},
        true);
  std::cout << "}\n";
}
