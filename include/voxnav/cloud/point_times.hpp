// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "voxnav/cloud/cloud_layout.hpp"

namespace voxnav::cloud {

/// What one step of a time field lasts.
enum class TimeUnit : std::uint8_t { kSecond, kMillisecond, kMicrosecond, kNanosecond };
constexpr auto words_of(TimeUnit) { return std::array{"s", "ms", "us", "ns"}; }

/// From when a time field counts.
enum class TimeZero : std::uint8_t {
  kStamp,        ///< from the stamp of the cloud, before which times are negative
  kRosTime,      ///< from the same epoch as the stamps
  kSensorClock,  ///< from an epoch of the sensor's own; the first point is taken to be measured at the stamp
};
constexpr auto words_of(TimeZero) { return std::array{"stamp", "ros_time", "sensor_clock"}; }

/// How much is known of a sensor's time field.
enum class TimesState : std::uint8_t {
  kNoField,    ///< clouds have no field for it
  kUndecided,  ///< what the field counts is not known, and it is not used
  kByName,     ///< what its name and type usually mean, which nothing contradicts
  kMeasured,   ///< how long its sweeps last decided it
};
constexpr auto words_of(TimesState) { return std::array{"no_field", "undecided", "by_name", "measured"}; }

/// What is known of a sensor's time field, and how.
struct TimesReport {
  TimesState state = TimesState::kNoField;
  std::string field;  ///< its name; empty when there is none
  FieldType type = FieldType::kFloat32;
  TimeUnit unit = TimeUnit::kNanosecond;         ///< unless undecided
  TimeZero zero = TimeZero::kStamp;              ///< unless undecided
  std::optional<base::StampNs> sweep_period_ns;  ///< median of the steps between stamps; none before the second cloud
  base::StampNs sweep_span_ns = 0;               ///< longest that the points of a cloud took; unless undecided
  bool is_stamp_at_end = false;                  ///< whether the last cloud was stamped when its sweep ended
  std::uint64_t num_clouds = 0;                  ///< with a time field
  std::uint64_t num_clouds_untimed = 0;          ///< whose times were not used
  std::string how;                               ///< a sentence: what it counts and how that was decided, or why not
};

/// What is wrong with the point times of a sensor, a sentence for people; empty when all were used.
std::string problem_of(const TimesReport& report);

/// How the numbers of one cloud become nanoseconds after its stamp: (number - zero) * tick.
struct CloudTimes {
  double tick_ns = 0.0;       ///< 0: its times are not used
  double zero = 0.0;          ///< the number at the stamp
  std::int64_t first_ns = 0;  ///< earlier and later ones are no times of this sweep
  std::int64_t last_ns = 0;
};

/// Finds out what the time field of one sensor counts: its unit, by how long sweeps last against the time between
/// them, and its zero. Drivers of the same field name and type mean different things, so that neither decides alone.
///
/// A sweep takes no longer than the time between stamps (before that is known, a quarter of a second), a sensor
/// measures at most 20 million points a second, and one that sees all around takes at least half of its period (or of
/// 50 ms) for it. Units lie a thousandfold apart, so that in the first cloud of most sensors one of them remains. While
/// several do, the name and type decide between them; where they do not, ten clouds are waited for. Until then, and in
/// clouds that contradict the decision, times are not used, which is counted. Five contradictions in a row decide anew.
/// Deterministic; not thread-safe; O(1) per cloud, as it looks at a sample of the points.
class PointTimes {
 public:
  PointTimes();
  ~PointTimes();
  PointTimes(PointTimes&&) noexcept;
  PointTimes& operator=(PointTimes&&) noexcept;

  /// Takes the next cloud of the sensor into account, and says how its times are read.
  CloudTimes judge(const RawCloudView& cloud);
  const TimesReport& report() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

/// Times of clouds of the cloud filter: `t` uint32 counts nanoseconds after the stamp. Nothing for other fields.
std::optional<CloudTimes> times_of_filtered(const RawCloudView& cloud);

}  // namespace voxnav::cloud
