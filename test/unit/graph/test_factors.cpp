// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <random>

#include "graph/factors.hpp"

using namespace voxnav::graph;  // NOLINT: test

namespace {

std::mt19937& rng() {
  static std::mt19937 generator(11);
  return generator;
}
double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(rng()); }
Pose4 random_pose() { return {uniform(-20, 20), uniform(-20, 20), uniform(-5, 5), uniform(-3.14, 3.14)}; }
Matrix4 random_information() {
  Matrix4 m;
  for (int i = 0; i < 16; ++i) m(i / 4, i % 4) = uniform(-1, 1);
  return m * m.transpose() + 0.1 * Matrix4::Identity();
}

/// Returns the Jacobian of f at x by central differences, one column per parameter.
template <class F>
Eigen::MatrixXd numeric(const F& f, const Pose4& x) {
  constexpr double kStep = 1e-6;
  Eigen::MatrixXd out(f(x).size(), 4);
  for (int k = 0; k < 4; ++k) {
    Pose4 plus = x;
    Pose4 minus = x;
    plus[k] += kStep;
    minus[k] -= kStep;
    out.col(k) = (f(plus) - f(minus)) / (2 * kStep);
  }
  return out;
}

}  // namespace

TEST(Pose4, RelativeUndoesCompose) {
  for (int i = 0; i < 100; ++i) {
    const Pose4 a = random_pose();
    const Pose4 b = random_pose();
    const Pose4 d = relative(a, compose(a, b)) - b;
    EXPECT_LT(d.head<3>().norm(), 1e-9);
    EXPECT_LT(std::abs(voxnav::geometry::wrap_angle(d[3])), 1e-9);
    EXPECT_TRUE(to_pose(compose(a, b)).isApprox(to_pose(a) * to_pose(b), 1e-9));
  }
}

TEST(Pose4, RefusesTiltAndNonFinite) {
  voxnav::geometry::Pose tilted = voxnav::geometry::Pose::Identity();
  tilted.linear() = Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitX()).matrix();
  EXPECT_THROW(to_pose4(tilted, "T"), std::invalid_argument);
  voxnav::geometry::Pose broken = voxnav::geometry::Pose::Identity();
  broken.translation().x() = std::nan("");
  EXPECT_THROW(to_pose4(broken, "T"), std::invalid_argument);
}

TEST(Whitening, GivesTheQuadraticFormOfTheInformation) {
  for (int i = 0; i < 100; ++i) {
    const Matrix4 information = random_information();
    const Pose4 e = random_pose();
    const double expected = e.dot(information * e);
    EXPECT_NEAR((whitening_of(information, "I") * e).squaredNorm(), expected, 1e-9 * expected);
  }
}

TEST(Whitening, TakesSemiDefiniteAndRefusesIndefinite) {
  Matrix4 information = Matrix4::Zero();
  information(2, 2) = 4.0;
  const Matrix4 M = whitening_of(information, "I");
  EXPECT_TRUE((M.transpose() * M).isApprox(information, 1e-12));
  information(0, 0) = -1.0;
  EXPECT_THROW(whitening_of(information, "I"), std::invalid_argument);
  information(0, 0) = std::nan("");
  EXPECT_THROW(whitening_of(information, "I"), std::invalid_argument);
  Matrix4 skewed = Matrix4::Identity();
  skewed(0, 1) = 0.5;
  EXPECT_THROW(whitening_of(skewed, "I"), std::invalid_argument);
}

TEST(Whitening, OfCovarianceIsItsInverse) {
  Eigen::Matrix3d covariance;
  covariance << 2, 0.3, 0.1, 0.3, 1, 0.2, 0.1, 0.2, 0.5;
  const Eigen::Matrix3d M = whitening_of_covariance(covariance, "C");
  EXPECT_TRUE((M.transpose() * M).isApprox(covariance.inverse(), 1e-9));
  EXPECT_THROW(whitening_of_covariance(Eigen::Matrix3d::Zero(), "C"), std::invalid_argument);
}

