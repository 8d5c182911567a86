// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <limits>

#include "content_builder.hpp"
#include "voxnav_ros/conversions.hpp"
#include "voxnav_ros/messages.hpp"
#include "voxnav_ros/submap_conversions.hpp"

using namespace voxnav_ros;  // NOLINT: test
namespace geometry = voxnav::geometry;

namespace {

const geometry::Pose kT_O_S = geometry::from_position_yaw({1.0, -2.0, 0.5}, 0.7);

voxnav::occupancy::MapContent content() {
  voxnav::test::ContentBuilder builder(0.4);
  builder.set_free({0, 0, 0});
  builder.set_occupied({0, 0, 1});
  return builder.build();
}

msg::Handover handover() {
  msg::Handover msg;
  msg.header.stamp = ros::Time(20, 5);
  msg.submap_id = 3;
  msg.is_final = true;
  msg.reason = "time";
  msg.start = ros::Time(10, 7);
  msg.T_O_S = to_msg(kT_O_S);
  msg.pose_stamps = {ros::Time(10, 7), ros::Time(20, 5)};
  msg.T_S_B = {to_msg(geometry::Pose::Identity()), to_msg(geometry::from_position_yaw({4.0, 0.0, 0.0}, 0.1))};
  const std::string bytes = content().to_bytes();
  msg.content.assign(bytes.begin(), bytes.end());
  return msg;
}

voxnav::submap::SubmapEntry entry() {
  voxnav::submap::SubmapEntry out;
  out.id = 9;
  out.start_ns = 10000000007;
  out.end_ns = 20000000005;
  out.T_O_S = kT_O_S;
  out.T_S_B = {{10000000007, geometry::Pose::Identity()}, {20000000005, geometry::from_position_yaw({4, 0, 0}, 0.1)}};
  out.submap = voxnav::submap::Submap::from_content(content(), kT_O_S.inverse(), {});
  return out;
}

msg::SubmapPoses poses_of_two() {
  msg::SubmapPoses msg;
  msg.submap_ids = {1, 2};
  msg.T_W_S = {to_msg(geometry::Pose::Identity()), to_msg(kT_O_S)};
  return msg;
}

}  // namespace

TEST(SubmapConversions, AHandoverHoldsWhatItsMessageHolds) {
  const voxnav::pipeline::Handover out = from_msg(handover());
  EXPECT_EQ(out.submap_id, 3u);
  EXPECT_TRUE(out.is_final);
  EXPECT_EQ(out.start_ns, 10000000007);
  EXPECT_EQ(out.stamp_ns, 20000000005);
  EXPECT_TRUE(out.T_O_S.isApprox(kT_O_S, 1e-12));
  ASSERT_EQ(out.poses.size(), 2u);
  EXPECT_EQ(out.poses[1].stamp_ns, 20000000005);
  EXPECT_NEAR(out.poses[1].pose.translation().x(), 4.0, 1e-12);
  EXPECT_EQ(out.content.to_bytes(), content().to_bytes());
}

TEST(SubmapConversions, AHandoverWithoutAPoseIsRefused) {
  msg::Handover msg = handover();
  msg.T_O_S = geometry_msgs::Pose{};
  EXPECT_THROW(from_msg(msg), std::invalid_argument);
  msg = handover();
  msg.T_S_B[1].position.x = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(from_msg(msg), std::invalid_argument);
}

TEST(SubmapConversions, AHandoverWithListsOfDifferentLengthsIsRefused) {
  msg::Handover msg = handover();
  msg.pose_stamps.pop_back();
  EXPECT_THROW(from_msg(msg), std::invalid_argument);
}

TEST(SubmapConversions, AHandoverWithDamagedContentIsRefused) {
  msg::Handover msg = handover();
  msg.content[msg.content.size() / 2] ^= 1;
  EXPECT_THROW(from_msg(msg), std::invalid_argument);
  msg.content.clear();
  EXPECT_THROW(from_msg(msg), std::invalid_argument);
}

TEST(SubmapConversions, AFinishedSubmapComesBackAsItWas) {
  const voxnav::submap::SubmapEntry sent = entry();
  const msg::FinishedSubmap msg = to_msg(sent, "uav1/origin");
  EXPECT_EQ(msg.header.frame_id, "uav1/origin");
  const voxnav::submap::SubmapEntry back = from_msg(msg);
  EXPECT_EQ(back.id, sent.id);
  EXPECT_EQ(back.start_ns, sent.start_ns);
  EXPECT_EQ(back.end_ns, sent.end_ns);
  EXPECT_TRUE(back.T_O_S.isApprox(sent.T_O_S, 1e-12));
  ASSERT_EQ(back.T_S_B.size(), 2u);
  EXPECT_EQ(back.T_S_B[0].stamp_ns, sent.T_S_B[0].stamp_ns);
  EXPECT_TRUE(back.T_S_B[1].pose.isApprox(sent.T_S_B[1].pose, 1e-12));
  EXPECT_EQ(back.submap->to_bytes(), sent.submap->to_bytes());
}

TEST(SubmapConversions, ADamagedSubmapIsRefused) {
  msg::FinishedSubmap msg = to_msg(entry(), "origin");
  msg.data[msg.data.size() / 2] ^= 1;
  EXPECT_THROW(from_msg(msg), std::invalid_argument);
  msg = to_msg(entry(), "origin");
  msg.T_O_S.orientation.w = 7.0;
  EXPECT_THROW(from_msg(msg), std::invalid_argument);
}

TEST(SubmapConversions, InvalidPosesAreNamed) {
  try {
    valid_poses({to_msg(kT_O_S), geometry_msgs::Pose{}}, "T_W_S");
    FAIL() << "an empty pose was taken";
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("T_W_S"), std::string::npos);
  }
}

TEST(SubmapConversions, SubmapsAreRigidIfTheMessageHasNoBends) {
  const std::vector<geometry::Bend> bends = bends_of(poses_of_two());
  ASSERT_EQ(bends.size(), 2u);
  EXPECT_TRUE(bends[0].is_rigid() && bends[1].is_rigid());
}

TEST(SubmapConversions, BendsComeFromBothEnds) {
  msg::SubmapPoses msg = poses_of_two();
  const geometry::Pose moved = geometry::from_position_yaw({0.1, 0.2, 0.3}, 0.01);
  msg.T_S_begin = {to_msg(geometry::Pose::Identity()), to_msg(moved)};
  msg.T_S_end = {to_msg(moved), to_msg(geometry::Pose::Identity())};
  const std::vector<geometry::Bend> bends = bends_of(msg);
  ASSERT_EQ(bends.size(), 2u);
  EXPECT_TRUE(bends[0].T_S_end.isApprox(moved, 1e-12));
  EXPECT_TRUE(bends[1].T_S_begin.isApprox(moved, 1e-12));
  msg.T_S_end.pop_back();
  EXPECT_THROW(bends_of(msg), std::invalid_argument);
}
