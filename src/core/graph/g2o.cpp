// SPDX-License-Identifier: BSD-3-Clause
#include "graph/g2o.hpp"

#include <cmath>
#include <limits>
#include <sstream>
#include <stdexcept>

namespace voxnav::graph {
namespace {

/// Reads the numbers of one line; its errors name the line.
class Line {
 public:
  Line(const std::string& text, int number) : stream_(text), number_(number) {}

  std::string tag() {
    std::string out;
    stream_ >> out;
    return out;
  }
  int id() {
    int out = 0;
    if (!(stream_ >> out)) fail("needs an integer id");
    return out;
  }
  double number() {
    std::string word;
    if (!(stream_ >> word)) fail("ends early");
    char* end = nullptr;
    const double out = std::strtod(word.c_str(), &end);
    if (*end != '\0' || !std::isfinite(out)) fail("'" + word + "' is not a finite number");
    return out;
  }
  Pose4 pose2() {
    Pose4 out = Pose4::Zero();
    out[0] = number();
    out[1] = number();
    out[3] = geometry::wrap_angle(number());
    return out;
  }
  Pose4 pose3() {
    geometry::Pose pose = geometry::Pose::Identity();
    for (int k = 0; k < 3; ++k) pose.translation()[k] = number();
    double q[4];
    for (double& value : q) value = number();
    const Eigen::Quaterniond rotation(q[3], q[0], q[1], q[2]);
    if (rotation.norm() < 1e-6) fail("has a zero quaternion");
    pose.linear() = rotation.normalized().toRotationMatrix();
    try {
      return to_pose4(pose, "pose");
    } catch (const std::invalid_argument& error) {
      fail(error.what());
    }
  }
  /// Upper triangle of a symmetric matrix, row by row.
  template <int N>
  Eigen::Matrix<double, N, N> triangle() {
    Eigen::Matrix<double, N, N> out;
    for (int i = 0; i < N; ++i) {
      for (int j = i; j < N; ++j) out(i, j) = out(j, i) = number();
    }
    return out;
  }
  [[noreturn]] void fail(const std::string& why) const {
    throw std::invalid_argument("g2o line " + std::to_string(number_) + " " + why);
  }

 private:
  std::istringstream stream_;
  int number_;
};

/// Copies rows and columns `keep` of a larger matrix to positions `put` of a 4x4 matrix.
template <int N, int K>
Matrix4 spread(const Eigen::Matrix<double, N, N>& from, const int (&keep)[K], const int (&put)[K]) {
  Matrix4 out = Matrix4::Zero();
  for (int i = 0; i < K; ++i) {
    for (int j = 0; j < K; ++j) out(put[i], put[j]) = from(keep[i], keep[j]);
  }
  return out;
}

/// Returns the information of a planar edge, in which z has the weight of x and y, so that no direction is left free.
Matrix4 planar_information(const Eigen::Matrix3d& information) {
  Matrix4 out = spread<3, 3>(information, {0, 1, 2}, {0, 1, 3});
  out(2, 2) = std::max(information(0, 0), information(1, 1));
  return out;
}

void read_vertex(Line* line, bool is_planar, G2o* file) {
  const int id = line->id();
  const Pose4 pose = is_planar ? line->pose2() : line->pose3();
  if (!file->vertices.emplace(id, pose).second) line->fail("repeats vertex " + std::to_string(id));
}

void read_edge(Line* line, bool is_planar, G2o* file) {
  G2oEdge edge;
  edge.a = line->id();
  edge.b = line->id();
  edge.T_a_b = is_planar ? line->pose2() : line->pose3();
  edge.information = is_planar ? planar_information(line->triangle<3>())
                               : spread<6, 4>(line->triangle<6>(), {0, 1, 2, 5}, {0, 1, 2, 3});
  file->edges.push_back(edge);
}

void write_pose(const Pose4& pose, std::ostream& out) {
  const Eigen::Quaterniond q(to_pose(pose).linear());
  out << ' ' << pose[0] << ' ' << pose[1] << ' ' << pose[2] << " 0 0 " << q.z() << ' ' << q.w();
}

}  // namespace

G2o read_g2o(const std::string& text) {
  G2o file;
  std::istringstream stream(text);
  std::string content;
  for (int number = 1; std::getline(stream, content); ++number) {
    Line line(content, number);
    const std::string tag = line.tag();
    if (tag.empty() || tag[0] == '#' || tag == "FIX") continue;
    if (tag == "VERTEX_SE2" || tag == "VERTEX_SE3:QUAT") {
      read_vertex(&line, tag == "VERTEX_SE2", &file);
    } else if (tag == "EDGE_SE2" || tag == "EDGE_SE3:QUAT") {
      read_edge(&line, tag == "EDGE_SE2", &file);
    } else {
      line.fail("has an unknown tag '" + tag + "'");
    }
  }
  for (const G2oEdge& edge : file.edges) {
    if (file.vertices.count(edge.a) && file.vertices.count(edge.b)) continue;
    throw std::invalid_argument("g2o edge " + std::to_string(edge.a) + " " + std::to_string(edge.b) +
                                " names a vertex that is not in the file");
  }
  return file;
}

std::string write_g2o(const G2o& file) {
  std::ostringstream out;
  out.precision(std::numeric_limits<double>::max_digits10);
  for (const auto& [id, pose] : file.vertices) {
    out << "VERTEX_SE3:QUAT " << id;
    write_pose(pose, out);
    out << '\n';
  }
  for (const G2oEdge& edge : file.edges) {
    Eigen::Matrix<double, 6, 6> full = Eigen::Matrix<double, 6, 6>::Zero();
    constexpr int kKept[4] = {0, 1, 2, 5};
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < 4; ++j) full(kKept[i], kKept[j]) = edge.information(i, j);
    }
    full(3, 3) = full(4, 4) = edge.information.diagonal().maxCoeff();
    out << "EDGE_SE3:QUAT " << edge.a << ' ' << edge.b;
    write_pose(edge.T_a_b, out);
    for (int i = 0; i < 6; ++i) {
      for (int j = i; j < 6; ++j) out << ' ' << full(i, j);
    }
    out << '\n';
  }
  return out.str();
}

}  // namespace voxnav::graph
