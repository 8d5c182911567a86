// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sstream>
#include <string>

#include "graph/pose4.hpp"

namespace voxnav::graph {

/// Reads the words of one line of a g2o file from left to right. Every fault is a std::invalid_argument that names the
/// line, also those of callers, by fail().
class G2oLine {
 public:
  G2oLine(const std::string& text, int number);

  /// The next word; empty at the end of the line and where a comment begins.
  std::string word();
  /// Whether another word follows.
  bool has_more();
  /// The id of a vertex. GTSAM writes keys of 64 bits: a letter in the highest byte, which plain ids do not have, and
  /// the index below it.
  struct Key {
    char letter = 0;
    int index = 0;
  };
  Key key();
  double number();
  /// x, y, yaw
  Pose4 pose2();
  /// x, y, z, qx, qy, qz, qw of a pose that stands upright
  Pose4 pose3();
  /// Upper triangle of a symmetric N x N matrix, row by row.
  template <int N>
  Eigen::Matrix<double, N, N> triangle() {
    Eigen::Matrix<double, N, N> out;
    for (int i = 0; i < N; ++i) {
      for (int j = i; j < N; ++j) out(i, j) = out(j, i) = number();
    }
    return out;
  }
  /// Refuses words that nothing has read.
  void end();

  int line_number() const { return number_; }
  [[noreturn]] void fail(const std::string& why) const;

 private:
  std::istringstream stream_;
  int number_;
};

}  // namespace voxnav::graph
