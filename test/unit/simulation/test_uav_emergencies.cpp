// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "voxnav_simulation/uav.hpp"

namespace {

using namespace voxnav_simulation;  // NOLINT: test

UavSetup undrifting() {
  UavSetup setup;
  setup.drift.bound_m = 0;
  return setup;
}

void fly(Uav* uav, double duration_s) {
  for (int i = 0; i < static_cast<int>(std::lround(duration_s / kStep_s)); ++i) uav->step();
}

void take_off(Uav* uav) {
  ASSERT_TRUE(uav->take_off().success);
  for (int i = 0; i < 4000 && uav->phase() != FlightPhase::kFlying; ++i) uav->step();
  ASSERT_TRUE(uav->is_flying_normally());
}

/// Returns a vehicle that flies fast towards a far goal.
Uav moving_uav(const UavSetup& setup = undrifting()) {
  Uav uav(setup, 1);
  take_off(&uav);
  EXPECT_TRUE(uav.go_to({{100, 0, 5}, 0}).success);
  fly(&uav, 5);
  EXPECT_GT(uav.truth().velocity.x(), 3.0);
  return uav;
}

TEST(UavEmergencies, AnEmergencyHoverLastsUntilAllOfItIsTakenBack) {
  Uav uav = moving_uav();
  ASSERT_TRUE(uav.ehover().success);
  EXPECT_FALSE(uav.is_flying_normally());
  fly(&uav, 5);
  EXPECT_LT(uav.truth().velocity.norm(), 0.01);
  EXPECT_FALSE(uav.hover().success);
  EXPECT_FALSE(uav.go_to({{0, 0, 2}, 0}).success);
  EXPECT_TRUE(uav.switch_to_normal_controller().success);
  uav.enable_callbacks(true);
  EXPECT_FALSE(uav.is_flying_normally());  // the tracker is still that of take-off and landing
  EXPECT_FALSE(uav.go_to({{0, 0, 2}, 0}).success);
  EXPECT_TRUE(uav.switch_to_normal_tracker().success);
  EXPECT_TRUE(uav.is_flying_normally());
  EXPECT_TRUE(uav.go_to({{0, 0, 2}, 0}).success);
}

TEST(UavEmergencies, EmergencyLandingAndFailsafeEndOnTheGround) {
  for (const bool is_failsafe : {false, true}) {
    Uav uav = moving_uav();
    ASSERT_TRUE((is_failsafe ? uav.failsafe() : uav.eland()).success);
    EXPECT_EQ(uav.controller(), is_failsafe ? ActiveController::kFailsafe : ActiveController::kEmergency);
    EXPECT_FALSE(uav.is_flying_normally());
    EXPECT_FALSE(uav.eland().success);
    EXPECT_FALSE(uav.ehover().success);
    EXPECT_FALSE(uav.hover().success);
    EXPECT_FALSE(uav.switch_to_normal_tracker().success);
    EXPECT_EQ(uav.failsafe().success, !is_failsafe);  // which is the stronger one
    fly(&uav, 20);
    EXPECT_EQ(uav.phase(), FlightPhase::kIdle);
    take_off(&uav);
  }
}

TEST(UavEmergencies, StandingOnTheGroundThereAreNone) {
  Uav uav(undrifting(), 1);
  EXPECT_EQ(uav.ehover().message, "can not trigger ehover while not flying");
  EXPECT_EQ(uav.eland().message, "can not trigger eland while not flying");
  EXPECT_EQ(uav.failsafe().message, "can not trigger failsafe while not flying");
}

TEST(UavEmergencies, ABumperThatHeedsSectorsStaysAsItIsWithoutThem) {
  UavSetup setup = undrifting();
  setup.faults.bumper.is_enabled = setup.faults.bumper.heeds_sectors = true;
  setup.faults.bumper.is_derived_from_dynamics = false;
  Uav uav(setup, 1);
  take_off(&uav);
  fly(&uav, 1);
  EXPECT_TRUE(uav.is_flying_normally());  // it was never told anything
  SectorRanges sectors{{std::nullopt, std::nullopt, 1.0, std::nullopt}, std::nullopt, std::nullopt};
  uav.set_sectors(sectors);
  fly(&uav, 0.5);
  EXPECT_TRUE(uav.is_repelled());
  fly(&uav, 3.0);
  EXPECT_TRUE(uav.is_repelled());  // the messages have ceased
  EXPECT_FALSE(uav.go_to({{0, 0, 2}, 0}).success);
  EXPECT_GT(uav.truth().pose.translation().x(), 0.3);  // away from what was seen behind
  sectors.horizontal_m[2] = 1.3;
  uav.set_sectors(sectors);
  fly(&uav, 0.1);
  EXPECT_FALSE(uav.is_repelled());
  EXPECT_TRUE(uav.go_to({{0, 0, 2}, 0}).success);
}

}  // namespace
