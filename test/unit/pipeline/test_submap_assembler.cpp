// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "content_builder.hpp"
#include "steps.hpp"
#include "voxnav/pipeline/submap_assembler.hpp"

using namespace voxnav;  // NOLINT: test
using pipeline::Handover;
using pipeline::SubmapAssembler;
using pipeline::SubmapAssemblerConfig;

namespace {

/// Returns the content of a vertical column of free voxels with an occupied one at its top, at x = column.
occupancy::MapContent column_of(int column) {
  test::ContentBuilder builder(0.4);
  for (int z = 0; z < 4; ++z) builder.set_free({column, 0, z});
  builder.set_occupied({column, 0, 4});
  return builder.build();
}

Handover part_of(std::uint32_t id, bool is_final, occupancy::MapContent content) {
  Handover handover;
  handover.submap_id = id;
  handover.is_final = is_final;
  handover.start_ns = 1000;
  handover.stamp_ns = 2000;
  handover.T_O_S = geometry::from_position_yaw({1.0, -2.0, 0.5}, 0.7);
  handover.poses = {{1000, geometry::Pose::Identity()}, {2000, geometry::from_position_yaw({1.0, 0.0, 0.0}, 0.1)}};
  handover.content = std::move(content);
  return handover;
}

/// Returns points on the ground 1.2 m below the sensor, up to 4 m away.
std::vector<geometry::Vec3f> ground() {
  std::vector<geometry::Vec3f> out;
  const std::vector<double> side = test::steps(-4.0, 4.1, 0.2);
  for (const double x : side) {
    for (const double y : side) out.emplace_back(geometry::Vec3(x, y, -1.2).cast<float>());
  }
  return out;
}

SubmapAssemblerConfig of_clouds(double period_s) {
  SubmapAssemblerConfig config;
  config.projective.emplace();
  config.projective_period_s = period_s;
  return config;
}

}  // namespace

TEST(SubmapAssembler, FillsOneSubmapFromItsPartsAsIfTheyHadComeAtOnce) {
  occupancy::MapContent whole = column_of(0);
  whole.merge(column_of(30));
  whole.merge(column_of(60));
  SubmapAssembler at_once{SubmapAssemblerConfig{}};
  const auto expected = at_once.add(part_of(7, true, whole)).submap;
  ASSERT_TRUE(expected);

  SubmapAssembler assembler{SubmapAssemblerConfig{}};
  EXPECT_FALSE(assembler.add(part_of(7, false, column_of(0))).submap);
  EXPECT_FALSE(assembler.add(part_of(7, false, column_of(30))).submap);
  EXPECT_EQ(assembler.num_open(), 1u);
  const auto result = assembler.add(part_of(7, true, column_of(60)));
  ASSERT_TRUE(result.submap);
  EXPECT_FALSE(result.dropped);
  EXPECT_EQ(result.submap->submap->to_bytes(), expected->submap->to_bytes());
  EXPECT_EQ(result.submap->submap->occupied_points().size(), 3u);
  EXPECT_EQ(assembler.num_open(), 0u);
}

TEST(SubmapAssembler, TakesIdPosesAndTimesFromTheHandover) {
  SubmapAssembler assembler{SubmapAssemblerConfig{}};
  const Handover handover = part_of(3, true, column_of(0));
  const auto entry = assembler.add(handover).submap;
  ASSERT_TRUE(entry);
  EXPECT_EQ(entry->id, 3u);
  EXPECT_EQ(entry->start_ns, 1000);
  EXPECT_EQ(entry->end_ns, 2000);
  EXPECT_TRUE(entry->T_O_S.isApprox(handover.T_O_S));
  EXPECT_TRUE(entry->T_W_S.isApprox(handover.T_O_S));
  ASSERT_EQ(entry->T_S_B.size(), 2u);
  EXPECT_TRUE(entry->T_S_B[1].pose.isApprox(handover.poses[1].pose));
  const geometry::Vec3 p_O = handover.T_O_S * entry->submap->occupied_points().front().cast<double>();
  EXPECT_TRUE(p_O.isApprox(geometry::Vec3(0.2, 0.2, 1.8), 1e-3));
}

TEST(SubmapAssembler, KeepsEarlyContentOfAFewSubmapsAndNamesThoseItDrops) {
  SubmapAssemblerConfig config;
  config.max_open_submaps = 2;
  SubmapAssembler assembler{config};
  EXPECT_FALSE(assembler.add(part_of(4, false, column_of(0))).dropped);
  EXPECT_FALSE(assembler.add(part_of(5, false, column_of(0))).dropped);
  EXPECT_FALSE(assembler.add(part_of(5, false, column_of(30))).dropped);
  const auto result = assembler.add(part_of(6, false, column_of(0)));
  EXPECT_FALSE(result.submap);
  ASSERT_TRUE(result.dropped);
  EXPECT_NE(result.dropped->find("submap 4"), std::string::npos);
  EXPECT_EQ(assembler.num_open(), 2u);
  // The last part of the submap that was given up still makes a submap, of its own content alone.
  const auto late = assembler.add(part_of(4, true, column_of(60))).submap;
  ASSERT_TRUE(late);
  EXPECT_EQ(late->submap->occupied_points().size(), 1u);
  const auto whole = assembler.add(part_of(5, true, column_of(60))).submap;
  ASSERT_TRUE(whole);
  EXPECT_EQ(whole->submap->occupied_points().size(), 3u);
}

