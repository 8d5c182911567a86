// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <stdexcept>

#include "voxnav/pipeline/sweep_locator.hpp"

namespace voxnav::pipeline {

geometry::Pose middle_of(const SweepMotion& motion) {
  return geometry::interpolate(motion.T_O_L_start, motion.T_O_L_end, 0.5);
}

void deskew(const geometry::MutablePointsView& points, const std::vector<std::uint32_t>& time_offsets_ns,
            const SweepMotion& motion) {
  if (time_offsets_ns.size() != points.size()) throw std::invalid_argument("deskewing needs one time for each point");
  if (motion.duration_ns == 0) return;
  const geometry::Pose T_middle_O = middle_of(motion).inverse();
  std::array<Eigen::Isometry3f, kDeskewSteps + 1> T_middle_L;
  for (int step = 0; step <= kDeskewSteps; ++step) {
    const double ratio = static_cast<double>(step) / kDeskewSteps;
    T_middle_L[step] = (T_middle_O * geometry::interpolate(motion.T_O_L_start, motion.T_O_L_end, ratio)).cast<float>();
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::uint64_t scaled = std::uint64_t{time_offsets_ns[i]} * kDeskewSteps + motion.duration_ns / 2;
    const auto step = std::min<std::uint64_t>(scaled / motion.duration_ns, kDeskewSteps);
    points[i] = T_middle_L[step] * points[i];
  }
}

}  // namespace voxnav::pipeline
