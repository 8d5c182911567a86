// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "voxnav/base/config.hpp"

namespace voxnav_simulation {

/// Reads a parameter set from YAML: a mapping from keys to values, each of which is true, false, a number, a string or
/// a list of numbers or of strings.
/// @throws voxnav::base::ConfigError if the file cannot be read or holds anything else; it names the file and the line
voxnav::base::ValueMap read_flat_yaml(const std::string& path);
voxnav::base::ValueMap parse_flat_yaml(const std::string& text, const std::string& origin);

}  // namespace voxnav_simulation
