// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

#include "raw_cloud.hpp"
#include "voxnav/base/words.hpp"
#include "voxnav/cloud/cloud_filter.hpp"

namespace {

using namespace voxnav;  // NOLINT: test
using cloud::CloudFilter;
using cloud::FieldType;
using cloud::FilterResult;
using cloud::TimesReport;
using cloud::TimesState;
using cloud::TimeUnit;
using cloud::TimeZero;
using test::RawCloud;

/// Returns what a driver writes for a point that was measured `offset_s` after the start of a sweep at `start_s`.
using Written = std::function<double(double offset_s, double start_s)>;

/// A sensor that turns, or measures in a sector only, and the times that its driver writes.
struct Driver {
  std::string name = "time";
  FieldType type = FieldType::kFloat64;
  Written written;
  double stamp_s = 0.0;  ///< stamp of the cloud, after the start of the sweep
  double period_s = 0.1;
  double first_turn = 0.0, last_turn = 1.0;  ///< the sector with returns, as shares of a turn
  std::uint32_t num_points = 6000;
  bool is_shuffled = false;
};

void write_number(RawCloud* cloud, std::size_t index, const Driver& driver, double value) {
  switch (driver.type) {
    case FieldType::kFloat32:
      return cloud->set(index, driver.name, static_cast<float>(value));
    case FieldType::kFloat64:
      return cloud->set(index, driver.name, value);
    case FieldType::kInt32:
      return cloud->set(index, driver.name, static_cast<std::int32_t>(std::llround(value)));
    case FieldType::kUint64:
      return cloud->set(index, driver.name, static_cast<std::uint64_t>(std::llround(value)));
    default:  // 32-bit counters overflow, so the time is taken modulo 2^32
      return cloud->set(index, driver.name, static_cast<std::uint32_t>(std::llround(value)));
  }
}

/// Returns a sweep of a driver, and writes the true time of each point after the start of the sweep to `offsets_s`.
RawCloud sweep_of(const Driver& driver, double start_s, std::vector<double>* offsets_s) {
  auto fields = test::xyzi_fields();
  fields.push_back({driver.name, 16, driver.type, 1});
  RawCloud out(1, driver.num_points, 24, fields);
  offsets_s->clear();
  for (std::size_t i = 0; i < driver.num_points; ++i) {
    const double ratio = static_cast<double>(i) / driver.num_points;
    offsets_s->push_back(driver.period_s * (driver.first_turn + (driver.last_turn - driver.first_turn) * ratio));
  }
  std::mt19937 random(3);
  if (driver.is_shuffled) std::shuffle(offsets_s->begin(), offsets_s->end(), random);
  for (std::size_t i = 0; i < driver.num_points; ++i) {
    const double offset_s = (*offsets_s)[i], angle = 2.0 * M_PI * offset_s / driver.period_s;
    out.set_xyz(i, static_cast<float>(8 * std::cos(angle)), static_cast<float>(8 * std::sin(angle)), 0.5F);
    out.set(i, "intensity", 100.0F);
    write_number(&out, i, driver, driver.written(offset_s, start_s));
  }
  return out;
}

/// Filters sweeps of a driver, and returns the largest error of a point's time in the last of them.
double last_error_s(const Driver& driver, int num_sweeps, CloudFilter* filter) {
  double worst_s = 0.0;
  for (int n = 0; n < num_sweeps; ++n) {
    std::vector<double> offsets_s;
    const double start_s = 1700000000.0 + n * driver.period_s, stamp_s = start_s + driver.stamp_s;
    const RawCloud cloud = sweep_of(driver, start_s, &offsets_s);
    const base::StampNs stamp_ns = base::from_seconds(stamp_s);
    const FilterResult result = filter->apply(cloud.view(stamp_ns));
    worst_s = 0.0;
    for (std::size_t i = 0; i < result.points.size(); ++i) {
      const base::StampNs seen_ns = stamp_ns + result.sweep_start_ns + result.points[i].time_offset_ns;
      worst_s = std::max(worst_s, std::abs(base::to_seconds(seen_ns - base::from_seconds(start_s)) - offsets_s[i]));
    }
  }
  return worst_s;
}

struct Case {
  const char* what;
  Driver driver;
  TimeUnit unit;
  TimeZero zero;
};

constexpr double kBoot_s = 1699990000.0;  // the time at which a sensor with a clock of its own was switched on

std::vector<Case> known_drivers() {
  const auto scaled = [](double per_second) { return [=](double o, double) { return o * per_second; }; };
  const auto absolute = [](double per_second) { return [=](double o, double t) { return (o + t) * per_second; }; };
  const auto booted = [](double per_second) {
    return [=](double o, double t) { return (o + t - kBoot_s) * per_second; };
  };
  const auto f32 = FieldType::kFloat32, f64 = FieldType::kFloat64, u32 = FieldType::kUint32;
  return {
      {"Ouster", {"t", u32, scaled(1e9)}, TimeUnit::kNanosecond, TimeZero::kStamp},
      {"Velodyne", {"time", f32, scaled(1)}, TimeUnit::kSecond, TimeZero::kStamp},
      {"Velodyne, stamp at end",
       {"time", f32, [](double o, double) { return o - 0.1; }, 0.1},
       TimeUnit::kSecond,
       TimeZero::kStamp},
      {"Hesai", {"timestamp", f64, absolute(1)}, TimeUnit::kSecond, TimeZero::kRosTime},
      {"RoboSense, stamp at end", {"timestamp", f64, absolute(1), 0.1}, TimeUnit::kSecond, TimeZero::kRosTime},
      {"Livox", {"timestamp", f64, absolute(1e9)}, TimeUnit::kNanosecond, TimeZero::kRosTime},
      {"absolute ms", {"time_stamp", f64, absolute(1e3)}, TimeUnit::kMillisecond, TimeZero::kRosTime},
      {"absolute us, stamp at end", {"stamp", f64, absolute(1e6), 0.1}, TimeUnit::kMicrosecond, TimeZero::kRosTime},
      {"f32 us", {"time", f32, scaled(1e6)}, TimeUnit::kMicrosecond, TimeZero::kStamp},
      {"f32 ms", {"time", f32, scaled(1e3)}, TimeUnit::kMillisecond, TimeZero::kStamp},
      {"f32 ns", {"time", f32, scaled(1e9)}, TimeUnit::kNanosecond, TimeZero::kStamp},
      {"f64 s", {"timestamp", f64, scaled(1)}, TimeUnit::kSecond, TimeZero::kStamp},
      {"f64 ns", {"time", f64, scaled(1e9)}, TimeUnit::kNanosecond, TimeZero::kStamp},
      {"u32 us", {"t", u32, scaled(1e6)}, TimeUnit::kMicrosecond, TimeZero::kStamp},
      {"u32 ns before the stamp",
       {"t", u32, [](double o, double) { return (o - 0.1) * 1e9; }, 0.1},
       TimeUnit::kNanosecond,
       TimeZero::kStamp},
      {"Aeva",
       {"time_offset_ns", FieldType::kInt32, [](double o, double) { return (o - 0.1) * 1e9; }, 0.1},
       TimeUnit::kNanosecond,
       TimeZero::kStamp},
      {"since boot, s", {"timestamp", f64, booted(1)}, TimeUnit::kSecond, TimeZero::kSensorClock},
      {"since boot, ns", {"timestamp", f64, booted(1e9)}, TimeUnit::kNanosecond, TimeZero::kSensorClock},
      {"since boot, u32 us", {"time", u32, booted(1e6)}, TimeUnit::kMicrosecond, TimeZero::kSensorClock},
      {"u64 ns", {"timestamp", FieldType::kUint64, absolute(1e9)}, TimeUnit::kNanosecond, TimeZero::kRosTime},
  };
}

TEST(PointTimes, ReadsWhatDriversWriteFromTheFirstCloudOn) {
  for (const Case& c : known_drivers()) {
    for (const double period_s : {0.05, 0.1, 0.2}) {
      Driver driver = c.driver;
      driver.period_s = period_s;
      if (driver.stamp_s != 0.0) {
        if (period_s != 0.1) continue;  // these drivers write times before the stamp for a period of 0.1 s
      }
      CloudFilter filter{cloud::CloudFilterConfig()};
      EXPECT_LT(last_error_s(driver, 1, &filter), 2e-3) << c.what << " in the first cloud";
      EXPECT_LT(last_error_s(driver, 12, &filter), 2e-3) << c.what;
      const TimesReport& report = filter.point_times();
      EXPECT_EQ(report.state, TimesState::kMeasured) << c.what;
      EXPECT_STREQ(base::word_of(report.unit), base::word_of(c.unit)) << c.what;
      EXPECT_STREQ(base::word_of(report.zero), base::word_of(c.zero)) << c.what;
      EXPECT_EQ(report.is_stamp_at_end, driver.stamp_s > 0.0) << c.what;
      EXPECT_EQ(report.num_clouds_untimed, 0u) << c.what;
      EXPECT_EQ(cloud::problem_of(report), "");
      EXPECT_NE(report.how.find(driver.name), std::string::npos);
    }
  }
}

TEST(PointTimes, SectorsAndPointsInAnyOrderAreReadToo) {
  for (Case c : known_drivers()) {
    c.driver.first_turn = 0.3;
    c.driver.last_turn = 0.5;
    c.driver.is_shuffled = true;
    CloudFilter filter{cloud::CloudFilterConfig()};
    const double error_s = last_error_s(c.driver, 3, &filter);
    EXPECT_STREQ(base::word_of(filter.point_times().unit), base::word_of(c.unit)) << c.what;
    // If the sensor has a clock of its own, the start of the sweep is known by its first point only.
    EXPECT_LT(error_s, c.zero == TimeZero::kSensorClock ? 0.3 * 0.1 + 2e-3 : 2e-3) << c.what;
  }
}

TEST(PointTimes, CountersMayBeginAnewWithinASweep) {
  const double full_s = 4294967296.0 * 1e-9;
  Driver driver;
  driver.type = FieldType::kUint32;
  driver.written = [&](double offset_s, double start_s) { return std::fmod(offset_s + start_s, full_s) * 1e9; };
  CloudFilter filter{cloud::CloudFilterConfig()};
  EXPECT_LT(last_error_s(driver, 60, &filter), 2e-3);  // the counter overflows every 4.3 s
  EXPECT_EQ(filter.point_times().zero, TimeZero::kSensorClock);
  EXPECT_EQ(filter.point_times().num_clouds_untimed, 0u);
}

TEST(PointTimes, FieldsThatAreNoTimesAreNotUsed) {
  const std::vector<std::pair<const char*, Written>> fields = {
      {"all the same", [](double, double start_s) { return start_s; }},
      {"steps of 10 us", [](double offset_s, double) { return offset_s * 1e5; }},
      {"hours", [](double offset_s, double) { return offset_s / 3600.0; }},
      {"not a number", [](double, double) { return std::nan(""); }},
      {"rubbish", [](double offset_s, double) { return std::fmod(offset_s * 1e9, 97.0) * 1e12; }},
  };
  for (const auto& [what, written] : fields) {
    Driver driver;
    driver.written = written;
    CloudFilter filter{cloud::CloudFilterConfig()};
    std::vector<double> offsets_s;
    for (int n = 0; n < 12; ++n) {
      const RawCloud cloud = sweep_of(driver, 1700000000.0 + 0.1 * n, &offsets_s);
      const FilterResult result = filter.apply(cloud.view(base::from_seconds(1700000000.0 + 0.1 * n)));
      EXPECT_EQ(result.sweep_start_ns, 0) << what;
      for (const cloud::Point& point : result.points) ASSERT_EQ(point.time_offset_ns, 0u) << what;
    }
    EXPECT_EQ(filter.point_times().state, TimesState::kUndecided) << what;
    EXPECT_EQ(filter.point_times().num_clouds_untimed, 12u) << what;
    EXPECT_NE(cloud::problem_of(filter.point_times()).find("12 of 12 clouds"), std::string::npos) << what;
  }
}

TEST(PointTimes, OneBrokenCloudChangesNothingAndALastingChangeDecidesAnew) {
  Driver seconds, milliseconds;
  seconds.written = [](double offset_s, double) { return offset_s; };
  milliseconds.written = [](double offset_s, double) { return 1e3 * offset_s; };
  CloudFilter filter{cloud::CloudFilterConfig()};
  EXPECT_LT(last_error_s(seconds, 5, &filter), 1e-3);
  EXPECT_GT(last_error_s(milliseconds, 1, &filter), 0.09);  // the times are not used
  EXPECT_EQ(filter.point_times().num_clouds_untimed, 1u);
  EXPECT_NE(cloud::problem_of(filter.point_times()), "");
  EXPECT_LT(last_error_s(seconds, 1, &filter), 1e-3);
  EXPECT_LT(last_error_s(milliseconds, 5, &filter), 1e-3);
  EXPECT_EQ(filter.point_times().unit, TimeUnit::kMillisecond);
  EXPECT_EQ(filter.point_times().num_clouds_untimed, 5u);
}

TEST(PointTimes, FewPointsAreReadByNameAndMorePointsDecide) {
  Driver driver;
  driver.name = "t";
  driver.type = FieldType::kUint32;
  driver.written = [](double offset_s, double) { return offset_s * 1e9; };
  driver.num_points = 10;
  CloudFilter filter{cloud::CloudFilterConfig()};
  EXPECT_LT(last_error_s(driver, 2, &filter), 1e-3);
  EXPECT_EQ(filter.point_times().state, TimesState::kByName);
  // Only a mast is in sight, for 0.1 ms. The same numbers could be those of a whole sweep in microseconds.
  driver.num_points = 200;
  driver.first_turn = 0.5;
  driver.last_turn = 0.501;
  EXPECT_LT(last_error_s(driver, 20, &filter), 1e-3);
  EXPECT_EQ(filter.point_times().unit, TimeUnit::kNanosecond);
  driver.num_points = 6000;
  driver.last_turn = 1.0;
  EXPECT_LT(last_error_s(driver, 1, &filter), 1e-3);
  EXPECT_EQ(filter.point_times().state, TimesState::kMeasured);
}

TEST(PointTimes, TimesThatAreNoneOfTheSweepAreCounted) {
  Driver driver;
  driver.written = [](double offset_s, double start_s) {
    return std::fmod(offset_s * 1e5, 100.0) < 1.0 ? 12.0 : offset_s + start_s;
  };
  CloudFilter filter{cloud::CloudFilterConfig()};
  std::vector<double> offsets_s;
  const RawCloud cloud = sweep_of(driver, 1700000000.0, &offsets_s);
  const FilterResult result = filter.apply(cloud.view(base::from_seconds(1700000000.0)));
  EXPECT_GT(result.num_bad_times, 30u);
  EXPECT_LT(result.num_bad_times, 120u);
  EXPECT_EQ(filter.point_times().zero, TimeZero::kRosTime);
}

}  // namespace
