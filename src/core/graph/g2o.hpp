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
  Matrix4 information;  ///< of the error expressed in frame a, in the order x, y, z, yaw
  int line = 0;         ///< where it stands in the file; 0 for edges that come from elsewhere
};

struct G2o {
  std::map<int, Pose4> vertices;
  std::vector<G2oEdge> edges;
};

/// Reads VERTEX_SE3:QUAT and EDGE_SE3:QUAT, and VERTEX_SE2 and EDGE_SE2 as poses at z = 0 that are held there.
///
/// A file gives the information of an edge in the measured frame: g2o's error is the vector of T̂_a_b⁻¹ T_a_b, in the
/// order x, y, z, qx, qy, qz (Kümmerle et al., g2o, ICRA 2011). It is turned into frame a here. Of the 6x6 matrix the
/// rows x, y, z and yaw are used. Rotation counts in radians, as in the readers of Ceres and GTSAM, while g2o itself
/// means half angles.
///
/// Parameters (PARAMS_...) matter only to edges that name them, none of which is read. FIX may name the vertex with the
/// smallest id, which the graph holds anyway. Keys of GTSAM are read as their index, provided all have one letter.
/// @throws std::invalid_argument naming line and fault: priors, landmarks, TORO (VERTEX2, EDGE3, ...) and other tags,
///         FIX of another vertex, missing, surplus or non-finite numbers, tilted pose, unknown or duplicate vertex
G2o read_g2o(const std::string& text);

/// Writes vertices and edges of type SE3:QUAT with 17 significant digits, in the conventions of read_g2o(). Roll and
/// pitch, which the graph holds fixed, get the largest information of their edge.
std::string write_g2o(const G2o& file);

}  // namespace voxnav::graph
