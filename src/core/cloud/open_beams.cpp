// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/cloud/open_beams.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace voxnav::cloud {
namespace {

constexpr double kTwoPi = 6.283185307179586;
/// Rows are learnt in turn, and from some of their columns only, because the pattern of a sensor does not change.
constexpr std::uint32_t kRowCycle = 4;
constexpr std::uint32_t kColumnStride = 16;
constexpr double kMinSamples = 8.0;
constexpr double kMaxSamples = 4096.0;
/// The least length of the mean of unit vectors for which their direction is known, which allows 2 degrees of scatter.
constexpr double kMinConcentration = 0.9993;
constexpr double kMaxElevationScatter_rad = 0.02;
constexpr double kMaxLineError_rad = 0.03;
constexpr int kMinRowsForLine = 8;
/// Sensors with staggered beams repeat their azimuths after this many rows.
constexpr int kStaggerPeriod = 4;

using geometry::Vec3f;

Vec3f position(const std::uint8_t* point, const CloudAccess& a) {
  return {read_float(point, a.x), read_float(point, a.y), read_float(point, a.z)};
}

bool is_return(const Vec3f& p) { return p.allFinite() && p.squaredNorm() > 0.0F; }

}  // namespace

OpenBeams::OpenBeams(const OpenBeamsConfig& config) : config_(base::checked(config)) {}

const std::vector<Vec3f>& OpenBeams::find(const RawCloudView& cloud) {
  directions_.clear();
  if (!cloud.is_organised() || cloud.width() < kColumnStride) return directions_;
  if (cloud.height() != rows_ || cloud.width() != columns_) reset(cloud.height(), cloud.width());
  if (cloud.access().beam) {
    mark_returns(cloud);
    find_told(cloud);
    return directions_;
  }
  learn(cloud);
  if (!choose_turn()) return directions_;
  spread_to_all_rows();
  mark_returns(cloud);
  const double step_rad = (turn_ == 0 ? kTwoPi : -kTwoPi) / columns_;
  for (int r = 0; r < static_cast<int>(rows_); r += config_.row_step) {
    const auto& beam = beams_[static_cast<std::size_t>(r)];
    if (!beam) continue;
    const double up = std::sin(beam->elevation_rad), across = std::cos(beam->elevation_rad);
    for (int c = 0; c < static_cast<int>(columns_); c += config_.column_step) {
      if (!is_open(r, c)) continue;
      const double azimuth = beam->azimuth_rad + step_rad * c;
      directions_.emplace_back(
          geometry::Vec3(across * std::cos(azimuth), across * std::sin(azimuth), up).cast<float>());
    }
  }
  return directions_;
}

void OpenBeams::find_told(const RawCloudView& cloud) {
  const std::array<FieldAccess, 3>& beam = *cloud.access().beam;
  for (int r = 0; r < static_cast<int>(rows_); r += config_.row_step) {
    for (int c = 0; c < static_cast<int>(columns_); c += config_.column_step) {
      if (!is_open(r, c)) continue;
      const std::uint8_t* point =
          cloud.row(static_cast<std::uint32_t>(r)) + static_cast<std::size_t>(c) * cloud.point_step();
      const Vec3f direction(read_float(point, beam[0]), read_float(point, beam[1]), read_float(point, beam[2]));
      if (direction.allFinite() && !direction.isZero(0.0F)) directions_.push_back(direction.normalized());
    }
  }
}

void OpenBeams::reset(std::uint32_t rows, std::uint32_t columns) {
  rows_ = rows;
  columns_ = columns;
  seen_.assign(rows, {});
  beams_.assign(rows, std::nullopt);
  is_near_return_.assign(static_cast<std::size_t>(rows) * columns, 0);
}

void OpenBeams::learn(const RawCloudView& cloud) {
  phase_ = (phase_ + 1) % kRowCycle;
  for (std::uint32_t r = phase_; r < rows_; r += kRowCycle) {
    Row& row = seen_[r];
    if (row.count > kMaxSamples) {
      for (auto* sum : {&row.elevation_rad, &row.elevation_sq, &row.count}) *sum *= 0.5;
      for (auto& sum : row.azimuth) sum *= 0.5;
    }
    for (std::uint32_t c = phase_; c < columns_; c += kColumnStride) {
      const Vec3f p = position(cloud.row(r) + std::size_t{c} * cloud.point_step(), cloud.access());
      if (!is_return(p)) continue;
      const double azimuth = std::atan2(p.y(), p.x()), turned = kTwoPi * c / columns_;
      const double elevation = std::atan2(p.z(), std::hypot(p.x(), p.y()));
      row.azimuth[0] += std::polar(1.0, azimuth - turned);
      row.azimuth[1] += std::polar(1.0, azimuth + turned);
      row.elevation_rad += elevation;
      row.elevation_sq += elevation * elevation;
      row.count += 1.0;
    }
  }
}

