// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "voxnav/base/config.hpp"

namespace {

using namespace voxnav;  // NOLINT: test

enum class Filling { kOccupancy, kProjective };
constexpr auto words_of(Filling) { return std::array{"occupancy", "projective"}; }

struct SampleConfig {
  double resolution_m = 0.4;
  int num_threads = 1;
  bool is_enabled = true;
  Filling filling = Filling::kOccupancy;
  std::array<double, 3> window_size_m{80, 80, 40};

  template <class V>
  static void fields(V&& v) {
    v("resolution_m", &SampleConfig::resolution_m, base::in(0.01, 10), "m", "edge of one voxel");
    v("num_threads", &SampleConfig::num_threads, base::in(1, 64), "", "worker threads");
    v("is_enabled", &SampleConfig::is_enabled, base::any(), "", "switch");
    v("filling", &SampleConfig::filling, base::one_of<Filling>(), "", "way to fill");
    v("window_size_m", &SampleConfig::window_size_m, base::in(1, 1000), "m", "window");
  }
  std::vector<std::string> problems() const {
    if (window_size_m[0] < resolution_m * 10) return {"window_size_m must span ten voxels"};
    return {};
  }
};

std::string only_problem(const base::ValueMap& values) {
  SampleConfig config;
  const auto problems = base::assign(&config, values);
  return problems.size() == 1 ? problems[0] : "not exactly one problem";
}

TEST(Config, AcceptsGoodValuesAndWidensIntegers) {
  SampleConfig config;
  const auto problems =
      base::assign(&config, {{"resolution_m", std::int64_t{1}}, {"filling", std::string("projective")}});
  EXPECT_TRUE(problems.empty());
  EXPECT_EQ(config.resolution_m, 1.0);
  EXPECT_EQ(config.filling, Filling::kProjective);
}

TEST(Config, NamesKeyValueAndAllowedRange) {
  EXPECT_EQ(only_problem({{"resolution_m", -1.0}}), "resolution_m = -1: allowed is 0.01 to 10 m");
  EXPECT_EQ(only_problem({{"filling", std::string("magic")}}),
            "filling = 'magic': allowed is one of occupancy, projective");
  EXPECT_EQ(only_problem({{"filling", std::int64_t{1}}}), "filling = 1: needs a string");
  EXPECT_EQ(only_problem({{"num_threads", 1.5}}), "num_threads = 1.5: needs an integer");
  EXPECT_EQ(only_problem({{"is_enabled", std::int64_t{1}}}), "is_enabled = 1: needs true or false");
  EXPECT_EQ(only_problem({{"window_size_m", std::vector<double>{1, 2}}}),
            "window_size_m = [1, 2]: needs 3 numbers, has 2");
}

TEST(Config, RefusesNotANumber) {
  EXPECT_NE(only_problem({{"resolution_m", std::nan("")}}).find("allowed"), std::string::npos);
}

TEST(Config, SuggestsTheNearestNameForAnUnknownKey) {
  EXPECT_EQ(only_problem({{"resolutoin_m", 0.2}}), "resolutoin_m: unknown parameter, did you mean resolution_m?");
}

TEST(Config, ListsEveryProblemAtOnce) {
  SampleConfig config;
  EXPECT_EQ(base::assign(&config, {{"resolution_m", 99.0}, {"num_threads", std::int64_t{0}}, {"foo", true}}).size(),
            3u);
}

TEST(Config, ChecksRulesBetweenFields) {
  SampleConfig config;
  config.resolution_m = 10;
  EXPECT_THROW(base::checked(config), base::ConfigError);
}

}  // namespace
