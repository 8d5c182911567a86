// SPDX-License-Identifier: BSD-3-Clause
#include "cloud/time_sample.hpp"

#include <algorithm>
#include <bitset>
#include <cmath>
#include <iterator>

namespace voxnav::cloud {
namespace {

constexpr std::size_t kDirections = 36;
constexpr double kShare = 0.9;
/// Other times belong to the same sweep if they are nearer to that span than this share of it.
constexpr double kMargin = 0.2;

/// Returns the index at which the shortest span of `count` sorted numbers begins.
std::size_t densest(const std::vector<double>& sorted, std::size_t count) {
  std::size_t best = 0;
  for (std::size_t i = 0; i + count <= sorted.size(); ++i) {
    if (sorted[i + count - 1] - sorted[i] < sorted[best + count - 1] - sorted[best]) best = i;
  }
  return best;
}

}  // namespace

double difference(double later, double earlier, FieldType type) {
  if (!is_counter(type)) return later - earlier;
  // Counters are exact as doubles, and the smallest of their differences modulo 2^32 is the right one.
  return std::remainder(later - earlier, 4294967296.0);
}

TimeSpread TimeSampler::sample(const RawCloudView& cloud, std::size_t num_points) {
  collect(cloud, num_points);
  TimeSpread out;
  out.num_looked_at = num_returns_;
  out.num_sampled = times_.size();
  out.num_returns = num_looked_at_ == 0 ? 0.0
                                        : static_cast<double>(cloud.num_points()) * static_cast<double>(num_returns_) /
                                              static_cast<double>(num_looked_at_);
  // The two directions at the edges of a sector may be covered only in part.
  out.coverage = std::max(0.0, static_cast<double>(num_directions_) - 2.0) / kDirections;
  if (times_.empty()) return out;
  unwrap(cloud.access().time->access);
  std::sort(times_.begin(), times_.end());
  const auto count = static_cast<std::size_t>(std::ceil(kShare * static_cast<double>(times_.size())));
  const std::size_t begin = densest(times_, count);
  const double low = times_[begin], high = times_[begin + count - 1], margin = kMargin * (high - low);
  out.low = *std::lower_bound(times_.begin(), times_.end(), low - margin);
  out.high = *std::prev(std::upper_bound(times_.begin(), times_.end(), high + margin));
  out.median = times_[times_.size() / 2];
  // This comes last, because std::unique() leaves the rest of the numbers undefined.
  out.num_distinct = static_cast<std::size_t>(std::unique(times_.begin(), times_.end()) - times_.begin());
  return out;
}

void TimeSampler::collect(const RawCloudView& cloud, std::size_t num_points) {
  const CloudAccess& access = cloud.access();
  const std::uint64_t total = cloud.num_points();
  // The step is odd, because with a width that is a power of two an even step would always read the same columns.
  const std::uint64_t step = std::max<std::uint64_t>(1, total / num_points) | 1U;
  std::bitset<kDirections> seen;
  times_.clear();
  num_looked_at_ = num_returns_ = 0;
  for (std::uint64_t i = 0; i < total; i += step) {
    const std::uint8_t* point = cloud.row(static_cast<std::uint32_t>(i / cloud.width())) +
                                static_cast<std::size_t>(i % cloud.width()) * cloud.point_step();
    const float x = read_float(point, access.x), y = read_float(point, access.y), z = read_float(point, access.z);
    ++num_looked_at_;
    if (!std::isfinite(x) || !std::isfinite(y) || !std::isfinite(z) || (x == 0.0F && y == 0.0F && z == 0.0F)) continue;
    ++num_returns_;
    const double turn = std::atan2(y, x) / (2.0 * M_PI) + 0.5;
    seen.set(std::min(static_cast<std::size_t>(turn * kDirections), kDirections - 1));
    const double time = read_number(point, access.time->access);
    if (std::isfinite(time)) times_.push_back(time);
  }
  num_directions_ = seen.count();
}

/// Makes counters that overflowed within the sweep continuous, by their differences from one of the majority.
void TimeSampler::unwrap(const FieldAccess& time) {
  if (!is_counter(time.type)) return;
  const auto middle = times_.begin() + static_cast<std::ptrdiff_t>(times_.size() / 2);
  std::nth_element(times_.begin(), middle, times_.end());
  const double pivot = *middle;
  for (double& value : times_) value = pivot + difference(value, pivot, time.type);
}

}  // namespace voxnav::cloud
