// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "voxnav/graph/trajectory.hpp"

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
    out.push_back({(5 + 10 * k) * 1'000'000'000LL, T_O_S, T_W_S});
  }
  return out;
}

}  // namespace

TEST(CorrectTrajectory, LeavesItAloneWhenNothingMoved) {
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

TEST(CorrectTrajectory, MeetsEachSubmapInItsMiddle) {
  const auto flight = straight_flight();
  const auto corrections = bent_submaps();
  const auto out = correct_trajectory(flight, corrections);
  for (const SubmapCorrection& c : corrections) {
    const auto i = static_cast<std::size_t>(c.stamp_ns / 100'000'000LL);
    EXPECT_TRUE(out[i].pose.isApprox(c.T_W_S * c.T_O_S.inverse() * flight[i].pose, 1e-9));
  }
}

TEST(CorrectTrajectory, RefusesUnorderedSubmaps) {
  std::vector<SubmapCorrection> corrections = bent_submaps();
  std::swap(corrections[0], corrections[1]);
  EXPECT_THROW(correct_trajectory(straight_flight(), corrections), std::invalid_argument);
  EXPECT_THROW(correct_trajectory(straight_flight(), {}), std::invalid_argument);
}