TEST(RelativePoseFactor, AnalyticJacobiansEqualNumericOnes) {
  for (int i = 0; i < 50; ++i) {
    const Pose4 a = random_pose();
    const Pose4 b = random_pose();
    // The measurement is near the truth, so that the step of the differences does not cross the wrap of yaw.
    RelativePoseFactor factor{relative(a, b) + 0.1 * random_pose() / 20.0, whitening_of(random_information(), "I")};
    Matrix4 J_a;
    Matrix4 J_b;
    factor.evaluate(a, b, &J_a, &J_b);
    EXPECT_LT((J_a - numeric([&](const Pose4& x) { return factor.evaluate(x, b, nullptr, nullptr); }, a)).norm(), 1e-5);
    EXPECT_LT((J_b - numeric([&](const Pose4& x) { return factor.evaluate(a, x, nullptr, nullptr); }, b)).norm(), 1e-5);
  }
}

TEST(RelativePoseFactor, YawErrorIsWrapped) {
  const RelativePoseFactor factor{Pose4(0, 0, 0, 3.1), Matrix4::Identity()};
  const Pose4 error = factor.evaluate(Pose4::Zero(), Pose4(0, 0, 0, -3.1), nullptr, nullptr);
  EXPECT_NEAR(error[3], 2.0 * M_PI - 6.2, 1e-12);
}

TEST(PositionFactor, AnalyticJacobiansEqualNumericOnes) {
  for (int i = 0; i < 50; ++i) {
    const Pose4 pose = random_pose();
    const Pose4 datum = random_pose();
    const PositionFactor factor{random_pose().head<3>(), random_pose().head<3>(),
                                random_information().topLeftCorner<3, 3>()};
    PositionFactor::Jacobian J_pose;
    PositionFactor::Jacobian J_datum;
    factor.evaluate(pose, datum, &J_pose, &J_datum);
    const auto of_pose = [&](const Pose4& x) { return factor.evaluate(x, datum, nullptr, nullptr); };
    const auto of_datum = [&](const Pose4& x) { return factor.evaluate(pose, x, nullptr, nullptr); };
    EXPECT_LT((J_pose - numeric(of_pose, pose)).norm(), 1e-5);
    EXPECT_LT((J_datum - numeric(of_datum, datum)).norm(), 1e-5);
  }
}

TEST(SeenAt, MovesByItsShareOfTheNeighboursCorrection) {
  for (const bool is_before : {false, true}) {
    const Pose4 own = random_pose();
    const Pose4 step(uniform(-5, 5), uniform(-5, 5), uniform(-1, 1), 0.3);
    // A neighbour whose pose agrees with odometry does not move the submap.
    const Pose4 neighbour = is_before ? compose(own, relative(step, Pose4::Zero())) : compose(own, step);
    const SeenAt at{0.3, is_before, step.head<3>()};
    EXPECT_LT((at.evaluate(own, neighbour, nullptr, nullptr) - own).norm(), 1e-9);
    // A neighbour that was corrected moves the submap by the share of its correction.
    const Pose4 drift(1.0, -2.0, 0.5, 0.0);
    EXPECT_LT((at.evaluate(own, neighbour + drift, nullptr, nullptr) - (own + 0.3 * drift)).norm(), 1e-9);
  }
}

TEST(SeenAt, AnalyticJacobiansEqualNumericOnes) {
  for (int i = 0; i < 50; ++i) {
    const Pose4 own = random_pose();
    const Pose4 neighbour = random_pose();
    const SeenAt at{uniform(0, 0.5), i % 2 == 0, Eigen::Vector3d(uniform(-9, 9), uniform(-9, 9), uniform(-2, 2))};
    Matrix4 of_own;
    Matrix4 of_neighbour;
    at.evaluate(own, neighbour, &of_own, &of_neighbour);
    const auto by_own = [&](const Pose4& x) { return at.evaluate(x, neighbour, nullptr, nullptr); };
    const auto by_neighbour = [&](const Pose4& x) { return at.evaluate(own, x, nullptr, nullptr); };
    EXPECT_LT((of_own - numeric(by_own, own)).norm(), 1e-6);
    EXPECT_LT((of_neighbour - numeric(by_neighbour, neighbour)).norm(), 1e-6);
  }
}
