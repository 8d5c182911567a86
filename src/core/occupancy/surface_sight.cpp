// SPDX-License-Identifier: BSD-3-Clause
#include "occupancy/surface_sight.hpp"

#include "kernels/bits.hpp"

namespace voxnav::occupancy {

/// Up to eight voxels of a block, one in each lane of the kernel that looks up the beams through them.
struct SurfaceSight::Group {
  kernels::AskedVoxels asked;
  SurfaceLeaf* leaves[kernels::lanes::kLanes];

  Group() { asked.size = 0; }
  void add(int offset, SurfaceLeaf* leaf) {
    set(asked.size, offset, leaf);
    ++asked.size;
  }
  /// Repeats the first voxel in the lanes that would be empty, so that the kernel reads valid memory.
  void fill_up() {
    for (int i = asked.size; i < kernels::lanes::kLanes; ++i) set(i, asked.offsets[0], leaves[0]);
  }

 private:
  void set(int lane, int offset, SurfaceLeaf* leaf) {
    leaves[lane] = leaf;
    asked.offsets[lane] = offset;
    asked.means[lane] = leaf->mean.data();
    asked.covariances[lane] = leaf->covariance.data();
  }
};

SurfaceSight::SurfaceSight(const BeamImage& beams, const ScanFrame& frame, float resolution_m, const MissGuard& guard)
    : beams_(beams),
      origin_(frame.origin),
      rules_{frame.rotation,     frame.rotation.transpose() * (resolution_m * resolution_m),
             resolution_m,       beams.longest_m() / resolution_m,
             guard.end_voxels,   guard.sigmas,
             guard.spread_voxels},
      guard_(guard) {}

void SurfaceSight::judge(const geometry::Vec3f& first_center, Group* group, VoxelBits* out) const {
  if (group->asked.size == 0) return;
  group->fill_up();
  alignas(32) std::int32_t octants[kernels::lanes::kLanes];
  kernels::seen_octants(beams_.images(), rules_, first_center, group->asked, octants);
  for (int i = 0; i < group->asked.size; ++i) {
    SurfaceLeaf* leaf = group->leaves[i];
    leaf->octants = static_cast<std::uint8_t>(leaf->octants | octants[i]);
    if (static_cast<int>(kernels::count_bits(leaf->octants)) < guard_.octants) continue;
    leaf->octants = 0;
    if (!leaf->is_refuted_by_seeing_through(guard_.patience)) continue;
    const int offset = group->asked.offsets[i];
    (*out)[static_cast<std::size_t>(offset >> 6)] |= std::uint64_t{1} << (offset & 63);
  }
  group->asked.size = 0;
}

VoxelBits SurfaceSight::refuted(const geometry::Index3& first_voxel, const VoxelBits& asked,
                                SurfaceLeaves* leaves) const {
  const geometry::Vec3f first_center =
      geometry::Vec3f(static_cast<float>(first_voxel.x), static_cast<float>(first_voxel.y),
                      static_cast<float>(first_voxel.z)) +
      geometry::Vec3f::Constant(0.5f) - origin_;
  VoxelBits out{};
  Group group;
  for (std::size_t word = 0; word < asked.size(); ++word) {
    kernels::for_each_bit(asked[word], [&](int bit) {
      const int offset = static_cast<int>(64 * word) + bit;
      group.add(offset, leaves->find(offset));
      if (group.asked.size == kernels::lanes::kLanes) judge(first_center, &group, &out);
    });
  }
  judge(first_center, &group, &out);
  return out;
}

}  // namespace voxnav::occupancy
