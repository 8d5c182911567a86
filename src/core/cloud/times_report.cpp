// SPDX-License-Identifier: BSD-3-Clause
// The sentences on the point times of a sensor, and the usual meaning of names of fields.
#include <cstdio>

#include "cloud/point_times_impl.hpp"

namespace voxnav::cloud {
namespace {

std::string number(double value, const char* format = "%.4g") {
  char text[32];
  std::snprintf(text, sizeof(text), format, value);
  return text;
}

bool ends_with(const std::string& text, const std::string& end) {
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

const char* long_name(TimeUnit unit) {
  constexpr const char* kNames[] = {"seconds", "milliseconds", "microseconds", "nanoseconds"};
  return kNames[static_cast<std::size_t>(unit)];
}

std::string zero_words(const TimesReport& report) {
  const std::string end = report.is_stamp_at_end ? " (the end of the sweep)" : "";
  switch (report.zero) {
    case TimeZero::kStamp:
      return "after the cloud's stamp" + end;
    case TimeZero::kRosTime:
      return std::string("of ROS time; the stamp is ") + (report.is_stamp_at_end ? "the end" : "the start") +
             " of the sweep";
    case TimeZero::kSensorClock:
      return "of a clock of the sensor; its first point is taken to be measured at the stamp";
  }
  return {};
}

std::string period_words(const TimesReport& report) {
  return report.sweep_period_ns ? "sweeps are " + number(base::to_seconds(*report.sweep_period_ns)) + " s apart"
                                : "no sweep lasts longer than a quarter of a second";
}

}  // namespace

/// Returns the usual meaning of a field: integers are nanoseconds and other numbers seconds, unless the name ends with
/// a unit. Doubles count from 1970, except in `t`.
PointTimes::Impl::Usual PointTimes::Impl::usual_reading(const TimeField& field) {
  const FieldType type = field.access.type;
  const bool is_float = type == FieldType::kFloat32 || type == FieldType::kFloat64;
  Usual out;
  out.unit = is_float ? TimeUnit::kSecond : TimeUnit::kNanosecond;
  for (const TimeUnit unit : base::all_values<TimeUnit>()) {
    const std::string word = base::word_of(unit);
    if (ends_with(field.name, "_" + word) || ends_with(field.name, "_" + word + "ec")) out.unit = unit;
  }
  out.zero = type == FieldType::kFloat64 && field.name.size() > 1 ? TimeZero::kRosTime : TimeZero::kStamp;
  return out;
}

void PointTimes::Impl::explain(const TimeSpread& spread) {
  const std::string field = "field '" + report_.field + "' (" + name_of(report_.type) + ")";
  if (report_.state == TimesState::kUndecided) {
    report_.how = field + " spans " + number(spread.span()) + " in a cloud, and " + period_words(report_) +
                  ", which fits no unit from seconds to nanoseconds";
    if (spread.num_distinct > 0 && spread.num_distinct < 8) {
      report_.how = field + " has only " + std::to_string(spread.num_distinct) + " different values in a cloud";
    }
    if (spread.num_sampled == 0) report_.how = field + " has no numbers in it";
    return;
  }
  report_.how = field + " counts " + long_name(report_.unit) + " " + zero_words(report_) + ". ";
  report_.how += report_.state == TimesState::kByName
                     ? "So its name and type say, and nothing contradicts"
                     : "So the points of a sweep span " + number(base::to_seconds(report_.sweep_span_ns)) + " s, and " +
                           period_words(report_);
}

std::string problem_of(const TimesReport& report) {
  if (report.num_clouds_untimed == 0) return {};
  const std::string clouds = std::to_string(report.num_clouds_untimed) + " of " + std::to_string(report.num_clouds) +
                             " clouds are used without point times, and their motion is not undone: ";
  if (report.state == TimesState::kUndecided) return clouds + report.how;
  return clouds + "their times contradict the others. " + report.how;
}

}  // namespace voxnav::cloud
