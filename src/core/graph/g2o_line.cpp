// SPDX-License-Identifier: BSD-3-Clause
#include "graph/g2o_line.hpp"

#include <cerrno>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <stdexcept>

namespace voxnav::graph {

G2oLine::G2oLine(const std::string& text, int number) : stream_(text.substr(0, text.find('#'))), number_(number) {}

std::string G2oLine::word() {
  std::string out;
  stream_ >> out;
  return out;
}

bool G2oLine::has_more() { return !(stream_ >> std::ws).eof(); }

G2oLine::Key G2oLine::key() {
  constexpr int kIndexBits = 56;
  const std::string text = word();
  if (text.empty() || text.size() > 20 || text.find_first_not_of("0123456789") != std::string::npos) {
    fail("needs an integer id, not '" + text + "'");
  }
  errno = 0;
  const std::uint64_t value = std::strtoull(text.c_str(), nullptr, 10);
  const std::uint64_t index = value & ((std::uint64_t{1} << kIndexBits) - 1);
  if (errno != 0 || index > static_cast<std::uint64_t>(std::numeric_limits<int>::max())) {
    fail("has an id that is too large: " + text);
  }
  return {static_cast<char>(value >> kIndexBits), static_cast<int>(index)};
}

double G2oLine::number() {
  const std::string text = word();
  if (text.empty()) fail("ends early");
  char* end = nullptr;
  const double out = std::strtod(text.c_str(), &end);
  if (*end != '\0' || !std::isfinite(out)) fail("'" + text + "' is not a finite number");
  return out;
}

Pose4 G2oLine::pose2() {
  Pose4 out = Pose4::Zero();
  out[0] = number();
  out[1] = number();
  out[3] = geometry::wrap_angle(number());
  return out;
}

Pose4 G2oLine::pose3() {
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

void G2oLine::end() {
  const std::string text = word();
  if (!text.empty()) fail("goes on after its last number: '" + text + "'");
}

void G2oLine::fail(const std::string& why) const {
  throw std::invalid_argument("g2o line " + std::to_string(number_) + " " + why);
}

}  // namespace voxnav::graph
