// SPDX-License-Identifier: BSD-3-Clause
#include "graph/g2o.hpp"

#include <algorithm>
#include <limits>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "graph/g2o_line.hpp"

namespace voxnav::graph {
namespace {

enum class Tag { kVertexPlanar, kVertex, kEdgePlanar, kEdge, kFix, kParameter };

const std::map<std::string, Tag> kRead = {
    {"VERTEX_SE2", Tag::kVertexPlanar},
    {"VERTEX_SE3:QUAT", Tag::kVertex},
    {"EDGE_SE2", Tag::kEdgePlanar},
    {"EDGE_SE3:QUAT", Tag::kEdge},
    {"FIX", Tag::kFix},
    {"PARAMS_SE2OFFSET", Tag::kParameter},
    {"PARAMS_SE3OFFSET", Tag::kParameter},
    {"PARAMS_CAMERACALIB", Tag::kParameter},
    {"PARAMS_CAMERAPARAMETERS", Tag::kParameter},
    {"PARAMS_STEREOCAMERAPARAMETERS", Tag::kParameter},
};

constexpr const char* kPrior = "priors of single poses are not read";
constexpr const char* kOffset = "edges between sensors that sit off their poses are not read";
constexpr const char* kToro =
    "TORO files are not read: some hold information and some covariances; convert it to VERTEX_SE2 or VERTEX_SE3:QUAT";

const std::map<std::string, const char*> kRefused = {
    {"EDGE_PRIOR_SE2", kPrior},
    {"EDGE_PRIOR_SE2_XY", kPrior},
    {"EDGE_SE2_PRIOR", kPrior},
    {"EDGE_SE3_PRIOR", kPrior},
    {"EDGE_SE3_XYZPRIOR", kPrior},
    {"EDGE_SE3_PRIOR_XY", kPrior},
    {"EDGE_SE3_PRIOR_XYZ", kPrior},
    {"EDGE_SE3_PRIOR_VEC", kPrior},
    {"EDGE_SE3_PRIOR_QUAT", kPrior},
    {"EDGE_POINTXYZ", kPrior},
    {"EDGE_SE2_OFFSET", kOffset},
    {"EDGE_SE3_OFFSET", kOffset},
    {"VERTEX", kToro},
    {"EDGE", kToro},
    {"VERTEX2", kToro},
    {"EDGE2", kToro},
    {"VERTEX3", kToro},
    {"EDGE3", kToro},
    {"EQUIV", kToro},
};

/// Rows and columns `keep` of a larger matrix at positions `put` of a 4x4 one.
template <int N, int K>
Matrix4 spread(const Eigen::Matrix<double, N, N>& from, const int (&keep)[K], const int (&put)[K]) {
  Matrix4 out = Matrix4::Zero();
  for (int i = 0; i < K; ++i) {
    for (int j = 0; j < K; ++j) out(put[i], put[j]) = from(keep[i], keep[j]);
  }
  return out;
}

/// Information of a planar edge: z is held as firmly as x and y, so that no direction is left free.
Matrix4 planar_information(G2oLine* line) {
  const Eigen::Matrix3d information = line->triangle<3>();
  Matrix4 out = spread<3, 3>(information, {0, 1, 2}, {0, 1, 3});
  out(2, 2) = std::max(information(0, 0), information(1, 1));
  return out;
}

/// Roll and pitch are held by the graph, so that their rows say nothing.
Matrix4 upright_information(G2oLine* line) { return spread<6, 4>(line->triangle<6>(), {0, 1, 2, 5}, {0, 1, 2, 3}); }

/// Information of an error whose coordinates turn by `yaw_rad`.
Matrix4 turned(const Matrix4& information, double yaw_rad) {
  Matrix4 R = Matrix4::Identity();
  R.topLeftCorner<3, 3>() = Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()).matrix();
  return R * information * R.transpose();
}

/// Takes the lines of a file one after the other; what only the whole file can tell is checked by finish().
class Reader {
 public:
  void add(G2oLine* line) {
    const std::string word = line->word();
    if (word.empty()) return;
    const auto tag = kRead.find(word);
    if (tag == kRead.end()) refuse(word, *line);
    if (tag->second == Tag::kParameter) return;
    read(tag->second, line);
    line->end();
  }

