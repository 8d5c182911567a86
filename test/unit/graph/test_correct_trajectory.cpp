// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "voxnav/graph/correct_trajectory.hpp"

using namespace voxnav;         // NOLINT: test
using namespace voxnav::graph;  // NOLINT: test

namespace {

std::vector<geometry::StampedPose> straight_flight() {
  std::vector<geometry::StampedPose> out;
  for (int i = 0; i <= 300; ++i) {
    out.push_back({i * 100'000'000LL, geometry::from_position_yaw({1000.0 + 0.2 * i, 0, 5}, 0.0)});
  }
  return out;
}

std::vector<SubmapCorrection> bent_submaps() {
  std::vector<SubmapCorrection> out;
  for (int k = 0; k < 3; ++k) {
    const geometry::Pose T_O_S = geometry::from_position_yaw({1000.0 + 20.0 * k, 0, 5}, 0.0);
    const geometry::Pose T_W_S = geometry::from_position_yaw({1000.0 + 20.0 * k, 0.5 * k * k, 5}, 0.05 * k);
    out.push_back({k * 10'000'000'000LL, (k + 1) * 10'000'000'000LL, T_O_S, T_W_S});
  }
  return out;
}

}  // namespace

TEST(CorrectTrajectory, ChangesNothingWithoutCorrections) {
  std::vector<SubmapCorrection> corrections = bent_submaps();
  for (SubmapCorrection& c : corrections) c.T_W_S = c.T_O_S;
  const auto flight = straight_flight();
  const auto out = correct_trajectory(flight, corrections);
  for (std::size_t i = 0; i < flight.size(); ++i) EXPECT_TRUE(out[i].pose.isApprox(flight[i].pose, 1e-9));
}

TEST(CorrectTrajectory, HasNoStepsFarFromTheOrigin) {
  const auto out = correct_trajectory(straight_flight(), bent_submaps());
  for (std::size_t i = 1; i < out.size(); ++i) {
    EXPECT_LT((out[i].pose.translation() - out[i - 1].pose.translation()).norm(), 0.35) << i;
    EXPECT_LT(std::abs(geometry::yaw_of(out[i].pose) - geometry::yaw_of(out[i - 1].pose)), 0.01);
  }
}

TEST(CorrectTrajectory, AppliesTheCorrectionOfEachSubmapInItsMiddle) {
  const auto flight = straight_flight();
  const auto corrections = bent_submaps();
  const auto out = correct_trajectory(flight, corrections);
  for (const SubmapCorrection& c : corrections) {
    const auto i = static_cast<std::size_t>(c.middle_ns() / 100'000'000LL);
    EXPECT_TRUE(out[i].pose.isApprox(c.T_W_S * c.T_O_S.inverse() * flight[i].pose, 1e-9));
  }
}

TEST(CorrectTrajectory, RefusesUnorderedSubmaps) {
  std::vector<SubmapCorrection> corrections = bent_submaps();
  std::swap(corrections[0], corrections[1]);
  EXPECT_THROW(correct_trajectory(straight_flight(), corrections), std::invalid_argument);
  EXPECT_THROW(correct_trajectory(straight_flight(), {}), std::invalid_argument);
}

/// Content that was observed from a pose of the trajectory is corrected as that pose is.
TEST(BendsOf, ContentFollowsTheTrajectory) {
  const auto flight = straight_flight();
  const auto corrections = bent_submaps();
  const auto trajectory = correct_trajectory(flight, corrections);
  const std::vector<geometry::Bend> bends = bends_of(corrections, 10.0);
  ASSERT_EQ(bends.size(), corrections.size());
  for (std::size_t i = 0; i < flight.size(); ++i) {
    const std::size_t k = std::min<std::size_t>(i / 100, 2);
    const SubmapCorrection& c = corrections[k];
    const double phase = static_cast<double>(flight[i].stamp_ns - c.start_ns) / 10e9;
    const geometry::Pose T_S_B = c.T_O_S.inverse() * flight[i].pose;
    // Bends interpolate about the origin of the submap and trajectories about the body, which differ by the arc of a
    // small rotation.
    EXPECT_TRUE((c.T_W_S * bends[k].at(phase) * T_S_B).isApprox(trajectory[i].pose, 1e-5)) << i;
  }
}

TEST(BendsOf, NeighboursMeetAndTheEndsOfTheFlightStayRigid) {
  const auto corrections = bent_submaps();
  const std::vector<geometry::Bend> bends = bends_of(corrections, 10.0);
  for (std::size_t k = 1; k < bends.size(); ++k) {
    const SubmapCorrection &a = corrections[k - 1], &b = corrections[k];
    const geometry::Pose T_Sa_Sb = a.T_O_S.inverse() * b.T_O_S;
    EXPECT_TRUE((a.T_W_S * bends[k - 1].T_S_end * T_Sa_Sb).isApprox(b.T_W_S * bends[k].T_S_begin, 1e-3));
  }
  EXPECT_TRUE(bends.front().T_S_begin.isApprox(geometry::Pose::Identity()));
  EXPECT_TRUE(bends.back().T_S_end.isApprox(geometry::Pose::Identity()));
}

TEST(BendsOf, AJumpOfOdometryBendsNothing) {
  std::vector<SubmapCorrection> corrections = bent_submaps();
  corrections[2].T_W_S.translation().x() += 7.0;  // if this were drift, it would be 3.5 m for each of the two submaps
  const std::vector<geometry::Bend> bends = bends_of(corrections, 1.0);
  EXPECT_TRUE(bends[1].T_S_end.isApprox(geometry::Pose::Identity()));
  EXPECT_TRUE(bends[2].T_S_begin.isApprox(geometry::Pose::Identity()));
  EXPECT_FALSE(bends[0].T_S_end.isApprox(geometry::Pose::Identity()));
  EXPECT_TRUE(bends_of({}, 1.0).empty());
  std::swap(corrections[0], corrections[1]);
  EXPECT_THROW(bends_of(corrections, 1.0), std::invalid_argument);
}
