// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "cloud/time_sample.hpp"
#include "voxnav/base/words.hpp"
#include "voxnav/cloud/point_times.hpp"

namespace voxnav::cloud {

/// The state that PointTimes keeps from cloud to cloud, and the steps of its decision.
class PointTimes::Impl {
 public:
  CloudTimes judge(const RawCloudView& cloud);
  const TimesReport& report() const { return report_; }

 private:
  /// The last few steps between stamps.
  class StampSteps {
   public:
    void add(base::StampNs stamp_ns);
    std::optional<base::StampNs> median_ns() const;

   private:
    std::optional<base::StampNs> last_ns_;
    std::vector<base::StampNs> steps_ns_;
  };

  void begin(const TimeField& field);
  void consider_all();
  double longest_sweep_s() const;
  bool is_possible(TimeUnit unit, const TimeSpread& spread) const;
  bool choose_unit(const TimeSpread& spread);
  bool consider(const TimeSpread& spread);
  void take(TimeUnit unit, TimesState state);
  TimeZero zero_of(const TimeSpread& spread, double stamp_ticks);
  CloudTimes times_of(const TimeSpread& spread, base::StampNs stamp_ns);
  void explain(const TimeSpread& spread);

  TimesReport report_;
  StampSteps steps_;
  TimeSampler sampler_;
  std::vector<TimeUnit> candidates_;  // the units that no cloud contradicted, largest first
  struct Usual {
    TimeUnit unit = TimeUnit::kNanosecond;
    TimeZero zero = TimeZero::kStamp;
  } usual_;
  std::optional<TimeZero> zero_;
  std::uint64_t num_considered_ = 0;
  int num_contradictions_ = 0;
  int num_other_zero_ = 0;

  static Usual usual_reading(const TimeField& field);
};

double seconds_of(TimeUnit unit);

}  // namespace voxnav::cloud
