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
  Matrix4 information;  ///< of x, y, z, yaw
};

struct G2o {
  std::map<int, Pose4> vertices;
  std::vector<G2oEdge> edges;
};

/// Reads VERTEX_SE3:QUAT, EDGE_SE3:QUAT, VERTEX_SE2, EDGE_SE2 (as z = 0, held there) and ignores comments and FIX.
/// Of the 6x6 information of an SE3 edge the rows x, y, z, yaw are used; rotation is taken in radians, as Ceres' and
/// GTSAM's readers do (g2o itself means half angles).
/// @throws std::invalid_argument naming line and fault: unknown tag, missing or non-finite number, tilted pose,
///         unknown vertex, duplicate vertex
G2o read_g2o(const std::string& text);

/// Writes SE3:QUAT vertices and edges with 17 significant digits. Roll and pitch, which are fixed here, get the
/// largest information of the edge.
std::string write_g2o(const G2o& file);

}  // namespace voxnav::graph
