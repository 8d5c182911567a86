// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/cloud/point_times.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "cloud/point_times_impl.hpp"

namespace voxnav::cloud {
namespace {

constexpr double kMaxPointRate_hz = 20e6;
/// The share of the period that a sensor which sees all around takes at least for its sweep.
constexpr double kLeastShare = 0.5;
constexpr double kFastestPeriod_s = 0.05;
/// The longest sweep at the usual 5 to 20 Hz, for the time before stamps show the period, and the longest of any
/// sensor.
constexpr double kUsualSweep_s = 0.25, kMaxSweep_s = 1.05;
/// A sweep may last longer than the step between stamps by this factor and this time, because stamps jitter.
constexpr double kSweepSlack = 1.25, kSweepSlack_s = 0.005;
/// With fewer returns or different times a cloud does not show the unit.
constexpr std::size_t kMinSampled = 16, kMinDistinct = 8;
/// The numbers of points that are read in each cloud before the unit is known, and afterwards.
constexpr std::size_t kManySamples = 2048, kFewSamples = 256;
constexpr std::uint64_t kCloudsToWait = 10;
constexpr int kNumContradictions = 5;
/// The number of clouds in a row with another zero after which the zero is changed.
constexpr int kNumOtherZero = 3;

}  // namespace

double seconds_of(TimeUnit unit) { return std::pow(1e-3, static_cast<int>(unit)); }

void PointTimes::Impl::StampSteps::add(base::StampNs stamp_ns) {
  constexpr base::StampNs kLongest = 5'000'000'000;
  const base::StampNs step_ns = last_ns_ ? stamp_ns - *last_ns_ : 0;
  last_ns_ = stamp_ns;
  if (step_ns <= 0 || step_ns > kLongest) return;
  steps_ns_.push_back(step_ns);
  if (steps_ns_.size() > 9) steps_ns_.erase(steps_ns_.begin());
}

std::optional<base::StampNs> PointTimes::Impl::StampSteps::median_ns() const {
  if (steps_ns_.empty()) return std::nullopt;
  std::vector<base::StampNs> sorted = steps_ns_;
  std::sort(sorted.begin(), sorted.end());
  return sorted[sorted.size() / 2];
}

bool PointTimes::Impl::is_possible(TimeUnit unit, const TimeSpread& spread) const {
  const double span_s = spread.span() * seconds_of(unit);
  const double period_s = report_.sweep_period_ns ? base::to_seconds(*report_.sweep_period_ns) : kFastestPeriod_s;
  const double least_s = std::max(spread.num_returns / kMaxPointRate_hz,
                                  kLeastShare * spread.coverage * std::min(period_s, kFastestPeriod_s));
  return spread.num_distinct >= kMinDistinct && span_s >= least_s && span_s <= longest_sweep_s();
}

double PointTimes::Impl::longest_sweep_s() const {
  if (!report_.sweep_period_ns) return kUsualSweep_s;
  return std::min(kMaxSweep_s, kSweepSlack * base::to_seconds(*report_.sweep_period_ns) + kSweepSlack_s);
}

CloudTimes PointTimes::Impl::judge(const RawCloudView& cloud) {
  if (cloud.num_points() == 0) return {};
  const auto& field = cloud.access().time;
  steps_.add(cloud.stamp_ns());
  report_.sweep_period_ns = steps_.median_ns();
  if (!field) return {};
  if (field->name != report_.field || field->access.type != report_.type) begin(*field);
  ++report_.num_clouds;
  const bool is_settled = report_.state == TimesState::kMeasured;
  const TimeSpread spread = sampler_.sample(cloud, is_settled ? kFewSamples : kManySamples);
  const bool is_usable = choose_unit(spread);
  if (!is_usable) ++report_.num_clouds_untimed;
  CloudTimes out;
  if (is_usable) out = times_of(spread, cloud.stamp_ns());
  explain(spread);
  return out;
}

void PointTimes::Impl::begin(const TimeField& field) {
  report_.state = TimesState::kUndecided;
  report_.field = field.name;
  report_.type = field.access.type;
  report_.sweep_span_ns = 0;
  usual_ = usual_reading(field);
  zero_.reset();
  consider_all();
}

void PointTimes::Impl::consider_all() {
  candidates_ = base::all_values<TimeUnit>();
  num_considered_ = 0;
  num_contradictions_ = 0;
}

/// Chooses the unit by one more cloud. @return true if the unit of this cloud is known
bool PointTimes::Impl::choose_unit(const TimeSpread& spread) {
  const bool is_known = report_.state == TimesState::kMeasured || report_.state == TimesState::kByName;
  if (spread.num_looked_at < kMinSampled) {
    // So few points do not show the unit, and a wrong unit does little harm to them, so name and type decide.
    if (num_considered_ == 0) take(usual_.unit, TimesState::kByName);
    return is_known || num_considered_ == 0;
  }
  if (is_known && spread.num_distinct < kMinDistinct) return true;  // so few directions contradict no unit
  if (report_.state == TimesState::kMeasured) {
    if (is_possible(report_.unit, spread)) {
      num_contradictions_ = 0;
      return true;
    }
    if (++num_contradictions_ < kNumContradictions) return false;
    consider_all();
  }
  return consider(spread);
}

bool PointTimes::Impl::consider(const TimeSpread& spread) {
  std::vector<TimeUnit> possible;
  for (const TimeUnit unit : base::all_values<TimeUnit>()) {
    if (is_possible(unit, spread)) possible.push_back(unit);
  }
  ++num_considered_;
  if (possible.empty()) {
    if (++num_contradictions_ >= kNumContradictions || num_considered_ == 1) report_.state = TimesState::kUndecided;
    return false;
  }
  std::vector<TimeUnit> both;
  std::set_intersection(candidates_.begin(), candidates_.end(), possible.begin(), possible.end(),
                        std::back_inserter(both));
  candidates_ = both.empty() ? possible : both;
  const bool has_usual = std::find(candidates_.begin(), candidates_.end(), usual_.unit) != candidates_.end();
  report_.state = TimesState::kUndecided;
  const bool is_only_one = candidates_.size() == 1;
  if (!is_only_one && has_usual) {
    take(usual_.unit, TimesState::kByName);
  } else if (is_only_one || num_considered_ >= kCloudsToWait) {
    take(candidates_.front(), TimesState::kMeasured);  // the largest unit, so that points fill most of the period
  }
  return report_.state != TimesState::kUndecided;
}

void PointTimes::Impl::take(TimeUnit unit, TimesState state) {
  report_.unit = unit;
  report_.state = state;
}

TimeZero PointTimes::Impl::zero_of(const TimeSpread& spread, double stamp_ticks) {
  if (spread.num_sampled == 0) return zero_.value_or(usual_.zero);
  // The stamp may be that of the start or the end of the sweep, or of its arrival.
  const double longest = longest_sweep_s() / seconds_of(report_.unit);
  const auto is_around_stamp = [&](double after) { return after >= -1.5 * longest && after <= 1.1 * longest; };
  const bool is_near_stamp = is_around_stamp(difference(spread.median, 0.0, report_.type));
  const bool is_near_epoch = !is_counter(report_.type) && is_around_stamp(spread.median - stamp_ticks);
  TimeZero zero = is_near_stamp ? TimeZero::kStamp : TimeZero::kSensorClock;
  if (is_near_epoch) zero = TimeZero::kRosTime;
  // In simulations the first stamps are near the epoch, so that both zeros are possible.
  if (is_near_stamp && is_near_epoch) zero = zero_.value_or(usual_.zero);
  if (!zero_) zero_ = zero;
  num_other_zero_ = zero == *zero_ ? 0 : num_other_zero_ + 1;
  if (num_other_zero_ >= kNumOtherZero) zero_ = zero;
  // A cloud that does not fit the zero is read as one of a clock of the sensor, which keeps the order of its points.
  return zero == *zero_ ? zero : TimeZero::kSensorClock;
}

CloudTimes PointTimes::Impl::times_of(const TimeSpread& spread, base::StampNs stamp_ns) {
  const double tick_s = seconds_of(report_.unit);
  const double stamp_ticks = base::to_seconds(stamp_ns) / tick_s;
  const TimeZero zero = zero_of(spread, stamp_ticks);
  report_.zero = zero_.value_or(zero);
  CloudTimes out;
  out.tick_ns = 1e9 * tick_s;
  if (zero == TimeZero::kRosTime) out.zero = stamp_ticks;
  if (zero == TimeZero::kSensorClock) out.zero = spread.low;
  out.first_ns = -std::llround(1e9 * kMaxSweep_s);
  out.last_ns = -out.first_ns;
  if (spread.num_sampled < kMinSampled) return out;
  // All times of a sweep are within its longest duration of each other.
  const double low_ns = difference(spread.low, out.zero, report_.type) * out.tick_ns;
  const double high_ns = low_ns + spread.span() * out.tick_ns;
  const double reach_ns = 1e9 * std::max(longest_sweep_s(), kSweepSlack * spread.span() * tick_s);
  out.first_ns = std::max(out.first_ns, base::StampNs{std::llround(high_ns - reach_ns)});
  out.last_ns = std::min(out.last_ns, base::StampNs{std::llround(low_ns + reach_ns)});
  report_.sweep_span_ns = std::max(report_.sweep_span_ns, base::StampNs{std::llround(spread.span() * out.tick_ns)});
  report_.is_stamp_at_end = low_ns + high_ns < 0.0;
  return out;
}

PointTimes::PointTimes() : impl_(std::make_unique<Impl>()) {}
PointTimes::~PointTimes() = default;
PointTimes::PointTimes(PointTimes&&) noexcept = default;
PointTimes& PointTimes::operator=(PointTimes&&) noexcept = default;

CloudTimes PointTimes::judge(const RawCloudView& cloud) { return impl_->judge(cloud); }
const TimesReport& PointTimes::report() const { return impl_->report(); }

std::optional<CloudTimes> times_of_filtered(const RawCloudView& cloud) {
  const auto& field = cloud.access().time;
  if (!field || field->name != "t" || field->access.type != FieldType::kUint32) return std::nullopt;
  return CloudTimes{1.0, 0.0, 0, 1'000'000'000};
}

}  // namespace voxnav::cloud
