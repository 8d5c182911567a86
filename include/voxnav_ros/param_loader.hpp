// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/node_handle.h>

#include <string>
#include <vector>

#include "voxnav/base/config.hpp"

namespace voxnav_ros {

/// Loads the sections of a node's private parameters into configuration structs, strictly.
///
///   ParamLoader params(private_nh);
///   params.section("map", &map_config);
///   params.section("node", &node_config);
///   params.finish();   // throws ConfigError listing every problem of every section
///
/// Keys that belong to no section are problems too, so a typo never leaves a default in silence.
class ParamLoader {
 public:
  explicit ParamLoader(const ros::NodeHandle& private_nh);

  template <class C>
  void section(const std::string& name, C* config) {
    const voxnav::base::ValueMap values = take(name);
    for (const std::string& problem : voxnav::base::assign(config, values, name + "/")) problems_.push_back(problem);
  }

  void finish();

 private:
  voxnav::base::ValueMap take(const std::string& name);

  std::string node_;
  XmlRpc::XmlRpcValue tree_;
  std::vector<std::string> known_;
  std::vector<std::string> problems_;
};

}  // namespace voxnav_ros
