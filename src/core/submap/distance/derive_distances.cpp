// SPDX-License-Identifier: BSD-3-Clause
#include "submap/distance/derive_distances.hpp"

#include "submap/content/content_window.hpp"
#include "submap/distance/occupied_distances.hpp"
#include "submap/distance/unknown_distances.hpp"

namespace voxnav::submap {
namespace {

using geometry::Index3;
using geometry::kBlockSide;

/// Derives the distances of one block at a time, and keeps its working memory for the next block.
class Deriver {
 public:
  std::shared_ptr<const DistanceBlock> derive(const SubmapContent& content, const Index3& block) {
    const auto band = static_cast<float>(content.band());
    window_.load(content, block, static_cast<int>(band + 1.5f));
    if (window_.voxels().empty()) return nullptr;
    auto out = std::make_shared<DistanceBlock>(content.band());
    out->measure_free(window_.view(), band, &squared_);
    unknown_.find(window_);
    const std::vector<std::uint16_t>& near = unknown_.near_table();
    estimate_normals(window_, near, &normals_);
    for (std::size_t i = 0; i < near.size(); ++i) {
      const geometry::Index3& voxel = window_.voxels()[near[i]];
      if (!is_in_table(voxel)) continue;
      out->set(voxel.x, voxel.y, voxel.z, occupied_distance(window_, near[i], normals_[i], band));
    }
    unknown_.write(window_, normals_, out.get());
    return out;
  }

 private:
  ContentWindow window_;
  kernels::SquaredDistances squared_;
  UnknownDistances unknown_;
  std::vector<SurfaceNormal> normals_;
};

std::shared_ptr<const DistanceBlock> copy_measured(const SubmapContent& content, const Index3& block) {
  auto out = std::make_shared<DistanceBlock>(content.band());
  const Index3 first = geometry::voxel_at(block, 0);
  for (int z = -1; z <= kBlockSide; ++z) {
    for (int y = -1; y <= kBlockSide; ++y) {
      for (int x = -1; x <= kBlockSide; ++x) {
        const Index3 voxel = first + Index3{x, y, z};
        const auto position = content.states().find(geometry::block_of(voxel));
        if (!position) continue;
        const auto distance = content.measured()->at(*position, geometry::offset_in_block(voxel));
        if (distance) out->set(x, y, z, *distance);
      }
    }
  }
  return out->is_empty() ? nullptr : out;
}

}  // namespace

std::shared_ptr<const DistanceBlock> derive_distances(const SubmapContent& content, const Index3& block) {
  if (content.measured()) return copy_measured(content, block);
  static thread_local std::unique_ptr<Deriver> deriver;
  if (!deriver) deriver = std::make_unique<Deriver>();
  return deriver->derive(content, block);
}

}  // namespace voxnav::submap
