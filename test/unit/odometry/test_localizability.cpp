// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <random>

#include "odometry/localizability.hpp"

namespace {

using namespace voxnav;  // NOLINT: test
using geometry::Vec3;
using odometry::Contribution;
using odometry::Localizability;
using odometry::Matrix6;

struct Matches {
  Matrix6 H = Matrix6::Zero();
  std::vector<Contribution> list;

  void add(const Vec3& normal, const Vec3& lever) {
    odometry::Vector6 J;
    J << normal, lever.cross(normal);
    H += J * J.transpose();
    list.push_back({normal.cast<float>(), lever.cast<float>()});
  }
  Localizability analyse() const { return odometry::analyse_localizability(list, 0.004, 0.004); }
};

/// Returns matches on walls, floor and ceiling of a corridor along x, whose normals have noise.
Matches corridor(double normal_noise, bool with_end) {
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0, normal_noise);
  std::uniform_real_distribution<double> along(-20, 20), across(-2, 2);
  Matches m;
  for (int i = 0; i < 2000; ++i) {
    const Vec3 n = (i % 2 ? Vec3(0, 1, 0) : Vec3(0, 0, 1)) + Vec3(noise(random), noise(random), noise(random));
    const double side = i % 4 < 2 ? 2.0 : -2.0;
    const Vec3 p = i % 2 ? Vec3(along(random), side, across(random)) : Vec3(along(random), across(random), side);
    m.add(n.normalized(), p);
  }
  for (int i = 0; i < 100 && with_end; ++i) m.add(Vec3(1, 0, 0), Vec3(20, across(random), across(random)));
  return m;
}

TEST(Localizability, FlagsTheAxisOfACorridorInSpiteOfNoisyNormals) {
  const Localizability l = corridor(0.08, false).analyse();
  ASSERT_EQ(l.weak_translations.size(), 1u);
  EXPECT_GT(std::abs(l.weak_translations[0].x()), 0.99);
  EXPECT_TRUE(l.weak_rotations.empty());
}

TEST(Localizability, AnEndWallHoldsTheCorridor) { EXPECT_FALSE(corridor(0.08, true).analyse().is_degenerate()); }

TEST(Localizability, OpenGroundHoldsHeightAndTiltOnly) {
  Matches m;
  for (int y = -10; y < 10; ++y) {
    for (int x = -10; x < 10; ++x) m.add(Vec3(0, 0, 1), Vec3(x, y, -2));
  }
  const Localizability l = m.analyse();
  EXPECT_EQ(l.weak_translations.size(), 2u);
  ASSERT_EQ(l.weak_rotations.size(), 1u);
  EXPECT_GT(std::abs(l.weak_rotations[0].z()), 0.99);
}

// The result must not depend on the unit of length: a scene ten times as large has the same information per match.
TEST(Localizability, DoesNotDependOnTheScaleOfTheScene) {
  Matches small, large;
  std::mt19937 random(9);
  std::normal_distribution<double> d(0, 1);
  for (int i = 0; i < 500; ++i) {
    const Vec3 n = Vec3(d(random), d(random), d(random)).normalized();
    const Vec3 p(d(random), d(random), d(random));
    small.add(n, p);
    large.add(n, 10 * p);
  }
  const auto a = small.analyse().eigenvalues, b = large.analyse().eigenvalues;
  for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(a[i], b[i], 1e-3);
}

TEST(Localizability, WeakDirectionsCarryNoInformationAfterRemoval) {
  const Matches m = corridor(0.08, false);
  const Localizability l = m.analyse();
  odometry::Vector6 x;
  x << l.weak_translations[0], Vec3::Zero();
  EXPECT_GT(x.dot(m.H * x), 1.0);
  EXPECT_LT(x.dot(odometry::without_weak_directions(m.H, l) * x), 1e-6);
}

}  // namespace
