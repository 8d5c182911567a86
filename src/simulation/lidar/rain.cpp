// SPDX-License-Identifier: BSD-3-Clause
#include "rain.hpp"

#include <algorithm>
#include <cmath>

namespace voxnav_simulation {
namespace {

constexpr double kDropsPerM4 = 8.0e6;      // Marshall and Palmer's 8000 per cubic metre and millimetre of diameter
constexpr double kExitDiameter_m = 0.005;  // of the OS0's beam (data sheet)
constexpr double kDropReflectance = 0.02;  // of water at normal incidence: ((1.33 - 1) / (1.33 + 1))^2
constexpr double kStep_m = 0.05;
constexpr double kFarthestDrop_m = 30.0;
constexpr double kDecibelPerNeper = 4.342944819;

}  // namespace

Rain::Rain(const LidarConfig& config) : config_(config) {
  if (config.rain_mm_per_h <= 0.0) return;
  mean_diameter_m_ = 1e-3 * std::pow(config.rain_mm_per_h, 0.21) / 4.1;
  const double drops_per_m3 = kDropsPerM4 * mean_diameter_m_;
  double sum = 0.0;
  const auto num_steps = static_cast<int>(std::ceil((kFarthestDrop_m - config.min_range_m) / kStep_m));
  for (int step = 0; step < num_steps; ++step) {
    seen_drops_.push_back(sum);
    const double middle = config.min_range_m + (step + 0.5) * kStep_m, footprint = footprint_m(middle);
    sum += kStep_m * 0.25 * M_PI * footprint * footprint * drops_per_m3 *
           std::exp(-least_diameter_m(middle) / mean_diameter_m_);
  }
}

double Rain::footprint_m(double range_m) const { return kExitDiameter_m + config_.beam_divergence_rad * range_m; }

double Rain::least_diameter_m(double range_m) const {
  return footprint_m(range_m) * range_m * std::sqrt(config_.min_signal / (config_.signal_scale * kDropReflectance));
}

std::optional<Rain::Drop> Rain::first_drop(float u, float v) const {
  // The number of drops before a range is Poisson distributed, so the first lies where the expected number is this.
  const double expected = -std::log1p(-static_cast<double>(u));
  if (!is_falling() || expected >= seen_drops_.back()) return std::nullopt;
  const auto step = std::upper_bound(seen_drops_.begin(), seen_drops_.end(), expected) - seen_drops_.begin();
  const double low = seen_drops_[static_cast<std::size_t>(step) - 1],
               high = seen_drops_[static_cast<std::size_t>(step)];
  const double range =
      config_.min_range_m + kStep_m * (static_cast<double>(step) - 1.0 + (expected - low) / (high - low));
  const double diameter = least_diameter_m(range) - mean_diameter_m_ * std::log1p(-static_cast<double>(v));
  const double covered = std::min(1.0, std::pow(diameter / footprint_m(range), 2));
  return Drop{static_cast<float>(range), static_cast<float>(config_.signal_scale * kDropReflectance * covered)};
}

float Rain::transmission(float range_m) const {
  if (!is_falling()) return 1.0F;
  const double decibel = 2.0 * 1.076e-3 * std::pow(config_.rain_mm_per_h, 0.67) * static_cast<double>(range_m);
  return static_cast<float>(std::exp(-decibel / kDecibelPerNeper));
}

}  // namespace voxnav_simulation
