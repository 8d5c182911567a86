// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "voxnav/odometry/imu_gate.hpp"

namespace {

using namespace voxnav;  // NOLINT: test
using odometry::ImuGate;

/// Returns a sweep of 0.1 s.
cloud::Sweep sweep_at(double stamp_s) {
  cloud::Sweep out;
  out.start_ns = base::from_seconds(stamp_s);
  out.duration_ns = 100'000'000;
  return out;
}

TEST(ImuGate, ASweepWaitsForTheSamplesThatCoverIt) {
  ImuGate gate({true, 0.5, 0.03});
  gate.note_imu(base::from_seconds(10.0));
  gate.add(sweep_at(10.0), 0.0);
  EXPECT_FALSE(gate.next(0.0));
  gate.note_imu(base::from_seconds(10.09));
  EXPECT_FALSE(gate.next(0.0));
  gate.note_imu(base::from_seconds(10.1));
  EXPECT_TRUE(gate.next(0.0));
  EXPECT_FALSE(gate.next(0.0));
}

TEST(ImuGate, SweepsDoNotWaitForAnImuThatIsSilentUnknownOrNotUsed) {
  ImuGate unknown({true, 0.5, 0.03});
  unknown.add(sweep_at(10.0), 0.0);
  EXPECT_TRUE(unknown.next(0.0));
  ImuGate silent({true, 0.5, 0.03});
  silent.note_imu(base::from_seconds(9.0));
  silent.add(sweep_at(10.0), 0.0);
  EXPECT_TRUE(silent.next(0.0));
  ImuGate unused({false, 0.5, 0.03});
  unused.note_imu(base::from_seconds(10.0));
  unused.add(sweep_at(10.0), 0.0);
  EXPECT_TRUE(unused.next(0.0));
}

TEST(ImuGate, SweepsWaitForALimitedTime) {
  ImuGate gate({true, 0.5, 0.03});
  gate.note_imu(base::from_seconds(10.0));
  gate.add(sweep_at(10.0), 5.0);
  EXPECT_FALSE(gate.next(5.02));
  EXPECT_TRUE(gate.next(5.04));
  for (std::size_t i = 0; i <= ImuGate::kMaxWaiting; ++i) gate.add(sweep_at(10.0), 5.0);
  EXPECT_TRUE(gate.next(5.0));
  EXPECT_FALSE(gate.next(5.0));
  EXPECT_TRUE(gate.take_oldest());
}

}  // namespace
