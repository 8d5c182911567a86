// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <sstream>

#include "graph/g2o.hpp"
#include "voxnav/graph/submap_graph.hpp"

using namespace voxnav::graph;  // NOLINT: test

namespace {

std::string fault(const std::string& text) {
  try {
    read_g2o(text);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "accepted";
}

}  // namespace

TEST(G2o, ReadsWhatItWrote) {
  G2o file;
  file.vertices[3] = Pose4(1, 2, 3, -2.5);
  file.vertices[7] = Pose4(-4, 5.5, 0.25, 3.0);
  Matrix4 information = Matrix4::Identity() * 10.0;
  information(0, 3) = information(3, 0) = 0.5;
  information(1, 2) = information(2, 1) = -1.5;
  file.edges.push_back({3, 7, Pose4(0.1, 0.2, 0.3, -0.4), information});
  const G2o copy = read_g2o(write_g2o(file));
  ASSERT_EQ(copy.vertices.size(), 2u);
  ASSERT_EQ(copy.edges.size(), 1u);
  EXPECT_TRUE(copy.vertices.at(3).isApprox(file.vertices.at(3), 1e-12));
  EXPECT_TRUE(copy.vertices.at(7).isApprox(file.vertices.at(7), 1e-12));
  EXPECT_TRUE(copy.edges[0].T_a_b.isApprox(file.edges[0].T_a_b, 1e-12));
  EXPECT_TRUE(copy.edges[0].information.isApprox(information, 1e-12));
}

TEST(G2o, InformationBelongsToTheMeasuredFrame) {
  // The x axis of the measured frame points along y of frame a, so information about x holds y of frame a.
  const G2o file = read_g2o(
      "VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\nVERTEX_SE3:QUAT 1 4 2 0 0 0 0.7071067811865476 0.7071067811865476\n"
      "EDGE_SE3:QUAT 0 1 4 2 0 0 0 0.7071067811865476 0.7071067811865476 "
      "100 0 0 0 0 7  1 0 0 0 3  5 0 0 0  1 0 0  1 0  50\n");
  const Matrix4& information = file.edges.at(0).information;
  Matrix4 expected;
  expected << 1, 0, 0, -3, 0, 100, 0, 7, 0, 0, 5, 0, -3, 7, 0, 50;
  EXPECT_TRUE(information.isApprox(expected, 1e-12)) << information;
}

TEST(G2o, SolutionWeighsEdgesInTheirMeasuredFrames) {
  // All edges have the same yaw, so that the cost of g2o is quadratic in the position of vertex 1, with its minimum at
  // (Σ R Ωᵢ Rᵀ)⁻¹ Σ R Ωᵢ Rᵀ tᵢ. Vertex 0 is rotated as well, so that no frame is that of the map.
  const double yaw_a = 0.4, yaw = 1.1;
  const Eigen::Rotation2Dd R(yaw);
  const Eigen::Vector2d t[2] = {{4.0, 2.0}, {4.6, 1.7}};
  const Eigen::Vector2d weight[2] = {{400.0, 1.0}, {2.0, 90.0}};
  std::string text = "VERTEX_SE2 0 5 -3 " + std::to_string(yaw_a) + "\nVERTEX_SE2 1 9 0 1.5\n";
  Eigen::Matrix2d sum = Eigen::Matrix2d::Zero();
  Eigen::Vector2d weighted = Eigen::Vector2d::Zero();
  for (int i = 0; i < 2; ++i) {
    text += "EDGE_SE2 0 1 " + std::to_string(t[i].x()) + " " + std::to_string(t[i].y()) + " " + std::to_string(yaw) +
            " " + std::to_string(weight[i].x()) + " 0 0 " + std::to_string(weight[i].y()) + " 0 1000\n";
    const Eigen::Matrix2d information = R.matrix() * weight[i].asDiagonal() * R.matrix().transpose();
    sum += information;
    weighted += information * t[i];
  }
  SubmapGraph graph = SubmapGraph::from_g2o(text);
  graph.optimize();
  const Eigen::Vector2d expected =
      Eigen::Vector2d(5, -3) + Eigen::Rotation2Dd(yaw_a) * (sum.inverse() * weighted).eval();
  const auto solved = graph.poses().at(1);
  EXPECT_NEAR(solved.translation().x(), expected.x(), 1e-6);
  EXPECT_NEAR(solved.translation().y(), expected.y(), 1e-6);
  EXPECT_NEAR(voxnav::geometry::yaw_of(solved), yaw_a + yaw, 1e-6);
}

TEST(G2o, WhatIsWrittenHasTheSameCostByTheDefinitionOfG2o) {
  // The residual of this repository, M [R_aᵀ (t_b − t_a) − t̂; yaw], is compared with that of g2o, T̂⁻¹ T_a_b, whose
  // numbers are those of the written line.
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  for (int trial = 0; trial < 50; ++trial) {
    const Matrix4 root = Matrix4::NullaryExpr([&] { return normal(random); });
    const Pose4 T_a_b = Pose4::NullaryExpr([&] { return normal(random); });
    const Pose4 seen = T_a_b + 0.1 * Pose4::NullaryExpr([&] { return normal(random); });
    const Matrix4 information = root * root.transpose();
    G2o file;
    file.vertices[0] = file.vertices[1] = Pose4::Zero();
    file.edges.push_back({0, 1, T_a_b, information});
    std::istringstream line(write_g2o(file));
    std::string word;
    while (word != "EDGE_SE3:QUAT") line >> word;
    double numbers[2 + 7 + 21];
    for (double& number : numbers) line >> number;
    Eigen::Matrix<double, 6, 6> written;
    const double* next = numbers + 9;
    for (int i = 0; i < 6; ++i) {
      for (int j = i; j < 6; ++j) written(i, j) = written(j, i) = *next++;
    }
    const Pose4 by_g2o = relative(T_a_b, seen);
    Eigen::Matrix<double, 6, 1> error = Eigen::Matrix<double, 6, 1>::Zero();
    error << by_g2o.head<3>(), 0, 0, by_g2o[3];
    const Pose4 ours = seen - T_a_b;
    EXPECT_NEAR(error.dot(written * error), ours.dot(information * ours), 1e-9);
  }
}

TEST(G2o, ReadsPlanarFiles) {
  const G2o file = read_g2o(
      "# comment\nVERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0.5 1.57\nFIX 0\nEDGE_SE2 0 1 1 0.4 1.5 11 12 13 22 23 33\n");
  EXPECT_EQ(file.vertices.at(1), Pose4(1, 0.5, 0, 1.57));
  const Matrix4& information = file.edges.at(0).information;
  const double c = std::cos(1.5), s = std::sin(1.5);
  EXPECT_NEAR(information(0, 0), 11 * c * c - 2 * 12 * c * s + 22 * s * s, 1e-12);
  EXPECT_NEAR(information(0, 1), 12 * (c * c - s * s) + (11 - 22) * c * s, 1e-12);
  EXPECT_NEAR(information(0, 3), 13 * c - 23 * s, 1e-12);
  EXPECT_NEAR(information(1, 3), 13 * s + 23 * c, 1e-12);
  EXPECT_EQ(information(3, 3), 33);
  EXPECT_EQ(information(2, 2), 22);
}

TEST(G2o, ReadsParametersFixAndKeysOfGtsam) {
  const std::string x = "86469112845513523";  // the beginning of keys of GTSAM with 'x' in the highest byte
  const G2o file = read_g2o("PARAMS_SE3OFFSET 0 0 0 0 0 0 0 1\nVERTEX_SE2 " + x + "25 1 0 0  # comment\nVERTEX_SE2 " +
                            x + "22 0 0 0\nFIX " + x + "22\nEDGE_SE2 " + x + "22 " + x + "25 1 0 0 1 0 0 1 0 1\n");
  ASSERT_EQ(file.vertices.size(), 2u);
  EXPECT_EQ(file.vertices.at(5), Pose4(1, 0, 0, 0));
  EXPECT_EQ(file.edges.at(0).a, 2);
  EXPECT_EQ(file.edges.at(0).b, 5);
  EXPECT_NE(fault("VERTEX_SE2 " + x + "25 1 0 0\nVERTEX_SE2 4 0 0 0\n").find("line 2 has a key with another letter"),
            std::string::npos);
  EXPECT_EQ(fault("VERTEX_SE2 4294967296 0 0 0\n"), "g2o line 1 has an id that is too large: 4294967296");
  EXPECT_EQ(fault("VERTEX_SE2 18446744073709551616 0 0 0\n"),
            "g2o line 1 has an id that is too large: 18446744073709551616");
  EXPECT_EQ(fault("VERTEX_SE2 -1 0 0 0\n"), "g2o line 1 needs an integer id, not '-1'");
  EXPECT_EQ(fault("VERTEX_SE2 1.5 0 0 0\n"), "g2o line 1 needs an integer id, not '1.5'");
}

TEST(G2o, RefusesByNameWhatItDoesNotRead) {
  const std::string vertex = "VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\n";
  for (const char* tag : {"EDGE_SE3_PRIOR", "EDGE_PRIOR_SE2", "EDGE_SE3_XYZPRIOR", "VERTEX2", "EDGE2", "VERTEX3",
                          "EDGE3", "EQUIV", "EDGE_SE3_OFFSET"}) {
    const std::string message = fault(vertex + tag + " 0 0 0 0 0 0 0 0 1\n");
    EXPECT_EQ(message.find("g2o line 2 has the tag '" + std::string(tag) + "': "), 0u) << message;
  }
  EXPECT_EQ(fault("VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 0 0 0\nFIX 0\nFIX 0 1\n"),
            "g2o line 4 has FIX of vertex 1: only the one with the smallest id is held");
}

TEST(G2o, NamesLineAndFault) {
  EXPECT_EQ(fault("VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 x 0\n"), "g2o line 2 'x' is not a finite number");
  EXPECT_EQ(fault("VERTEX_SE2 0 0 nan 0\n"), "g2o line 1 'nan' is not a finite number");
  EXPECT_EQ(fault("VERTEX_SE2 0 0\n"), "g2o line 1 ends early");
  EXPECT_EQ(fault("VERTEX_CAM 0\n"), "g2o line 1 has an unknown tag 'VERTEX_CAM'");
  EXPECT_EQ(fault("VERTEX_SE2 0 0 0 0\nVERTEX_SE2 0 0 0 0\n"), "g2o line 2 repeats vertex 0");
  EXPECT_NE(fault("VERTEX_SE3:QUAT 0 0 0 0 0.7071 0 0 0.7071\n").find("gravity-aligned"), std::string::npos);
  EXPECT_EQ(fault("VERTEX_SE2 0 0 0 0\nEDGE_SE2 0 5 1 0 0 1 0 0 1 0 1\n"),
            "g2o line 2 has an edge between 0 and 5, one of which is not in the file");
  EXPECT_EQ(fault("VERTEX_SE2 0 0 0 0\nEDGE_SE2 0 0 1 0 0 1 0 0 1 0 1\n"),
            "g2o line 2 has an edge from a vertex to itself");
  EXPECT_EQ(fault("EDGE_SE2 0 1 1 0 0 1 0 0 -1 0 1\n"), "g2o line 1 information must not have negative eigenvalues");
  EXPECT_EQ(fault("VERTEX_SE2 0 0 0 0 7\n"), "g2o line 1 goes on after its last number: '7'");
}
