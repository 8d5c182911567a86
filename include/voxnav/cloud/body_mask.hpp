// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "voxnav/base/config.hpp"
#include "voxnav/cloud/cloud_layout.hpp"

namespace voxnav::cloud {

/// The reach of the UAV's own parts in each direction of the sensor, on a grid of 2 x 2 degrees. Frame L.
class BodyMask {
 public:
  static constexpr int kRows = 90, kColumns = 180;

  /// Makes a mask without any part.
  BodyMask() : reach_m_(std::size_t{kRows} * kColumns, 0.0F) {}
  bool covers(float x, float y, float z) const {
    const float reach = reach_m_[bin_of(x, y, z)];
    return x * x + y * y + z * z <= reach * reach;
  }
  /// Largest reach of all directions [m]; 0 = nothing is masked.
  float farthest_m() const;
  std::size_t num_covered() const;
  static std::size_t bin_of(float x, float y, float z);

 private:
  friend class BodyMaskLearner;
  std::vector<float> reach_m_;
};

struct BodyMaskConfig {
  double max_reach_m = 1.0;
  double margin_m = 0.05;
  double least_share = 0.8;
  int num_clouds = 30;

  template <class V>
  static void fields(V&& v) {
    using C = BodyMaskConfig;
    v("max_reach_m", &C::max_reach_m, base::in(0.05, 10), "m", "no part of the UAV is farther from the sensor");
    v("margin_m", &C::margin_m, base::in(0, 1), "m", "distance masked beyond the farthest return of a direction");
    v("least_share", &C::least_share, base::in(0.1, 1), "", "share of the clouds that must show a part in a direction");
    v("num_clouds", &C::num_clouds, base::in(1, 1000), "", "clouds from which the mask is learned");
  }
};

/// Learns the mask while the UAV stands still on the ground: a direction that returns something near in most scans
/// shows a part of the UAV. Directions where the ground itself is that near are masked too, as far as max_reach_m,
/// which must therefore not be larger than the UAV.
class BodyMaskLearner {
 public:
  /// @throws base::ConfigError
  explicit BodyMaskLearner(const BodyMaskConfig& config);
  void add(const RawCloudView& cloud);
  int num_clouds() const { return num_clouds_; }
  bool is_done() const { return num_clouds_ >= config_.num_clouds; }
  /// Directions around a part are masked as well. @throws std::logic_error when nothing was added
  BodyMask finish() const;

 private:
  BodyMaskConfig config_;
  int num_clouds_ = 0;
  std::vector<int> last_cloud_, clouds_near_;  ///< per bin
  std::vector<float> farthest_m_;
};

}  // namespace voxnav::cloud
