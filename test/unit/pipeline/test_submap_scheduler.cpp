// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "voxnav/pipeline/submap_scheduler.hpp"

using namespace voxnav;  // NOLINT: test
using pipeline::SubmapScheduler;
using pipeline::SubmapSchedulerConfig;

namespace {

geometry::Pose tilted(double x, double yaw_rad) {
  geometry::Pose pose = geometry::from_position_yaw({x, 1.0, 2.0}, yaw_rad);
  pose.rotate(Eigen::AngleAxisd(0.3, geometry::Vec3::UnitX()));
  return pose;
}

occupancy::MapContent content_at(int block, containers::VoxelState state) {
  occupancy::MapContent content;
  content.resolution_m = 0.4;
  occupancy::ContentBlock one;
  one.index = {block, 0, 0};
  one.states.set(5, state);
  if (state == containers::VoxelState::kOccupied) one.occupied.push_back({5, {{0, 0, 0}, 1}});
  content.blocks.push_back(one);
  return content;
}

}  // namespace

TEST(SubmapScheduler, ClosesOnTimeWithGravityAlignedFrameAndHistory) {
  SubmapScheduler scheduler(SubmapSchedulerConfig{});
  std::optional<std::string> reason;
  int scans = 0;
  while (!reason) {
    ++scans;
    reason = scheduler.add_scan(900000000LL + 100000000LL * scans, tilted(0.1 * scans, 0.5));
  }
  EXPECT_EQ(*reason, "time");
  EXPECT_EQ(scans, 101);
  const auto handover = scheduler.close(*reason, content_at(0, containers::VoxelState::kFree));
  ASSERT_TRUE(handover);
  EXPECT_TRUE(handover->is_final);
  EXPECT_EQ(handover->poses.size(), 101u);
  EXPECT_EQ(handover->start_ns, 1000000000LL);
  EXPECT_EQ(handover->stamp_ns, 11000000000LL);
  EXPECT_NEAR(handover->T_O_S.linear()(2, 2), 1.0, 1e-12);
  EXPECT_NEAR(geometry::yaw_of(handover->T_O_S), 0.5, 1e-9);
  EXPECT_TRUE((handover->T_O_S * handover->poses[40].pose).isApprox(tilted(4.1, 0.5), 1e-9));
  EXPECT_FALSE(scheduler.is_open());
  EXPECT_FALSE(scheduler.close("shutdown", {}));
  scheduler.add_scan(12000000000LL, tilted(9.0, 0.0));
  EXPECT_EQ(scheduler.submap_id(), 1u);
}

TEST(SubmapScheduler, ClosesOnDistanceAndOnTrouble) {
  SubmapSchedulerConfig config;
  config.max_distance_m = 5.0;
  SubmapScheduler scheduler(config);
  EXPECT_FALSE(scheduler.add_scan(0, tilted(0.0, 0.0)));
  EXPECT_FALSE(scheduler.add_scan(100000000, tilted(4.0, 0.0)));
  EXPECT_EQ(scheduler.add_scan(200000000, tilted(2.5, 0.0)), std::optional<std::string>("distance"));
  scheduler.close("distance", {});

  scheduler.add_scan(300000000, tilted(0.0, 0.0));
  scheduler.request_close("odometry");
  EXPECT_FALSE(scheduler.add_scan(400000000, tilted(0.0, 0.0))) << "younger than min_period_s";
  EXPECT_EQ(scheduler.add_scan(1400000000, tilted(0.0, 0.0)), std::optional<std::string>("odometry"));
}

TEST(SubmapScheduler, OldScansAreIgnoredAndTheHistoryIsBounded) {
  SubmapSchedulerConfig config;
  config.max_poses = 10;
  config.period_s = 1000.0;
  SubmapScheduler scheduler(config);
  for (int i = 0; i < 500; ++i) {
    scheduler.add_scan(i * 1000000LL, tilted(0.001 * i, 0.0));
    scheduler.add_scan(i * 1000000LL - 500, tilted(100.0, 0.0));
  }
  const auto handover = scheduler.close("shutdown", {});
  ASSERT_TRUE(handover);
  EXPECT_LE(handover->poses.size(), 10u);
  EXPECT_EQ(handover->poses.front().stamp_ns, 0);
  EXPECT_EQ(handover->poses.back().stamp_ns, 499000000);
  for (std::size_t i = 1; i < handover->poses.size(); ++i) {
    EXPECT_GT(handover->poses[i].stamp_ns, handover->poses[i - 1].stamp_ns);
  }
}

TEST(SubmapScheduler, TheContentOfTheMapReplacesEvictedContent) {
  SubmapScheduler scheduler(SubmapSchedulerConfig{});
  scheduler.add_scan(0, tilted(0.0, 0.0));
  scheduler.add_evicted(content_at(0, containers::VoxelState::kOccupied));
  scheduler.add_evicted(content_at(3, containers::VoxelState::kOccupied));
  EXPECT_FALSE(scheduler.take_early());
  const auto handover = scheduler.close("time", content_at(0, containers::VoxelState::kFree));
  ASSERT_EQ(handover->content.blocks.size(), 2u);
  EXPECT_EQ(handover->content.blocks[0].states.get(5), containers::VoxelState::kFree);
  EXPECT_EQ(handover->content.blocks[1].states.get(5), containers::VoxelState::kOccupied);
}

TEST(SubmapScheduler, TooMuchEvictedContentGoesEarly) {
  SubmapSchedulerConfig config;
  config.max_early_blocks = 3;
  SubmapScheduler scheduler(config);
  scheduler.add_scan(0, tilted(0.0, 0.0));
  for (int i = 0; i < 4; ++i) scheduler.add_evicted(content_at(i, containers::VoxelState::kFree));
  const auto early = scheduler.take_early();
  ASSERT_TRUE(early);
  EXPECT_FALSE(early->is_final);
  EXPECT_EQ(early->reason, "window");
  EXPECT_EQ(early->content.blocks.size(), 4u);
  EXPECT_EQ(early->submap_id, scheduler.submap_id());
  EXPECT_TRUE(scheduler.close("time", {})->content.blocks.empty());
}

TEST(SubmapScheduler, ContinuesWithUnusedIdsAfterARestart) {
  constexpr base::StampNs kStart_ns = 1700000000LL * 1000000000LL;
  SubmapScheduler first(SubmapSchedulerConfig{}, std::nullopt), second(SubmapSchedulerConfig{}, std::nullopt);
  std::uint32_t last_id = 0;
  for (int scan = 0; scan < 300; ++scan) {
    const base::StampNs stamp_ns = kStart_ns + 100000000LL * scan;
    if (!first.add_scan(stamp_ns, tilted(0.1 * scan, 0.0))) continue;
    last_id = first.close("time", {})->submap_id;
  }
  EXPECT_EQ(last_id, 1700000001u);
  second.add_scan(kStart_ns + 30000000000LL, tilted(30.0, 0.0));
  EXPECT_GT(second.submap_id(), last_id);
}
