// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/occupancy/local_map_config.hpp"

#include <cmath>
#include <cstdio>

#include "occupancy/octree_block.hpp"

namespace voxnav::occupancy {
namespace {

/// The worst case of memory: block_update.cpp bounds hit statistics to a quarter of a block's voxels.
constexpr double kBytesPerBlock = sizeof(OctreeBlock) + sizeof(void*) +
                                  geometry::kBlockVolume / 4.0 * sizeof(SurfaceLeaf) +
                                  NewVoxels::kMax * sizeof(NewVoxel);

/// Ray casting needs three bits per voxel (ray_marks.hpp), and a quarter more for spare lines and for the words at the
/// edges of the images of the faces.
constexpr double kMarkBytesPerBlock = 1.25 * 3.0 * geometry::kBlockVolume / 8;

/// Returns the number of blocks on one side of the middle block with which the window covers `size_m` wherever in the
/// middle block the sensor is.
double half_blocks(double size_m, double block_m) { return std::ceil(0.5 * size_m / block_m + 0.25); }

}  // namespace

std::array<int, 3> LocalMapConfig::window_blocks() const {
  std::array<int, 3> out{};
  for (int axis = 0; axis < 3; ++axis) {
    out[axis] = 2 * static_cast<int>(half_blocks(window_size_m[axis], resolution_m * geometry::kBlockSide)) + 1;
  }
  return out;
}

double LocalMapConfig::worst_case_bytes() const {
  double bytes = kBytesPerBlock + kMarkBytesPerBlock;
  for (const double size_m : window_size_m)
    bytes *= 2.0 * half_blocks(size_m, resolution_m * geometry::kBlockSide) + 1.0;
  return bytes;
}

std::vector<std::string> LocalMapConfig::problems() const {
  std::vector<std::string> out;
  if (!(free_threshold < occupied_threshold)) out.emplace_back("free_threshold must be below occupied_threshold");
  if (!(prob_clamp_min < free_threshold))
    out.emplace_back("prob_clamp_min must be below free_threshold, or nothing is ever free");
  if (!(prob_clamp_max > occupied_threshold)) {
    out.emplace_back("prob_clamp_max must be above occupied_threshold, or nothing is ever occupied");
  }
  const double needed_mb = worst_case_bytes() / 1e6;
  if (needed_mb > max_memory_mb) {
    char text[256];
    std::snprintf(text, sizeof(text),
                  "resolution_m = %g with window_size_m = %g x %g x %g can need %.0f MB, max_memory_mb allows %.0f",
                  resolution_m, window_size_m[0], window_size_m[1], window_size_m[2], needed_mb, max_memory_mb);
    out.emplace_back(text);
  }
  return out;
}

}  // namespace voxnav::occupancy
