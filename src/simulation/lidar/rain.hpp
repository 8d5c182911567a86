// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "voxnav_simulation/lidar_config.hpp"

namespace voxnav_simulation {

/// Raindrops that return beams, and the light that rain takes away. The number of drops N(> D) per volume is that of
/// Marshall and Palmer, "The distribution of raindrops with size", Journal of Meteorology 1948: 8000 / L exp(-L D) per
/// cubic metre, L = 4.1 R^-0.21 per millimetre at a rain rate R in mm/h. A drop of diameter D under a footprint of
/// diameter B returns the share 0.02 (D / B)^2 of the light, as in Kilic et al., "Lidar light scattering augmentation
/// (LISA)", arXiv 2107.07004, section 3; so only near drops are seen, where footprints are small. Attenuation is 1.076
/// R^0.67 dB/km, Recommendation ITU-R P.1814. Drops fall metres between two scans: each scan has others.
class Rain {
 public:
  explicit Rain(const LidarConfig& config);

  struct Drop {
    float range_m;
    float power;  ///< photons that would return from a range of 1 m
  };
  bool is_falling() const { return !seen_drops_.empty(); }
  /// Returns the first drop that a beam can see, or nothing when there is none before the end of the table.
  /// @param u, v  independent numbers, evenly distributed in [0, 1)
  std::optional<Drop> first_drop(float u, float v) const;
  /// Share of the light that comes back from a range.
  float transmission(float range_m) const;

 private:
  double footprint_m(double range_m) const;
  double least_diameter_m(double range_m) const;

  LidarConfig config_;
  double mean_diameter_m_ = 0.0;
  std::vector<double> seen_drops_;  ///< expected number of drops that a beam sees up to each step of range
};

}  // namespace voxnav_simulation
