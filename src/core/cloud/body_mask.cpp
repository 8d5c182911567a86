// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/cloud/body_mask.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "voxnav/cloud/sweep.hpp"

namespace voxnav::cloud {
namespace {

constexpr std::size_t kBins = std::size_t{BodyMask::kRows} * BodyMask::kColumns;

std::size_t bin_at(int row, int column) {
  return static_cast<std::size_t>(row) * BodyMask::kColumns + static_cast<std::size_t>(column);
}

}  // namespace

std::size_t BodyMask::bin_of(float x, float y, float z) {
  const float elevation = std::atan2(z, std::sqrt(x * x + y * y)) + static_cast<float>(M_PI_2);
  const float azimuth = std::atan2(y, x) + static_cast<float>(M_PI);
  const int row = std::clamp(static_cast<int>(elevation * static_cast<float>(kRows / M_PI)), 0, kRows - 1);
  const int column = std::clamp(static_cast<int>(azimuth * static_cast<float>(kColumns / (2 * M_PI))), 0, kColumns - 1);
  return bin_at(row, column);
}

float BodyMask::farthest_m() const { return *std::max_element(reach_m_.begin(), reach_m_.end()); }

std::size_t BodyMask::num_covered() const {
  return static_cast<std::size_t>(std::count_if(reach_m_.begin(), reach_m_.end(), [](float r) { return r > 0.0F; }));
}

BodyMaskLearner::BodyMaskLearner(const BodyMaskConfig& config)
    : config_(base::checked(config)), last_cloud_(kBins, -1), clouds_near_(kBins, 0), farthest_m_(kBins, 0.0F) {}

void BodyMaskLearner::add(const RawCloudView& cloud) {
  for (const geometry::Vec3f& p : read_sweep(cloud).points) {
    const float range = p.norm();
    if (!(range > 0.0F && range <= config_.max_reach_m)) continue;  // NaN fails too
    const std::size_t bin = BodyMask::bin_of(p.x(), p.y(), p.z());
    if (last_cloud_[bin] != num_clouds_) ++clouds_near_[bin];
    last_cloud_[bin] = num_clouds_;
    farthest_m_[bin] = std::max(farthest_m_[bin], range);
  }
  ++num_clouds_;
}

BodyMask BodyMaskLearner::finish() const {
  if (num_clouds_ == 0) throw std::logic_error("no cloud to learn a body mask from");
  BodyMask out;
  const int rows = BodyMask::kRows, columns = BodyMask::kColumns;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const std::size_t bin = bin_at(row, column);
      if (clouds_near_[bin] < config_.least_share * num_clouds_) continue;
      const float reach = farthest_m_[bin] + static_cast<float>(config_.margin_m);
      for (int r = std::max(row - 1, 0); r <= std::min(row + 1, rows - 1); ++r) {
        for (int c = column - 1; c <= column + 1; ++c) {
          float& masked = out.reach_m_[bin_at(r, (c + columns) % columns)];
          masked = std::max(masked, reach);
        }
      }
    }
  }
  return out;
}

}  // namespace voxnav::cloud
