// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "raw_cloud.hpp"
#include "voxnav/cloud/body_mask.hpp"
#include "voxnav/cloud/cloud_filter.hpp"

using namespace voxnav::cloud;  // NOLINT: test

namespace {

constexpr float kLeg[3] = {0.3F, 0.3F, -0.2F};

/// Returns a cloud of a leg of the vehicle, a wall at 5 m, and if asked for something that passes near the sensor.
voxnav::test::RawCloud cloud_of(bool has_passer_by) {
  voxnav::test::RawCloud cloud(1, 4, 48, voxnav::test::ouster_fields());
  cloud.set_xyz(0, kLeg[0], kLeg[1], kLeg[2]);
  cloud.set_xyz(1, 5.0F, 0.0F, 0.0F);
  has_passer_by ? cloud.set_xyz(2, -0.5F, 0.1F, 0.0F) : cloud.set_xyz(2, -5.0F, 1.0F, 0.0F);
  cloud.set_xyz(3, std::nanf(""), 0.0F, 0.0F);
  return cloud;
}

BodyMask learnt() {
  BodyMaskConfig config;
  config.num_clouds = 10;
  BodyMaskLearner learner(config);
  for (int i = 0; !learner.is_done(); ++i) learner.add(cloud_of(i == 3).view());
  EXPECT_EQ(learner.num_clouds(), 10);
  return learner.finish();
}

}  // namespace

TEST(BodyMask, HoldsDirectionsWithNearReturnsInEveryCloudOnly) {
  const BodyMask mask = learnt();
  EXPECT_TRUE(mask.covers(kLeg[0], kLeg[1], kLeg[2]));
  EXPECT_FALSE(mask.covers(1.5F * kLeg[0], 1.5F * kLeg[1], 1.5F * kLeg[2])) << "behind the leg";
  EXPECT_FALSE(mask.covers(-0.5F, 0.1F, 0.0F)) << "passed by once";
  EXPECT_EQ(mask.num_covered(), 9u);
  EXPECT_NEAR(mask.farthest_m(), std::sqrt(0.22F) + 0.05F, 1e-5F);
  EXPECT_EQ(BodyMask().num_covered(), 0u);
}

TEST(BodyMask, FilterCountsItsReturnsAsBody) {
  CloudFilterConfig config;
  config.min_range_m = 0.0;
  config.body_radius_m = 0.0;
  CloudFilter filter(config);
  EXPECT_EQ(filter.apply(cloud_of(false).view()).counts.body, 0u);
  filter.set_body_mask(learnt());
  const FilterResult result = filter.apply(cloud_of(false).view());
  EXPECT_EQ(result.counts.body, 1u);
  EXPECT_EQ(result.counts.kept, 2u);
  filter.set_body_mask(BodyMask());
  EXPECT_EQ(filter.apply(cloud_of(false).view()).counts.body, 0u);
}

TEST(BodyMask, WrongUseIsRefused) {
  BodyMaskConfig config;
  config.least_share = 1.5;
  EXPECT_THROW(BodyMaskLearner{config}, voxnav::base::ConfigError);
  EXPECT_THROW(BodyMaskLearner{BodyMaskConfig()}.finish(), std::logic_error);
}
