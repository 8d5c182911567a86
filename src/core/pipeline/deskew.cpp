// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/pipeline/deskew.hpp"

#include <algorithm>
#include <array>

namespace voxnav::pipeline {

geometry::Pose middle_of(const SweepMotion& motion) {
  return geometry::interpolate(motion.T_O_L_start, motion.T_O_L_end, 0.5);
}

void deskew(float* points, const std::uint32_t* time_offsets_ns, std::size_t n, std::size_t stride,
            const SweepMotion& motion) {
  if (motion.duration_ns == 0) return;
  const geometry::Pose T_middle_O = middle_of(motion).inverse();
  std::array<Eigen::Isometry3f, kDeskewSteps + 1> T_middle_L;
  for (int step = 0; step <= kDeskewSteps; ++step) {
    const double ratio = static_cast<double>(step) / kDeskewSteps;
    T_middle_L[step] = (T_middle_O * geometry::interpolate(motion.T_O_L_start, motion.T_O_L_end, ratio)).cast<float>();
  }
  for (std::size_t i = 0; i < n; ++i) {
    Eigen::Map<geometry::Vec3f> point(points + i * stride);
    const std::uint64_t scaled = std::uint64_t{time_offsets_ns[i]} * kDeskewSteps + motion.duration_ns / 2;
    const auto step = std::min<std::uint64_t>(scaled / motion.duration_ns, kDeskewSteps);
    point = T_middle_L[step] * point;
  }
}

}  // namespace voxnav::pipeline