TEST(SubmapAssembler, RefusesPartsOfAnotherResolutionAndGoesOn) {
  SubmapAssembler assembler{SubmapAssemblerConfig{}};
  assembler.add(part_of(1, false, column_of(0)));
  occupancy::MapContent other = column_of(0);
  other.resolution_m = 0.2;
  EXPECT_THROW(assembler.add(part_of(1, true, other)), std::invalid_argument);
  EXPECT_EQ(assembler.num_open(), 0u);
  EXPECT_TRUE(assembler.add(part_of(2, true, column_of(0))).submap);
}

TEST(SubmapAssembler, RefusesALimitOfNoOpenSubmaps) {
  SubmapAssemblerConfig config;
  config.max_open_submaps = 0;
  EXPECT_THROW(SubmapAssembler{config}, std::invalid_argument);
}

TEST(SubmapAssembler, TakesCloudsOnlyWhenItFillsFromClouds) {
  SubmapAssembler assembler{SubmapAssemblerConfig{}};
  EXPECT_FALSE(assembler.is_projective());
  EXPECT_THROW(assembler.integrate(ground(), geometry::Pose::Identity(), 0), std::logic_error);
  EXPECT_THROW(assembler.close(), std::logic_error);
  EXPECT_FALSE(assembler.is_due());
}

TEST(SubmapAssembler, ClosesASubmapOfCloudsByItsAge) {
  SubmapAssembler assembler{of_clouds(1.0)};
  geometry::Pose T_O_L = geometry::from_position_yaw({3.0, 1.0, 2.0}, 0.5);
  T_O_L.rotate(Eigen::AngleAxisd(0.1, geometry::Vec3::UnitX()));
  constexpr base::StampNs kStep_ns = 400000000;
  for (int i = 0; i < 3; ++i) {
    EXPECT_FALSE(assembler.is_due());
    assembler.integrate(ground(), T_O_L, 1000 + i * kStep_ns);
  }
  EXPECT_FALSE(assembler.is_due());
  assembler.integrate(ground(), T_O_L, 1000 + 3 * kStep_ns);
  ASSERT_TRUE(assembler.is_due());
  EXPECT_FALSE(assembler.add(part_of(9, true, column_of(0))).submap);  // only the age closes a submap of clouds
  const submap::SubmapEntry entry = assembler.close();
  EXPECT_EQ(entry.id, 0u);
  EXPECT_EQ(entry.start_ns, 1000);
  EXPECT_EQ(entry.end_ns, 1000 + 3 * kStep_ns);
  ASSERT_EQ(entry.T_S_B.size(), 4u);
  EXPECT_TRUE((entry.T_O_S * entry.T_S_B[2].pose).isApprox(T_O_L, 1e-9));
  EXPECT_NEAR(entry.T_O_S.linear()(2, 2), 1.0, 1e-12);
  EXPECT_TRUE(entry.T_W_S.isApprox(entry.T_O_S));
  EXPECT_GT(entry.submap->occupied_points().size(), 50u);
  EXPECT_FALSE(assembler.is_due());
  assembler.integrate(ground(), T_O_L, 5000000000);
  EXPECT_EQ(assembler.close().id, 1u);
}

TEST(SubmapAssembler, ClosesASubmapOfCloudsWhenTimeGoesBack) {
  SubmapAssembler assembler{of_clouds(10.0)};
  assembler.integrate(ground(), geometry::Pose::Identity(), 5000000000);
  EXPECT_FALSE(assembler.is_due());
  assembler.integrate(ground(), geometry::Pose::Identity(), 4000000000);
  EXPECT_TRUE(assembler.is_due());
}

TEST(SubmapAssembler, ClosesASubmapOfCloudsWithTheHandoversOfTheLocalMap) {
  SubmapAssembler assembler{of_clouds(0.0)};
  EXPECT_TRUE(assembler.is_projective());
  const geometry::Pose T_O_L = geometry::from_position_yaw({0.0, 0.0, 1.2}, 0.0);
  for (base::StampNs stamp_ns : {1000, 1500, 2000}) assembler.integrate(ground(), T_O_L, stamp_ns);
  EXPECT_FALSE(assembler.is_due());
  EXPECT_FALSE(assembler.add(part_of(5, false, column_of(0))).submap);
  EXPECT_EQ(assembler.num_open(), 0u);
  const Handover handover = part_of(5, true, column_of(0));
  const auto entry = assembler.add(handover).submap;
  ASSERT_TRUE(entry);
  EXPECT_EQ(entry->id, 5u);
  EXPECT_TRUE(entry->T_O_S.isApprox(handover.T_O_S));
  ASSERT_GT(entry->submap->occupied_points().size(), 50u);
  // Distances along grazing rays are too large, but here by less than a voxel.
  const double voxel_m = submap::ProjectiveConfig{}.resolution_m;
  for (const geometry::Vec3f& p_S : entry->submap->occupied_points()) {
    EXPECT_NEAR((handover.T_O_S * p_S.cast<double>()).z(), 0.0, voxel_m);
  }
  const auto empty = assembler.add(part_of(6, true, column_of(0))).submap;
  ASSERT_TRUE(empty);
  EXPECT_TRUE(empty->submap->occupied_points().empty());
}
