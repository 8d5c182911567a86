// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <random>

#include "voxnav/occupancy/map_content.hpp"

/// Contents of maps whose truth is known, for tests of submaps.
namespace voxnav::test {

/// Builds a content voxel by voxel. A later call for the same voxel replaces an earlier one.
class ContentBuilder {
 public:
  explicit ContentBuilder(double resolution_m) : resolution_m_(resolution_m) {}

  void set_free(const geometry::Index3& voxel) { put(voxel, containers::VoxelState::kFree, geometry::Vec3::Zero(), 1); }
  /// Sets an occupied voxel that the submap observed.
  /// @param offset surface point relative to the voxel's centre in voxel edges, each coordinate within +-0.5
  void set_occupied(const geometry::Index3& voxel, const geometry::Vec3& offset = geometry::Vec3::Zero(),
                    int hits = 10) {
    put(voxel, containers::VoxelState::kOccupied, offset, hits);
  }
  /// Makes an occupied voxel one that is only remembered.
  void set_remembered(const geometry::Index3& voxel) { voxels_.at(voxel).voxel.observed.hits = 0; }
  /// Sets the surface point that the submap itself observed in an occupied voxel; 0 hits: it is only remembered.
  void set_observed(const geometry::Index3& voxel, const geometry::Vec3& offset, int hits) {
    occupancy::VoxelPoint& observed = voxels_.at(voxel).voxel.observed;
    for (int k = 0; k < 3; ++k) observed.mean[k] = static_cast<std::int8_t>(std::lround(offset[k] * 254.0));
    observed.hits = static_cast<std::uint8_t>(hits);
  }
  bool is_set(const geometry::Index3& voxel) const { return voxels_.count(voxel) != 0; }

  occupancy::MapContent build() const {
    std::map<geometry::Index3, occupancy::ContentBlock> blocks;
    for (const auto& [voxel, value] : voxels_) {
      occupancy::ContentBlock& block = blocks[geometry::block_of(voxel)];
      block.index = geometry::block_of(voxel);
      occupancy::OccupiedVoxel occupied = value.voxel;
      occupied.offset = static_cast<std::uint16_t>(geometry::offset_in_block(voxel));
      block.states.set(occupied.offset, value.state);
      if (value.state == containers::VoxelState::kOccupied) block.occupied.push_back(occupied);
      if (value.state == containers::VoxelState::kFree && occupied.observed.hits > 0)
        block.observed_free[occupied.offset >> 6] |= std::uint64_t{1} << (occupied.offset & 63);
    }
    occupancy::MapContent content;
    content.resolution_m = resolution_m_;
    for (auto& entry : blocks) {
      std::sort(entry.second.occupied.begin(), entry.second.occupied.end(),
                [](const auto& a, const auto& b) { return a.offset < b.offset; });
      content.blocks.push_back(entry.second);
    }
    return content;
  }

 private:
  struct Voxel {
    containers::VoxelState state;
    occupancy::OccupiedVoxel voxel;
  };
  void put(const geometry::Index3& voxel, containers::VoxelState state, const geometry::Vec3& offset, int hits) {
    Voxel value{state, {}};
    for (int k = 0; k < 3; ++k) value.voxel.believed.mean[k] = static_cast<std::int8_t>(std::lround(offset[k] * 254.0));
    value.voxel.believed.hits = static_cast<std::uint8_t>(hits);
    value.voxel.observed = value.voxel.believed;
    voxels_[voxel] = value;
  }

  double resolution_m_;
  std::map<geometry::Index3, Voxel> voxels_;
};

using Sdf = std::function<double(const geometry::Vec3&)>;

inline geometry::Vec3 sdf_gradient(const Sdf& sdf, const geometry::Vec3& p) {
  constexpr double h = 1e-4;
  geometry::Vec3 out;
  for (int k = 0; k < 3; ++k) {
    const geometry::Vec3 step = geometry::Vec3::Unit(k) * h;
    out[k] = (sdf(p + step) - sdf(p - step)) / (2.0 * h);
  }
  return out;
}

/// Returns the content of the voxels first to last - 1 that a perfect LiDAR would make: voxels whose centre is near the
/// surface are occupied with the nearest surface point as mean, voxels outside of it are free, those inside unknown.
inline occupancy::MapContent content_from_sdf(const Sdf& sdf, const geometry::Index3& first,
                                              const geometry::Index3& last, double resolution_m) {
  ContentBuilder builder(resolution_m);
  for (int z = first.z; z < last.z; ++z) {
    for (int y = first.y; y < last.y; ++y) {
      for (int x = first.x; x < last.x; ++x) {
        const geometry::Vec3 center = geometry::center_of({x, y, z}, resolution_m);
        const double distance = sdf(center);
        const geometry::Vec3 to_surface = -distance * sdf_gradient(sdf, center) / resolution_m;
        if (to_surface.cwiseAbs().maxCoeff() <= 0.5) {
          builder.set_occupied({x, y, z}, to_surface);
        } else if (distance > 0.0) {
          builder.set_free({x, y, z});
        }
      }
    }
  }
  return builder.build();
}

/// Returns a content with random states, whose occupied voxels have random surface points.
inline occupancy::MapContent random_content(unsigned seed, int side, double occupied_ratio, double unknown_ratio,
                                            double resolution_m) {
  std::mt19937 rng(seed);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  ContentBuilder builder(resolution_m);
  for (int z = 0; z < side; ++z) {
    for (int y = 0; y < side; ++y) {
      for (int x = 0; x < side; ++x) {
        const geometry::Index3 voxel{x - side / 2, y - 3, z - 20};
        const double draw = unit(rng);
        const geometry::Vec3 offset(unit(rng) - 0.5, unit(rng) - 0.5, unit(rng) - 0.5);
        if (draw < occupied_ratio) {
          builder.set_occupied(voxel, offset);
        } else if (draw > occupied_ratio + unknown_ratio) {
          builder.set_free(voxel);
        }
      }
    }
  }
  return builder.build();
}

inline geometry::Vec3 random_in(std::mt19937* rng, const geometry::Vec3& low, const geometry::Vec3& high) {
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const double x = unit(*rng);
  const double y = unit(*rng);
  const double z = unit(*rng);
  return low + geometry::Vec3(x, y, z).cwiseProduct(high - low);
}

}  // namespace voxnav::test
