// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "voxnav/cloud/cloud_layout.hpp"

namespace voxnav::cloud {

/// The duration of one step of a time field.
enum class TimeUnit : std::uint8_t { kSecond, kMillisecond, kMicrosecond, kNanosecond };
constexpr auto words_of(TimeUnit) { return std::array{"s", "ms", "us", "ns"}; }

/// The time at which a time field is zero.
enum class TimeZero : std::uint8_t {
  kStamp,        ///< from the stamp of the cloud, before which times are negative
  kRosTime,      ///< from the same epoch as the stamps
  kSensorClock,  ///< from an epoch of the sensor's own; the first point is taken to be measured at the stamp
};
constexpr auto words_of(TimeZero) { return std::array{"stamp", "ros_time", "sensor_clock"}; }

/// How the reading of a sensor's time field was decided.
enum class TimesState : std::uint8_t {
  kNoField,    ///< clouds have no field for it
  kUndecided,  ///< what the field counts is not known, and it is not used
  kByName,     ///< by the usual meaning of its name and type, which no cloud contradicts
  kMeasured,   ///< by the duration of sweeps
};
constexpr auto words_of(TimesState) { return std::array{"no_field", "undecided", "by_name", "measured"}; }

/// The reading of a sensor's time field, and how it was decided.
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

/// Returns what is wrong with the point times of a sensor, as a sentence for people; it is empty if all were used.
std::string problem_of(const TimesReport& report);

/// Converts the numbers of one cloud to nanoseconds after its stamp: (number - zero) * tick.
struct CloudTimes {
  double tick_ns = 0.0;       ///< 0: its times are not used
  double zero = 0.0;          ///< the number at the stamp
  std::int64_t first_ns = 0;  ///< earlier and later ones are no times of this sweep
  std::int64_t last_ns = 0;
};

/// Finds out the unit and the zero of the time field of one sensor, by comparing the duration of sweeps with the time
/// between them. Drivers use the same field names and types with different meanings, so names do not decide alone.
///
/// A sweep takes no longer than the time between stamps (before that is known, a quarter of a second), a sensor
/// measures at most 20 million points per second, and a sensor that sees all around takes at least half of its period
/// (or of 50 ms) for a sweep. Units differ by a factor of 1000, so that for most sensors the first cloud leaves only
/// one. If several remain, name and type decide between them; if they do not, ten clouds are awaited. Until then, and
/// in clouds that contradict the decision, times are not used, which is counted. After five contradictions in a row the
/// unit is decided again. Deterministic; not thread-safe; O(1) per cloud, as only a sample of the points is read.
class PointTimes {
 public:
  PointTimes();
  ~PointTimes();
  PointTimes(PointTimes&&) noexcept;
  PointTimes& operator=(PointTimes&&) noexcept;

  /// Adds the next cloud of the sensor, and returns how its times are read.
  CloudTimes judge(const RawCloudView& cloud);
  const TimesReport& report() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

/// Returns how the times of a cloud of the cloud filter are read, whose field `t` uint32 counts nanoseconds after the
/// stamp; nothing for clouds with another time field.
std::optional<CloudTimes> times_of_filtered(const RawCloudView& cloud);

}  // namespace voxnav::cloud
