// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/scan_matcher.hpp"

#include "base/plugin.hpp"

namespace voxnav::odometry {

std::unique_ptr<ScanMatcher> make_scan_matcher(const LidarOdometryConfig& config) {
  if (config.registration == RegistrationMethod::kMap) return nullptr;
  using Maker = ScanMatcher*(const LidarOdometryConfig&);
  return std::unique_ptr<ScanMatcher>(
      base::plugin_function<Maker>("libvoxnav_pcl.so", "voxnav_make_scan_matcher")(config));
}

}  // namespace voxnav::odometry
