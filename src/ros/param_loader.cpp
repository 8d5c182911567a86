// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav_ros/param_loader.hpp"

#include <algorithm>

namespace voxnav_ros {
namespace {

using voxnav::base::Value;
using XmlRpc::XmlRpcValue;

bool to_list(XmlRpcValue& list, Value* out) {
  std::vector<double> numbers;
  std::vector<std::string> strings;
  for (int i = 0; i < list.size(); ++i) {
    XmlRpcValue& item = list[i];
    if (item.getType() == XmlRpcValue::TypeDouble) {
      numbers.push_back(static_cast<double>(item));
    } else if (item.getType() == XmlRpcValue::TypeInt) {
      numbers.push_back(static_cast<int>(item));
    } else if (item.getType() == XmlRpcValue::TypeString) {
      strings.push_back(static_cast<std::string>(item));
    } else {
      return false;
    }
  }
  if (!numbers.empty() && !strings.empty()) return false;
  if (strings.empty()) {
    *out = numbers;
  } else {
    *out = strings;
  }
  return true;
}

bool to_value(XmlRpcValue& in, Value* out) {
  switch (in.getType()) {
    case XmlRpcValue::TypeBoolean:
      *out = static_cast<bool>(in);
      return true;
    case XmlRpcValue::TypeInt:
      *out = static_cast<std::int64_t>(static_cast<int>(in));
      return true;
    case XmlRpcValue::TypeDouble:
      *out = static_cast<double>(in);
      return true;
    case XmlRpcValue::TypeString:
      *out = static_cast<std::string>(in);
      return true;
    case XmlRpcValue::TypeArray:
      return to_list(in, out);
    default:
      return false;
  }
}

}  // namespace

ParamLoader::ParamLoader(const ros::NodeHandle& private_nh) : node_(private_nh.getNamespace()) {
  if (!private_nh.getParam("", tree_) || tree_.getType() != XmlRpcValue::TypeStruct) {
    XmlRpcValue empty;
    empty["_"] = 0;  // a member makes the value a struct; this one is skipped below
    tree_ = empty;
  }
}

voxnav::base::ValueMap ParamLoader::take(const std::string& name) {
  known_.push_back(name);
  voxnav::base::ValueMap values;
  if (!tree_.hasMember(name)) return values;
  XmlRpcValue& section = tree_[name];
  if (section.getType() != XmlRpcValue::TypeStruct) {
    problems_.push_back(name + ": is a section and needs parameters below it");
    return values;
  }
  for (auto& entry : section) {
    Value value;
    if (to_value(entry.second, &value)) {
      values[entry.first] = value;
    } else {
      problems_.push_back(name + "/" + entry.first + ": needs a boolean, number, string or a list of one kind");
    }
  }
  return values;
}

void ParamLoader::finish() {
  for (auto& entry : tree_) {
    if (entry.first == "_") continue;
    const std::string problem = voxnav::base::detail::unknown_problem(entry.first, known_);
    // The services and loggers of nodelets keep nothing here, so whatever is left is a mistake.
    if (!problem.empty()) problems_.push_back(problem);
  }
  const std::string prefix = node_ + "/";
  for (std::string& problem : problems_) problem.insert(0, prefix);
  if (!problems_.empty()) throw voxnav::base::ConfigError(problems_);
}

}  // namespace voxnav_ros
