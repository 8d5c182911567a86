// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "graph/g2o.hpp"

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

TEST(G2o, ReadsPlanarFiles) {
  const G2o file = read_g2o(
      "# comment\nVERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0.5 1.57\nFIX 0\nEDGE_SE2 0 1 1 0.4 1.5 11 12 13 22 23 33\n");
  EXPECT_EQ(file.vertices.at(1), Pose4(1, 0.5, 0, 1.57));
  const Matrix4& information = file.edges.at(0).information;
  EXPECT_EQ(information(0, 1), 12);
  EXPECT_EQ(information(0, 3), 13);
  EXPECT_EQ(information(1, 3), 23);
  EXPECT_EQ(information(3, 3), 33);
  EXPECT_EQ(information(2, 2), 22);
}

TEST(G2o, NamesLineAndFault) {
  EXPECT_EQ(fault("VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 x 0\n"), "g2o line 2 'x' is not a finite number");
  EXPECT_EQ(fault("VERTEX_SE2 0 0 nan 0\n"), "g2o line 1 'nan' is not a finite number");
  EXPECT_EQ(fault("VERTEX_SE2 0 0\n"), "g2o line 1 ends early");
  EXPECT_EQ(fault("VERTEX_CAM 0\n"), "g2o line 1 has an unknown tag 'VERTEX_CAM'");
  EXPECT_EQ(fault("VERTEX_SE2 0 0 0 0\nVERTEX_SE2 0 0 0 0\n"), "g2o line 2 repeats vertex 0");
  EXPECT_NE(fault("VERTEX_SE3:QUAT 0 0 0 0 0.7071 0 0 0.7071\n").find("gravity-aligned"), std::string::npos);
  EXPECT_NE(fault("VERTEX_SE2 0 0 0 0\nEDGE_SE2 0 5 1 0 0 1 0 0 1 0 1\n").find("not in the file"), std::string::npos);
}
