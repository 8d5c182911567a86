// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "voxnav/cloud/cloud_filter.hpp"
#include "voxnav/geometry/pose.hpp"

namespace voxnav::cloud {

/// One turn of a LiDAR as all parts after the filter take it: what returned, when, and where nothing did.
struct Sweep {
  base::StampNs stamp_ns = 0;           ///< of the message, by which its work is reported
  base::StampNs start_ns = 0;           ///< when the sweep began: the stamp, or earlier when point times are negative
  std::string frame;                    ///< L, the frame of the points; empty where only one sensor is meant
  std::vector<geometry::Vec3f> points;  ///< m, each as the sensor saw it at its time; may be not finite
  std::vector<std::uint32_t> time_offsets_ns;  ///< of each point, after start_ns; all zero when the cloud has no times
  std::uint32_t duration_ns = 0;               ///< the largest of them
  std::vector<geometry::Vec3f> open_beams;     ///< unit directions in which nothing returned
};

/// The one reader of clouds: any layout that RawCloudView takes, all points in their order, whatever their values.
/// Points without coordinates whose fields beam_x, beam_y, beam_z hold a direction are the sweep's open beams. The
/// frame is left to the caller. O(points).
Sweep read_sweep(const RawCloudView& cloud);

/// The same sweep that read_sweep() finds in the message of a filtered cloud, without the detour over its bytes.
/// @param stamp_ns of the raw cloud
Sweep sweep_of(const FilterResult& filtered, base::StampNs stamp_ns, std::vector<geometry::Vec3f> open_beams);

}  // namespace voxnav::cloud