  G2o finish() {
    for (const G2oEdge& edge : file_.edges) {
      if (file_.vertices.count(edge.a) && file_.vertices.count(edge.b)) continue;
      G2oLine("", edge.line)
          .fail("has an edge between " + std::to_string(edge.a) + " and " + std::to_string(edge.b) +
                ", one of which is not in the file");
    }
    for (const auto& [number, id] : fixed_) {
      if (!file_.vertices.empty() && file_.vertices.begin()->first == id) continue;
      G2oLine("", number)
          .fail("has FIX of vertex " + std::to_string(id) + ": only the one with the smallest id is held");
    }
    return std::move(file_);
  }

 private:
  [[noreturn]] static void refuse(const std::string& word, const G2oLine& line) {
    const auto known = kRefused.find(word);
    if (known == kRefused.end()) line.fail("has an unknown tag '" + word + "'");
    line.fail("has the tag '" + word + "': " + known->second);
  }

  void read(Tag tag, G2oLine* line) {
    switch (tag) {
      case Tag::kVertexPlanar:
        return add_vertex(line, &G2oLine::pose2);
      case Tag::kVertex:
        return add_vertex(line, &G2oLine::pose3);
      case Tag::kEdgePlanar:
        return add_edge(line, &G2oLine::pose2, planar_information);
      case Tag::kEdge:
        return add_edge(line, &G2oLine::pose3, upright_information);
      case Tag::kFix:
        do fixed_.emplace_back(line->line_number(), id(line));
        while (line->has_more());
        return;
      case Tag::kParameter:
        return;
    }
  }

  int id(G2oLine* line) {
    const G2oLine::Key key = line->key();
    if (!letter_) letter_ = key.letter;
    if (*letter_ != key.letter) line->fail("has a key with another letter than those before it");
    return key.index;
  }

  void add_vertex(G2oLine* line, Pose4 (G2oLine::*pose)()) {
    const int vertex = id(line);
    if (!file_.vertices.emplace(vertex, (line->*pose)()).second) {
      line->fail("repeats vertex " + std::to_string(vertex));
    }
  }

  void add_edge(G2oLine* line, Pose4 (G2oLine::*pose)(), Matrix4 (*information)(G2oLine*)) {
    G2oEdge edge;
    edge.line = line->line_number();
    edge.a = id(line);
    edge.b = id(line);
    if (edge.a == edge.b) line->fail("has an edge from a vertex to itself");
    edge.T_a_b = (line->*pose)();
    edge.information = turned(information(line), edge.T_a_b[3]);
    try {
      whitening_of(edge.information, "information");
    } catch (const std::invalid_argument& error) {
      line->fail(error.what());
    }
    file_.edges.push_back(edge);
  }

  G2o file_;
  std::optional<char> letter_;              // of the keys so far
  std::vector<std::pair<int, int>> fixed_;  // line and vertex
};

void write_pose(const Pose4& pose, std::ostream& out) {
  const Eigen::Quaterniond q(to_pose(pose).linear());
  out << ' ' << pose[0] << ' ' << pose[1] << ' ' << pose[2] << " 0 0 " << q.z() << ' ' << q.w();
}

void write_edge(const G2oEdge& edge, std::ostream& out) {
  const Matrix4 information = turned(edge.information, -edge.T_a_b[3]);
  Eigen::Matrix<double, 6, 6> full = Eigen::Matrix<double, 6, 6>::Zero();
  constexpr int kKept[4] = {0, 1, 2, 5};
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) full(kKept[i], kKept[j]) = information(i, j);
  }
  full(3, 3) = full(4, 4) = information.diagonal().maxCoeff();
  out << "EDGE_SE3:QUAT " << edge.a << ' ' << edge.b;
  write_pose(edge.T_a_b, out);
  for (int i = 0; i < 6; ++i) {
    for (int j = i; j < 6; ++j) out << ' ' << full(i, j);
  }
  out << '\n';
}

}  // namespace

G2o read_g2o(const std::string& text) {
  Reader reader;
  std::istringstream stream(text);
  std::string content;
  for (int number = 1; std::getline(stream, content); ++number) {
    G2oLine line(content, number);
    reader.add(&line);
  }
  return reader.finish();
}

std::string write_g2o(const G2o& file) {
  std::ostringstream out;
  out.precision(std::numeric_limits<double>::max_digits10);
  for (const auto& [id, pose] : file.vertices) {
    out << "VERTEX_SE3:QUAT " << id;
    write_pose(pose, out);
    out << '\n';
  }
  for (const G2oEdge& edge : file.edges) write_edge(edge, out);
  return out.str();
}

}  // namespace voxnav::graph
