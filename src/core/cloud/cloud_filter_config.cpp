// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/cloud/cloud_filter_config.hpp"

namespace voxnav::cloud {

std::vector<std::string> CloudFilterConfig::problems() const {
  std::vector<std::string> out;
  if (min_range_m >= max_range_m) {
    out.push_back("min_range_m = " + base::to_string(min_range_m) +
                  ": must be below max_range_m = " + base::to_string(max_range_m));
  }
  for (std::size_t axis = 0; axis < 3 && use_body_box; ++axis) {
    if (body_box_min_m[axis] < body_box_max_m[axis]) continue;
    out.push_back(std::string("body_box_min_m: must be below body_box_max_m on axis ") + "xyz"[axis]);
  }
  return out;
}

}  // namespace voxnav::cloud
