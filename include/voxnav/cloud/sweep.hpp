// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "voxnav/cloud/cloud_filter.hpp"
#include "voxnav/geometry/pose.hpp"

namespace voxnav::cloud {

/// One turn of a LiDAR or one image of a depth camera, the form in which all parts after the filter take clouds: points
/// with their times, and open beams.
struct Sweep {
  base::StampNs stamp_ns = 0;           ///< stamp of the message, which nodes report when they have processed it
  base::StampNs start_ns = 0;           ///< when the sweep began: the stamp, or earlier when point times are negative
  std::string frame;                    ///< L, the frame of the points; empty where the sensor alone tells the mount
  std::size_t sensor = 0;               ///< number of the sensor among those of the vehicle
  std::vector<geometry::Vec3f> points;  ///< m, each as the sensor saw it at its time; may be not finite
  std::vector<std::uint32_t> time_offsets_ns;  ///< of each point, after start_ns; all zero when the cloud has no times
  std::uint32_t duration_ns = 0;               ///< the largest of them
  std::vector<geometry::Vec3f> open_beams;     ///< unit directions in which nothing returned
};

/// The one reader of clouds: any layout that RawCloudView takes, all points in their order, whatever their values.
/// Points without coordinates whose fields beam_x, beam_y, beam_z hold a direction are the sweep's open beams. Times in
/// `t` uint32 are those of the cloud filter; those of any other field are used if this cloud alone tells what they
/// count (PointTimes). The frame is left to the caller. O(points).
Sweep read_sweep(const RawCloudView& cloud);

/// Makes the same sweep that read_sweep() would read from the message of a filtered cloud, without serialising it.
/// @param stamp_ns  stamp of the raw cloud
Sweep sweep_of(const FilterResult& filtered, base::StampNs stamp_ns, std::vector<geometry::Vec3f> open_beams);

}  // namespace voxnav::cloud
