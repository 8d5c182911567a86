// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav_simulation/lidar_model.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <thread>

#include "beam_draws.hpp"
#include "beam_footprint.hpp"
#include "own_body.hpp"
#include "rain.hpp"

namespace voxnav_simulation {
namespace {

constexpr double kNanosecondsPerSecond = 1e9;

}  // namespace

/// The beams of one column: the axis of each, and the rays of all footprints with what they met.
struct LidarModel::Footprints {
  std::vector<Vec3f> axes_W, rays_W;
  std::vector<Hit> hits;

  Footprints(std::size_t beams, std::size_t rays_per_beam)
      : axes_W(beams), rays_W(beams * rays_per_beam), hits(beams * rays_per_beam) {}
};

LidarModel::~LidarModel() = default;
LidarModel::LidarModel(LidarModel&&) noexcept = default;
LidarModel& LidarModel::operator=(LidarModel&&) noexcept = default;

LidarModel::LidarModel(const LidarConfig& config, std::uint64_t seed)
    : config_(voxnav::base::checked(config)),
      seed_(mix_bits(seed)),
      footprint_(std::make_unique<BeamFootprint>(config)),
      rain_(std::make_unique<Rain>(config)) {
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
  const Turn turn{mix_bits(seed_ ^ mix_bits(scan_index)), static_cast<std::int64_t>(scan_index) * sweep_ns()};
  std::vector<std::thread> helpers;
  const auto first_of = [&](int part) { return out.columns * part / config_.num_threads; };
  for (int part = 1; part < config_.num_threads; ++part) {
    helpers.emplace_back([&, part] { scan_columns(scene, T_W_L, turn, first_of(part), first_of(part + 1), &out); });
  }
  scan_columns(scene, T_W_L, turn, 0, first_of(1), &out);
  for (std::thread& helper : helpers) helper.join();
  return out;
}

std::uint64_t LidarModel::key_of(std::uint64_t scan_key, int column, std::size_t beam) const {
  return mix_bits(scan_key + kDraws * (static_cast<std::uint64_t>(column) * beams_.size() + beam));
}

void LidarModel::cast_column(const Scene& scene, const Pose& T_W_L, int column, const Turn& turn,
                             Footprints* out) const {
  const auto c = static_cast<float>(std::cos(azimuth_rad(column)));
  const auto s = static_cast<float>(std::sin(azimuth_rad(column)));
  const Eigen::Matrix3f R = T_W_L.linear().cast<float>();
  const Vec3f forward_W = R * Vec3f(c, s, 0.0F), up_W = R.col(2);
  for (std::size_t i = 0; i < beams_.size(); ++i) {
    out->axes_W[i] = beams_[i].cos_elevation * forward_W + beams_[i].sin_elevation * up_W;
    const float twist =
        2.0F * static_cast<float>(M_PI) * upper_uniform(draw(key_of(turn.key, column, i), kFootprintDraw));
    footprint_->spread(out->axes_W[i], twist, out->rays_W.data() + i * footprint_->num_rays());
  }
  scene.cast(T_W_L.translation().cast<float>(), out->rays_W.data(), out->rays_W.size(),
             static_cast<float>(config_.max_range_m), out->hits.data(), turn.start_ns + column_time_ns(column));
}

void LidarModel::scan_columns(const Scene& scene, const std::vector<Pose>& T_W_L, const Turn& turn, int first, int last,
                              LidarScan* out) const {
  Footprints footprints(beams_.size(), footprint_->num_rays());
  for (int column = first; column < last; ++column) {
    cast_column(scene, T_W_L[static_cast<std::size_t>(column)], column, turn, &footprints);
    const auto c = static_cast<float>(std::cos(azimuth_rad(column)));
    const auto s = static_cast<float>(std::sin(azimuth_rad(column)));
    for (std::size_t i = 0; i < beams_.size(); ++i) {
      const std::uint64_t key = key_of(turn.key, column, i);
      const float body_range_m = body_ranges_m_[static_cast<std::size_t>(column) * beams_.size() + i];
      const Target target = target_of(footprints.hits.data() + i * footprint_->num_rays(), body_range_m);
      const bool is_towards_sun = footprints.axes_W[i].dot(sun_W_) >= cos_sun_half_angle_;
      const Return measured = measure(seen_through_rain(target, key), is_towards_sun, key);
      const Beam& b = beams_[i];
      store(measured, out->index(static_cast<int>(i), column),
            {b.cos_elevation * c, b.cos_elevation * s, b.sin_elevation}, out);
    }
  }
}

std::vector<Pose> poses_between(const Pose& T_W_L_start, const Pose& T_W_L_end, int columns) {
  std::vector<Pose> out;
  out.reserve(static_cast<std::size_t>(std::max(columns, 0)));
  for (int i = 0; i < columns; ++i) {
    out.push_back(voxnav::geometry::interpolate(T_W_L_start, T_W_L_end, static_cast<double>(i) / columns));
  }
  return out;
}

}  // namespace voxnav_simulation
