// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav_simulation/lidar_model.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <thread>

#include "own_body.hpp"
#include "voxnav_simulation/random.hpp"

namespace voxnav_simulation {
namespace {

constexpr double kNanosecondsPerSecond = 1e9;
// The share of the reflectance that remains at grazing incidence: ground and bark are rough and have facets that face
// the beam.
constexpr float kRoughShare = 0.15F;

/// Keys of the random numbers of one beam, so that they are independent of each other.
enum Draw : std::uint64_t { kRangeDraw = 1, kSignalDraw = 2, kDropoutDraw = 3, kGhostDraw = 4 };

std::uint64_t draw(std::uint64_t key, Draw which) { return mix_bits(key + which); }

/// Returns a number in [0, 1) from the upper or the lower bits of a draw.
float upper_uniform(std::uint64_t bits) { return static_cast<float>(bits >> 40) * 0x1.0p-24F; }
float lower_uniform(std::uint64_t bits) { return static_cast<float>(bits & 0xFFFFFFU) * 0x1.0p-24F; }

/// Returns a number that is nearly standard normal and never beyond 3.46. It is the sum of four uniform numbers, which
/// costs a fraction of the logarithm that an exact normal number needs.
float normal(std::uint64_t bits) {
  const auto sum =
      static_cast<float>((bits & 0xFFFFU) + ((bits >> 16) & 0xFFFFU) + ((bits >> 32) & 0xFFFFU) + (bits >> 48));
  constexpr float kScale = 1.7320508F / 65536.0F;
  return (sum - 131070.0F) * kScale;
}

}  // namespace

LidarModel::LidarModel(const LidarConfig& config, std::uint64_t seed)
    : config_(voxnav::base::checked(config)), seed_(mix_bits(seed)) {
  for (const double e : config_.elevations_rad()) {
    beams_.push_back({static_cast<float>(std::cos(e)), static_cast<float>(std::sin(e))});
  }
  const double azimuth = config_.sun_azimuth_rad, elevation = config_.sun_elevation_rad;
  sun_W_ = Vec3f(static_cast<float>(std::cos(elevation) * std::cos(azimuth)),
                 static_cast<float>(std::cos(elevation) * std::sin(azimuth)), static_cast<float>(std::sin(elevation)));
  // A half angle of pi stands for every beam, including one whose cosine was rounded to just below -1.
  cos_sun_half_angle_ =
      config_.sun_half_angle_rad > 3.14 ? -2.0F : static_cast<float>(std::cos(config_.sun_half_angle_rad));
  const OwnBody body(config_);
  for (int column = 0; column < config_.columns; ++column) {
    const double c = std::cos(azimuth_rad(column)), s = std::sin(azimuth_rad(column));
    for (const Beam& b : beams_) {
      body_ranges_m_.push_back(
          static_cast<float>(body.range_m({b.cos_elevation * c, b.cos_elevation * s, b.sin_elevation})));
    }
  }
}

std::int64_t LidarModel::sweep_ns() const { return std::llround(kNanosecondsPerSecond / config_.rate_hz); }

std::uint32_t LidarModel::column_time_ns(int column) const {
  return static_cast<std::uint32_t>(sweep_ns() * column / config_.columns);
}

double LidarModel::azimuth_rad(int column) const { return M_PI * (1.0 - 2.0 * column / config_.columns); }

LidarScan LidarModel::scan(const Scene& scene, const std::vector<Pose>& T_W_L, std::uint64_t scan_index) const {
  if (T_W_L.size() != static_cast<std::size_t>(config_.columns)) {
    throw std::invalid_argument("a scan needs one pose per column");
  }
  LidarScan out;
  out.rows = rows();
  out.columns = config_.columns;
  const std::size_t pixels = beams_.size() * static_cast<std::size_t>(config_.columns);
  out.points.assign(pixels, {0, 0, 0, 0});
  out.ranges_m.assign(pixels, 0.0F);
  out.reflectivity.assign(pixels, 0.0F);
  out.labels.assign(pixels, kLabelNone);
  for (int column = 0; column < out.columns; ++column) out.column_times_ns.push_back(column_time_ns(column));
  const std::uint64_t scan_key = mix_bits(seed_ ^ mix_bits(scan_index));
  std::vector<std::thread> helpers;
  const auto first_of = [&](int part) { return out.columns * part / config_.num_threads; };
  for (int part = 1; part < config_.num_threads; ++part) {
    helpers.emplace_back([&, part] { scan_columns(scene, T_W_L, scan_key, first_of(part), first_of(part + 1), &out); });
  }
  scan_columns(scene, T_W_L, scan_key, 0, first_of(1), &out);
  for (std::thread& helper : helpers) helper.join();
  return out;
}

void LidarModel::scan_columns(const Scene& scene, const std::vector<Pose>& T_W_L, std::uint64_t scan_key, int first,
                              int last, LidarScan* out) const {
  std::vector<Vec3f> directions(beams_.size());
  std::vector<Hit> hits(beams_.size());
  for (int column = first; column < last; ++column) {
    const auto c = static_cast<float>(std::cos(azimuth_rad(column)));
    const auto s = static_cast<float>(std::sin(azimuth_rad(column)));
    const Eigen::Matrix3f R = T_W_L[column].linear().cast<float>();
    const Vec3f forward_W = R * Vec3f(c, s, 0.0F), up_W = R.col(2);
    for (std::size_t i = 0; i < beams_.size(); ++i) {
      directions[i] = beams_[i].cos_elevation * forward_W + beams_[i].sin_elevation * up_W;
    }
    scene.cast(T_W_L[column].translation().cast<float>(), directions.data(), directions.size(),
               static_cast<float>(config_.max_range_m), hits.data());
    for (std::size_t i = 0; i < beams_.size(); ++i) {
      const std::uint64_t cell = column * beams_.size() + i;
      const bool is_towards_sun = directions[i].dot(sun_W_) >= cos_sun_half_angle_;
      const Return measured = measure(hits[i], body_ranges_m_[cell], is_towards_sun, mix_bits(scan_key + 16 * cell));
      const Beam& b = beams_[i];
      store(measured, out->index(static_cast<int>(i), column),
            {b.cos_elevation * c, b.cos_elevation * s, b.sin_elevation}, out);
    }
  }
}

LidarModel::Return LidarModel::measure(const Hit& hit, float body_range_m, bool is_towards_sun,
                                       std::uint64_t key) const {
  constexpr Return kNothing{0.0F, 0.0F, kLabelNone};
  const bool is_body = body_range_m < hit.range_m;
  const float true_range = is_body ? body_range_m : hit.range_m;
  if (is_towards_sun && config_.ghost_ratio > 0.0) {
    const std::uint64_t bits = draw(key, kGhostDraw);
    const auto low = static_cast<float>(config_.min_range_m), high = static_cast<float>(config_.ghost_max_range_m);
    const float range = low + (high - low) * lower_uniform(mix_bits(bits));
    if (upper_uniform(bits) < static_cast<float>(config_.ghost_ratio) && range < true_range) {
      return {range, static_cast<float>(config_.ghost_intensity_max) * lower_uniform(bits), kLabelGhost};
    }
  }
  if (!std::isfinite(true_range)) return kNothing;
  const float range = true_range + static_cast<float>(config_.range_noise_m) * normal(draw(key, kRangeDraw));
  if (range < static_cast<float>(config_.min_range_m) || range > static_cast<float>(config_.max_range_m))
    return kNothing;
  if (upper_uniform(draw(key, kDropoutDraw)) < static_cast<float>(config_.dropout_ratio)) return kNothing;
  const auto reflectance =
      static_cast<float>(is_body ? config_.body_reflectance : material_of(hit.surface_class).reflectance);
  const float signal = signal_of(reflectance, is_body ? 1.0F : hit.cos_incidence, true_range, key);
  if (signal < static_cast<float>(config_.min_signal)) return kNothing;
  return {range, signal, is_body ? kLabelOwnBody : static_cast<std::uint8_t>(hit.surface_class)};
}

float LidarModel::signal_of(float reflectance, float cos_incidence, float range_m, std::uint64_t key) const {
  const float facing = kRoughShare + (1.0F - kRoughShare) * cos_incidence;
  const float ideal = static_cast<float>(config_.signal_scale) * reflectance * facing / (range_m * range_m);
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

std::vector<Pose> poses_between(const Pose& T_W_L_start, const Pose& T_W_L_end, int columns) {
  std::vector<Pose> out;
  for (int i = 0; i < columns; ++i) {
    out.push_back(voxnav::geometry::interpolate(T_W_L_start, T_W_L_end, static_cast<double>(i) / columns));
  }
  return out;
}

}  // namespace voxnav_simulation
