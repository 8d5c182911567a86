// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "beam_draws.hpp"
#include "beam_footprint.hpp"
#include "echoes.hpp"
#include "rain.hpp"
#include "voxnav_simulation/lidar_model.hpp"

namespace voxnav_simulation {
namespace {

// Ground and bark are rough: a beam that grazes them meets facets that face it.
constexpr float kRoughShare = 0.15F;

}  // namespace

LidarModel::Target LidarModel::target_of(const Hit* hits, float body_range_m) const {
  std::array<RayReturn, LidarConfig::kMostFootprintRays> returns;
  std::size_t num_returns = 0;
  const auto scale = static_cast<float>(config_.signal_scale);
  for (const Hit* hit = hits; hit != hits + footprint_->num_rays(); ++hit) {
    if (!hit->is_hit()) continue;
    const auto reflectance = static_cast<float>(material_of(hit->surface_class).reflectance);
    const float facing = kRoughShare + (1.0F - kRoughShare) * hit->cos_incidence;
    returns[num_returns++] = {hit->range_m, scale * reflectance * facing, hit->surface_class};
  }
  const auto echo = strongest_echo(returns.data(), num_returns, footprint_->num_rays(),
                                   static_cast<float>(config_.echo_separation_m));
  if (std::isfinite(body_range_m) && (!echo || body_range_m < echo->range_m)) {
    return {body_range_m, scale * static_cast<float>(config_.body_reflectance), kLabelOwnBody};
  }
  if (!echo) return {std::numeric_limits<float>::infinity(), 0.0F, kLabelNone};
  return {echo->range_m, echo->power, static_cast<std::uint8_t>(echo->surface_class)};
}

LidarModel::Target LidarModel::seen_through_rain(const Target& target, std::uint64_t key) const {
  if (!rain_->is_falling()) return target;
  Target dimmed = target;
  if (target.label != kLabelNone) dimmed.power *= rain_->transmission(target.range_m);
  const std::uint64_t bits = draw(key, kRainDraw);
  const auto drop = rain_->first_drop(upper_uniform(bits), lower_uniform(bits));
  if (!drop || drop->range_m >= target.range_m) return dimmed;
  const float of_drop = drop->power / (drop->range_m * drop->range_m);
  const bool is_stronger = target.label == kLabelNone || of_drop > dimmed.power / (dimmed.range_m * dimmed.range_m);
  return is_stronger ? Target{drop->range_m, drop->power, kLabelRain} : dimmed;
}

LidarModel::Return LidarModel::measure(const Target& target, bool is_towards_sun, std::uint64_t key) const {
  constexpr Return kNothing{0.0F, 0.0F, kLabelNone};
  const auto low = static_cast<float>(config_.min_range_m);
  const auto false_range = [&](std::uint64_t bits, double farthest_m) {
    return low + (static_cast<float>(farthest_m) - low) * lower_uniform(mix_bits(bits));
  };
  if (is_towards_sun && config_.ghost_ratio > 0.0) {
    const std::uint64_t bits = draw(key, kGhostDraw);
    const float range = false_range(bits, config_.ghost_max_range_m);
    if (upper_uniform(bits) < static_cast<float>(config_.ghost_ratio) && range < target.range_m) {
      return {range, static_cast<float>(config_.ghost_intensity_max) * lower_uniform(bits), kLabelGhost};
    }
  }
  if (config_.speckle_ratio > 0.0) {
    const std::uint64_t bits = draw(key, kSpeckleDraw);
    const float range = false_range(bits, config_.speckle_max_range_m);
    if (upper_uniform(bits) < static_cast<float>(config_.speckle_ratio) && range < target.range_m) {
      return {range, static_cast<float>(config_.min_signal) * (1.0F + lower_uniform(bits)), kLabelSpeckle};
    }
  }
  if (target.label == kLabelNone) return kNothing;
  const float range = target.range_m + static_cast<float>(config_.range_noise_m) * normal(draw(key, kRangeDraw));
  if (range < low || range > static_cast<float>(config_.max_range_m)) return kNothing;
  if (upper_uniform(draw(key, kDropoutDraw)) < static_cast<float>(config_.dropout_ratio)) return kNothing;
  const float signal = signal_of(target, key);
  if (signal < static_cast<float>(config_.min_signal)) return kNothing;
  return {range, signal, target.label};
}

float LidarModel::signal_of(const Target& target, std::uint64_t key) const {
  const float ideal = target.power / (target.range_m * target.range_m);
  const float saturated = ideal / (1.0F + ideal / static_cast<float>(config_.signal_saturation));
  const float noise = static_cast<float>(config_.signal_noise_ratio) * normal(draw(key, kSignalDraw));
  return std::max(0.0F, saturated * (1.0F + noise));
}

void LidarModel::store(const Return& measured, std::size_t pixel, const Vec3f& direction_L, LidarScan* out) const {
  if (measured.label == kLabelNone) return;
  const Vec3f p = measured.range_m * direction_L;
  out->points[pixel] = {p.x(), p.y(), p.z(), measured.signal};
  out->ranges_m[pixel] = measured.range_m;
  out->labels[pixel] = measured.label;
  const float albedo = measured.signal * measured.range_m * measured.range_m / static_cast<float>(config_.signal_scale);
  out->reflectivity[pixel] = std::min(255.0F, 255.0F * albedo);
}

}  // namespace voxnav_simulation
