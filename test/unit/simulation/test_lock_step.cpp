// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "voxnav_simulation/lock_step.hpp"

namespace {

using voxnav_simulation::LockStep;
using Names = std::vector<std::string>;
constexpr std::int64_t kMs = 1'000'000;

TEST(LockStep, DoesNotWaitForNodesThatHaveNotStartedYet) {
  const LockStep lock({"a", "b"}, 100 * kMs);
  EXPECT_TRUE(lock.missing(5000 * kMs).empty());
  EXPECT_EQ(lock.unseen(), (Names{"a", "b"}));
}

TEST(LockStep, WaitsForTheSlowestNode) {
  LockStep lock({"a", "b"}, 100 * kMs);
  lock.report("a", 1000 * kMs);
  lock.report("b", 900 * kMs);
  EXPECT_TRUE(lock.missing(1000 * kMs).empty());
  EXPECT_EQ(lock.missing(1001 * kMs), Names{"b"});
  EXPECT_EQ(lock.missing(1101 * kMs), (Names{"a", "b"}));
  lock.report("b", 1200 * kMs);
  EXPECT_EQ(lock.missing(1101 * kMs), Names{"a"});
}

TEST(LockStep, OlderReportsDoNotTakeBackNewerOnes) {
  LockStep lock({"a"}, 0);
  lock.report("a", 1000 * kMs);
  lock.report("a", 500 * kMs);
  EXPECT_TRUE(lock.missing(1000 * kMs).empty());
}

TEST(LockStep, LeavesASilentNodeBehindUntilItIsBack) {
  LockStep lock({"a"}, 0);
  EXPECT_FALSE(lock.report("a", 0));
  lock.leave_behind("a");
  EXPECT_TRUE(lock.missing(1000 * kMs).empty());
  EXPECT_TRUE(lock.report("a", 1000 * kMs));
  EXPECT_EQ(lock.missing(1001 * kMs), Names{"a"});
}

TEST(LockStep, IgnoresNodesItDoesNotKnow) {
  LockStep lock({"a"}, 0);
  lock.report("stranger", 0);
  EXPECT_TRUE(lock.missing(1000 * kMs).empty());
  EXPECT_EQ(lock.unseen(), Names{"a"});
}

}  // namespace
