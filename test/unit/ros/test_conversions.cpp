// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "voxnav_ros/conversions.hpp"

using namespace voxnav_ros;  // NOLINT: test
namespace geometry = voxnav::geometry;

namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

geometry::Pose random_pose(std::mt19937* rng) {
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  geometry::Pose pose = geometry::Pose::Identity();
  geometry::Vec3 axis(unit(*rng), unit(*rng), unit(*rng));
  pose.linear() = Eigen::AngleAxisd(3.1 * unit(*rng), axis.normalized()).toRotationMatrix();
  pose.translation() = 1e3 * geometry::Vec3(unit(*rng), unit(*rng), unit(*rng));
  return pose;
}

geometry_msgs::Pose message_of(double x, double y, double z, double qx, double qy, double qz, double qw) {
  geometry_msgs::Pose msg;
  msg.position.x = x;
  msg.position.y = y;
  msg.position.z = z;
  msg.orientation.x = qx;
  msg.orientation.y = qy;
  msg.orientation.z = qz;
  msg.orientation.w = qw;
  return msg;
}

TEST(Conversions, FramesHaveNoLeadingSlash) {
  EXPECT_EQ(voxnav_ros::frame_name("/os_lidar"), "os_lidar");
  EXPECT_EQ(voxnav_ros::frame_name("uav1/os_lidar"), "uav1/os_lidar");
  EXPECT_EQ(voxnav_ros::frame_name("//"), "");
  EXPECT_EQ(voxnav_ros::frame_name(""), "");
}

}  // namespace

TEST(Conversions, PosesComeBackAsTheyWere) {
  std::mt19937 rng(7);
  for (int i = 0; i < 200; ++i) {
    const geometry::Pose pose = random_pose(&rng);
    const auto as_pose = from_msg(to_msg(pose));
    const auto as_transform = from_msg(to_transform_msg(pose));
    ASSERT_TRUE(as_pose && as_transform);
    EXPECT_TRUE(as_pose->isApprox(pose, 1e-9));
    EXPECT_TRUE(as_transform->isApprox(pose, 1e-9));
  }
}

TEST(Conversions, APoseMessageMapsCoordinatesFromItsChildToItsParent) {
  // A quarter turn to the left maps x to y.
  const auto pose = from_msg(message_of(1.0, 2.0, 3.0, 0.0, 0.0, std::sqrt(0.5), std::sqrt(0.5)));
  ASSERT_TRUE(pose);
  EXPECT_TRUE((*pose * geometry::Vec3(1.0, 0.0, 0.0)).isApprox(geometry::Vec3(1.0, 3.0, 3.0), 1e-12));
}

TEST(Conversions, ASlightlyWrongQuaternionIsNormalised) {
  const auto pose = from_msg(message_of(0.0, 0.0, 0.0, 0.0, 0.0, 0.6 * 1.01, 0.8 * 1.01));
  ASSERT_TRUE(pose);
  EXPECT_TRUE((pose->linear() * pose->linear().transpose()).isIdentity(1e-12));
  EXPECT_NEAR(geometry::yaw_of(*pose), 2.0 * std::atan2(0.6, 0.8), 1e-12);
}

TEST(Conversions, InvalidPosesAreRefused) {
  EXPECT_FALSE(from_msg(geometry_msgs::Pose{}));  // a message that was not filled has a zero quaternion
  EXPECT_FALSE(from_msg(geometry_msgs::Transform{}));
  EXPECT_FALSE(from_msg(message_of(kNan, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)));
  EXPECT_FALSE(from_msg(message_of(0.0, kInf, 0.0, 0.0, 0.0, 0.0, 1.0)));
  EXPECT_FALSE(from_msg(message_of(0.0, 0.0, 0.0, kNan, 0.0, 0.0, 1.0)));
  EXPECT_FALSE(from_msg(message_of(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.9)));
  EXPECT_FALSE(from_msg(message_of(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.1)));
}

TEST(Conversions, StampsKeepTheirNanoseconds) {
  for (const voxnav::base::StampNs stamp_ns : {0LL, 1LL, 999999999LL, 1000000001LL, 1767225600123456789LL}) {
    EXPECT_EQ(to_ns(to_ros(stamp_ns)), stamp_ns);
  }
}

TEST(Conversions, StampsThatRosCannotHoldBecomeZero) { EXPECT_TRUE(to_ros(-5).isZero()); }

TEST(Conversions, PointsComeBackAsTheyWere) {
  const geometry::Vec3 point(1.25, -2.5, 1e-3);
  EXPECT_EQ(from_msg(to_msg(point)), point);
}
