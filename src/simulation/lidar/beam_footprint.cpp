// SPDX-License-Identifier: BSD-3-Clause
#include "beam_footprint.hpp"

#include <cmath>

namespace voxnav_simulation {
namespace {

constexpr double kGoldenAngle_rad = 2.399963229728653;
constexpr double kHalfMaximumOverDeviation = 2.354820045030949;  // 2 sqrt(2 ln 2)

}  // namespace

BeamFootprint::BeamFootprint(const LidarConfig& config) {
  if (config.footprint_rays == 1) {
    offsets_.push_back({0.0F, 0.0F});
    return;
  }
  const double deviation_rad = config.beam_divergence_rad / kHalfMaximumOverDeviation;
  for (int i = 0; i < config.footprint_rays; ++i) {
    const double quantile = (i + 0.5) / config.footprint_rays;
    const double tangent = std::tan(deviation_rad * std::sqrt(-2.0 * std::log(1.0 - quantile)));
    offsets_.push_back({static_cast<float>(tangent * std::cos(kGoldenAngle_rad * i)),
                        static_cast<float>(tangent * std::sin(kGoldenAngle_rad * i))});
  }
}

void BeamFootprint::spread(const Vec3f& axis, float turn_rad, Vec3f* directions) const {
  if (offsets_.size() == 1) {
    directions[0] = axis;
    return;
  }
  const Vec3f aside = std::abs(axis.z()) < 0.9F ? Vec3f::UnitZ() : Vec3f::UnitX();
  const Vec3f u = axis.cross(aside).normalized(), v = axis.cross(u);
  const float c = std::cos(turn_rad), s = std::sin(turn_rad);
  for (std::size_t i = 0; i < offsets_.size(); ++i) {
    const Offset& o = offsets_[i];
    directions[i] = (axis + (c * o.along_u - s * o.along_v) * u + (s * o.along_u + c * o.along_v) * v).normalized();
  }
}

}  // namespace voxnav_simulation
