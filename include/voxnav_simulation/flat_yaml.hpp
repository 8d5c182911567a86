// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "voxnav/base/config.hpp"

namespace voxnav_simulation {

/// Reads the part of YAML that a parameter set needs: one `key: value` per line, where a value is true, false, a
/// number, a string (quoted or plain) or a [list] of numbers or strings; `#` starts a comment.
/// @throws voxnav::base::ConfigError naming the lines that are anything else, or the file that cannot be read
voxnav::base::ValueMap read_flat_yaml(const std::string& path);
voxnav::base::ValueMap parse_flat_yaml(const std::string& text, const std::string& origin);

}  // namespace voxnav_simulation
