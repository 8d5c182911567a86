// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "voxnav_simulation/lock_step.hpp"

namespace {

using voxnav_simulation::LockStep;
using Names = std::vector<std::string>;
constexpr std::int64_t kMs = 1'000'000;

TEST(LockStep, DoesNotWaitForNodesThatHaveNotStartedYet) {
  const LockStep lock({{"a", "b"}, 100 * kMs, 0, ""});
  EXPECT_TRUE(lock.missing(5000 * kMs).empty());
  EXPECT_EQ(lock.unseen(), (Names{"a", "b"}));
}

TEST(LockStep, WaitsForTheSlowestNode) {
  LockStep lock({{"a", "b"}, 100 * kMs, 0, ""});
  lock.report("a", 1000 * kMs);
  lock.report("b", 900 * kMs);
  EXPECT_TRUE(lock.missing(1000 * kMs).empty());
  EXPECT_EQ(lock.missing(1001 * kMs), Names{"b"});
  EXPECT_EQ(lock.missing(1101 * kMs), (Names{"a", "b"}));
  lock.report("b", 1200 * kMs);
  EXPECT_EQ(lock.missing(1101 * kMs), Names{"a"});
}

TEST(LockStep, OlderReportsDoNotReplaceNewerOnes) {
  LockStep lock({{"a"}, 0, 0, ""});
  lock.report("a", 1000 * kMs);
  lock.report("a", 500 * kMs);
  EXPECT_TRUE(lock.missing(1000 * kMs).empty());
}

TEST(LockStep, LeavesASilentNodeBehindUntilItIsBack) {
  LockStep lock({{"a"}, 0, 0, ""});
  EXPECT_FALSE(lock.report("a", 0));
  lock.leave_behind("a");
  EXPECT_TRUE(lock.missing(1000 * kMs).empty());
  EXPECT_TRUE(lock.report("a", 1000 * kMs));
  EXPECT_EQ(lock.missing(1001 * kMs), Names{"a"});
}

TEST(LockStep, TimeStandsStillAtBarriersOnly) {
  LockStep lock({{"a"}, 100 * kMs, 100 * kMs, ""});
  lock.report("a", 900 * kMs);
  EXPECT_TRUE(lock.missing(1000 * kMs).empty());
  EXPECT_TRUE(lock.missing(1100 * kMs).empty()) << "all the way from one barrier to the next";
  EXPECT_EQ(lock.missing(1101 * kMs), Names{"a"}) << "not beyond it";
  lock.report("a", 1000 * kMs);
  EXPECT_TRUE(lock.missing(1200 * kMs).empty());
}

TEST(LockStep, AnnouncedWorkHoldsTimeUntilItIsDone) {
  LockStep lock({{}, 0, 0, ""});
  lock.begin("b", 500 * kMs);
  lock.begin("b", 500 * kMs);
  EXPECT_EQ(lock.missing(510 * kMs), Names{"b"});
  lock.report("b", 500 * kMs);
  EXPECT_EQ(lock.missing(510 * kMs), Names{"b"}) << "it was sent two things";
  lock.report("b", 500 * kMs);
  EXPECT_TRUE(lock.missing(510 * kMs).empty());
  lock.report("b", 600 * kMs);
  lock.begin("b", 600 * kMs);
  EXPECT_TRUE(lock.missing(610 * kMs).empty()) << "the announcement may be overtaken";
  lock.begin("b", 700 * kMs);
  lock.leave_behind("b");
  EXPECT_TRUE(lock.missing(710 * kMs).empty());
}

TEST(LockStep, TheLeaderLimitsHowFarTimeRuns) {
  LockStep lock({{}, 100 * kMs, 100 * kMs, "mission"});
  EXPECT_TRUE(lock.is_waiting_for_leader());
  EXPECT_EQ(lock.missing(10 * kMs), Names{"mission"});
  lock.report("mission", 250 * kMs);
  EXPECT_FALSE(lock.is_waiting_for_leader());
  EXPECT_TRUE(lock.missing(250 * kMs).empty());
  EXPECT_EQ(lock.missing(251 * kMs), Names{"mission"});
  lock.leave_behind("mission");
  EXPECT_TRUE(lock.missing(251 * kMs).empty());
  EXPECT_TRUE(lock.report("mission", 300 * kMs));
}

TEST(LockStep, IgnoresNodesItDoesNotKnow) {
  LockStep lock({{"a"}, 0, 0, ""});
  lock.report("stranger", 0);
  EXPECT_TRUE(lock.missing(1000 * kMs).empty());
  EXPECT_EQ(lock.unseen(), Names{"a"});
}

}  // namespace
