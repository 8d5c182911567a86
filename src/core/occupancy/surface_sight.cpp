// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/occupancy/surface_sight.hpp"

#include "voxnav/occupancy/byte_ops.hpp"

namespace voxnav::occupancy {

SurfaceSight::SurfaceSight(const BeamImage& beams, const ScanFrame& frame, float resolution_m, const MissGuard& guard)
    : beams_(beams),
      origin_(frame.origin),
      rotation_(frame.rotation * resolution_m),
      resolution_m_(resolution_m),
      guard_(guard) {}

std::uint8_t SurfaceSight::octants_seen(const geometry::Vec3f& to_center, const SurfaceLeaf& leaf,
                                        const geometry::Vec3f& direction, float length) const {
  // From the voxel's centre to the nearest point of the beam.
  const geometry::Vec3f at = to_center.dot(direction) * direction - to_center;
  if (at.cwiseAbs().maxCoeff() > 0.5f) return 0;
  const geometry::Vec3f to_mean = to_center + leaf.offset();
  const float along = to_mean.dot(direction);
  if (length - along < guard_.end_voxels) return 0;
  const geometry::Vec3f across = to_mean - along * direction;
  if (leaf.squared_distance(across, direction, guard_.spread_voxels) <= guard_.sigmas * guard_.sigmas) return 0xFF;
  const int octant = (at.x() > 0.0f ? 1 : 0) | (at.y() > 0.0f ? 2 : 0) | (at.z() > 0.0f ? 4 : 0);
  return static_cast<std::uint8_t>(1u << octant);
}

bool SurfaceSight::refutes(const geometry::Vec3f& center, SurfaceLeaf* leaf) const {
  constexpr float kHalfDiagonal = 0.8661f;
  const geometry::Vec3f to_center = center - origin_;
  const geometry::Vec3f center_L = rotation_.transpose() * to_center * resolution_m_;
  const float shortest = to_center.norm() + guard_.end_voxels - kHalfDiagonal;
  const float reach_sq = kHalfDiagonal * kHalfDiagonal * resolution_m_ * resolution_m_;
  const auto look = [&](const geometry::Vec3f& end_L, float range_sq) {
    // Most beams in the square of pixels around a voxel pass it by, which costs less to see than where they went.
    const geometry::Vec3f at_L = (center_L.dot(end_L) / range_sq) * end_L - center_L;
    if (at_L.squaredNorm() > reach_sq) return false;
    const float range = std::sqrt(range_sq);
    leaf->octants |= octants_seen(to_center, *leaf, rotation_ * (end_L / range),
                                  std::min(range, beams_.longest_m()) / resolution_m_);
    return leaf->octants == 0xFF;
  };
  beams_.for_beams_near(center_L, 0.6f * resolution_m_, shortest * resolution_m_, look);
  if (static_cast<int>(count_bits(leaf->octants)) < guard_.octants) return false;
  leaf->octants = 0;
  return leaf->is_refuted_by_seeing_through(guard_.patience);
}

}  // namespace voxnav::occupancy