/// Decides in which direction the columns turn, by the one with which the azimuths of a row agree.
bool OpenBeams::choose_turn() {
  std::array<int, 2> agreeing{0, 0};
  int known = 0;
  for (const Row& row : seen_) {
    if (row.count < kMinSamples) continue;
    ++known;
    for (int turn : {0, 1}) agreeing[turn] += std::abs(row.azimuth[turn]) / row.count > kMinConcentration;
  }
  turn_ = agreeing[1] > agreeing[0] ? 1 : 0;
  return known >= std::min<int>(kMinRowsForLine, static_cast<int>(rows_)) && 2 * agreeing[turn_] > known;
}

void OpenBeams::spread_to_all_rows() {
  std::vector<std::pair<double, double>> line;  // row, elevation
  std::array<std::complex<double>, kStaggerPeriod + 1> azimuths{};
  for (std::size_t r = 0; r < rows_; ++r) {
    const Row& row = seen_[r];
    beams_[r].reset();
    if (row.count < kMinSamples) continue;
    const double elevation = row.elevation_rad / row.count;
    const double scatter_sq = row.elevation_sq / row.count - elevation * elevation;
    const double concentration = std::abs(row.azimuth[turn_]) / row.count;
    if (scatter_sq > kMaxElevationScatter_rad * kMaxElevationScatter_rad || concentration < kMinConcentration) continue;
    beams_[r] = Beam{elevation, std::arg(row.azimuth[turn_])};
    line.emplace_back(static_cast<double>(r), elevation);
    azimuths[r % kStaggerPeriod] += row.azimuth[turn_] / row.count;
    azimuths[kStaggerPeriod] += row.azimuth[turn_] / row.count;
  }
  if (static_cast<int>(line.size()) < kMinRowsForLine) return;
  double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (const auto& [x, y] : line) n += 1, sx += x, sy += y, sxx += x * x, sxy += x * y;
  const double slope = (n * sxy - sx * sy) / (n * sxx - sx * sx), offset = (sy - slope * sx) / n;
  for (const auto& [x, y] : line) {
    if (std::abs(offset + slope * x - y) > kMaxLineError_rad) return;  // rows are not evenly spaced
  }
  for (std::size_t r = 0; r < rows_; ++r) {
    const auto& same = azimuths[r % kStaggerPeriod];
    const double azimuth = std::arg(std::abs(same) > 0.0 ? same : azimuths[kStaggerPeriod]);
    if (!beams_[r]) beams_[r] = Beam{offset + slope * static_cast<double>(r), azimuth};
  }
}

void OpenBeams::mark_returns(const RawCloudView& cloud) {
  const int width = static_cast<int>(columns_), margin = std::min(config_.margin_columns, width - 1);
  std::fill(is_near_return_.begin(), is_near_return_.end(), 0);
  for (std::uint32_t r = 0; r < rows_; ++r) {
    std::uint8_t* marks = is_near_return_.data() + static_cast<std::size_t>(r) * columns_;
    int free_from = -margin;  // marks are set up to here, from the last columns on, as columns run around
    for (int c = 0; c < width; ++c) {
      const std::uint8_t* point = cloud.row(r) + static_cast<std::size_t>(c) * cloud.point_step();
      if (!is_return(position(point, cloud.access()))) continue;
      for (int k = std::max(c - margin, free_from); k <= c + margin; ++k) marks[(k + width) % width] = 1;
      free_from = c + margin + 1;
    }
  }
}

bool OpenBeams::is_open(int row, int column) const {
  const int first = std::max(0, row - config_.margin_rows);
  const int last = std::min(static_cast<int>(rows_) - 1, row + config_.margin_rows);
  for (int r = first; r <= last; ++r) {
    if (is_near_return_[static_cast<std::size_t>(r) * columns_ + static_cast<std::size_t>(column)]) return false;
  }
  return true;
}

}  // namespace voxnav::cloud
