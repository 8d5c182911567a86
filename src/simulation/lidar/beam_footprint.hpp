// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "voxnav_simulation/lidar_config.hpp"

namespace voxnav_simulation {

/// The rays that stand for a beam with width. Each carries the same share of the light: they lie where a Gaussian
/// beam has its quantiles, on a spiral, so that the footprint is covered evenly whatever their number. A single ray
/// is the axis of the beam. The diameter at which the beam leaves the sensor (5 mm) is neglected.
/// Sources: sub-rays of a footprint as in Winiwarter et al., HELIOS++, Remote Sensing of Environment 2022, section 3.4;
/// the spiral is that of Vogel, "A better way to construct the sunflower head", Mathematical Biosciences 1979.
class BeamFootprint {
 public:
  explicit BeamFootprint(const LidarConfig& config);

  std::size_t num_rays() const { return offsets_.size(); }
  /// Writes num_rays() unit vectors around `axis`, the pattern turned by `turn_rad` about it. Neighbouring beams turn
  /// theirs differently, so that no direction is always missed.
  void spread(const Vec3f& axis, float turn_rad, Vec3f* directions) const;

 private:
  struct Offset {
    float along_u, along_v;  ///< tangents of the angles from the axis
  };
  std::vector<Offset> offsets_;
};

}  // namespace voxnav_simulation
