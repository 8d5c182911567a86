// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>
#include <vector>

#include "graph/pose4.hpp"

namespace voxnav::graph {

struct G2oEdge {
  int a;
  int b;
  Pose4 T_a_b;
  Matrix4 information;  ///< in the order x, y, z, yaw
};

struct G2o {
  std::map<int, Pose4> vertices;
  std::vector<G2oEdge> edges;
};

/// Reads VERTEX_SE3:QUAT and EDGE_SE3:QUAT, and VERTEX_SE2 and EDGE_SE2 as poses at z = 0 that are held there. Comments
/// and FIX are ignored. Of the 6x6 information of an SE3 edge the rows x, y, z and yaw are used. Rotations are in
/// radians, as in the readers of Ceres and GTSAM, while g2o itself uses half angles.
/// @throws std::invalid_argument naming line and fault: unknown tag, missing or non-finite number, tilted pose,
///         unknown vertex, duplicate vertex
G2o read_g2o(const std::string& text);

/// Writes vertices and edges of type SE3:QUAT with 17 significant digits. Roll and pitch, which the graph holds fixed,
/// get the largest information of their edge.
std::string write_g2o(const G2o& file);

}  // namespace voxnav::graph
