// SPDX-License-Identifier: BSD-3-Clause
// The filter, which makes one pass, is compared with a plain form of its rules on random clouds and configurations.
#include "voxnav/cloud/cloud_filter.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "raw_cloud.hpp"

namespace {

using namespace voxnav;  // NOLINT: test
using cloud::CloudFilterConfig;

struct P {
  double x, y, z, intensity;
};

const char* verdict(const CloudFilterConfig& c, const P& p) {
  if (!std::isfinite(p.x + p.y + p.z)) return "nan";
  if (p.x == 0 && p.y == 0 && p.z == 0) return "zero";
  const double range = std::sqrt(p.x * p.x + p.y * p.y + p.z * p.z);
  if (std::hypot(std::hypot(p.x - c.body_center_m[0], p.y - c.body_center_m[1]), p.z - c.body_center_m[2]) <
      c.body_radius_m) {
    return "body";
  }
  const auto& lo = c.body_box_min_m;
  const auto& hi = c.body_box_max_m;
  const bool in_box = p.x >= lo[0] && p.x <= hi[0] && p.y >= lo[1] && p.y <= hi[1] && p.z >= lo[2] && p.z <= hi[2];
  if (c.use_body_box && in_box) return "body";
  if (range < c.min_range_m) return "near";
  if (range > c.max_range_m) return "far";
  if (range < c.ghost_range_m && p.intensity < c.ghost_intensity) return "ghost";
  return "kept";
}

CloudFilterConfig random_config(std::mt19937* random) {
  std::uniform_real_distribution<double> unit(0, 1);
  CloudFilterConfig c;
  c.min_range_m = unit(*random) * 2;
  c.max_range_m = 5 + unit(*random) * 20;
  c.body_radius_m = unit(*random) * 2 * ((*random)() % 2);
  c.body_center_m = {unit(*random), -unit(*random), unit(*random)};
  c.use_body_box = (*random)() % 2 == 0;
  c.body_box_min_m = {-1 - unit(*random), -unit(*random), -2};
  c.body_box_max_m = {1.0, unit(*random), -0.1};
  c.ghost_intensity = unit(*random) * 60;
  c.ghost_range_m = unit(*random) * 15;
  c.remove_outliers = false;  // the plain rules judge each point alone
  c.row_decimation = 1 + static_cast<int>((*random)() % 4);
  c.column_decimation = 1 + static_cast<int>((*random)() % 4);
  return c;
}

float random_coordinate(std::mt19937* random) {
  std::normal_distribution<float> wide(0, 8), narrow(0, 1);
  const auto kind = (*random)() % 40;
  if (kind == 0) return std::nanf("");
  return kind < 12 ? narrow(*random) : wide(*random);
}

TEST(CloudFilterProperty, EqualsThePlainRules) {
  std::mt19937 random(11);
  for (int round = 0; round < 200; ++round) {
    const CloudFilterConfig config = random_config(&random);
    test::RawCloud c = test::xyzi_cloud(1 + random() % 20, 1 + random() % 60);
    std::map<std::string, std::uint64_t> expected;
    const bool organised = c.layout.height > 1;
    for (std::size_t i = 0; i < c.layout.num_points(); ++i) {
      const float v[3] = {random_coordinate(&random), random_coordinate(&random), random_coordinate(&random)};
      const bool missing = random() % 10 == 0;
      const auto intensity = static_cast<float>(1 + random() % 100);
      missing ? c.set_xyz(i, 0, 0, 0) : c.set_xyz(i, v[0], v[1], v[2]);
      c.set(i, "intensity", intensity);
      const bool used = !organised || ((i / c.layout.width) % static_cast<std::size_t>(config.row_decimation) == 0 &&
                                       (i % c.layout.width) % static_cast<std::size_t>(config.column_decimation) == 0);
      const P p = missing ? P{0, 0, 0, intensity} : P{v[0], v[1], v[2], intensity};
      ++expected[used ? verdict(config, p) : "decimated"];
    }
    const auto result = cloud::CloudFilter(config).apply(c.view());
    for (const auto& [name, value] : result.counts.reasons())
      EXPECT_EQ(value, expected[name]) << name << " in round " << round;
  }
}

}  // namespace
