// SPDX-License-Identifier: BSD-3-Clause
#include "submap/merged/footprint.hpp"

#include "submap/content/submap_content.hpp"
#include "submap/merged/block_marks.hpp"
#include "submap/voxel_walk.hpp"

namespace voxnav::submap {

using geometry::Index3;
using geometry::kBlockSide;
using geometry::Pose;
using geometry::Vec3;

namespace {

/// Computes the boxes around the blocks of a submap. All blocks are rotated alike, so each box is that of the first
/// block, shifted.
class PlacedBox {
 public:
  PlacedBox(const Pose& T_W_G, double side_G)
      : T_W_G_(T_W_G), side_G_(side_G), unit_(geometry::Aabb{Vec3::Zero(), Vec3::Constant(side_G)}.transformed(T_W_G)) {
    unit_.min -= T_W_G.translation();
    unit_.max -= T_W_G.translation();
  }
  void extend(const Index3& block, geometry::Aabb* box) const {
    const Vec3 origin = T_W_G_ * (Vec3(block.x, block.y, block.z) * side_G_);
    box->extend(origin + unit_.min);
    box->extend(origin + unit_.max);
  }

 private:
  Pose T_W_G_;
  double side_G_;
  geometry::Aabb unit_;
};

}  // namespace

std::vector<Pose> extremes(const Placement& placement) {
  if (placement.bend.is_rigid()) return {placement.T_W_S};
  return {placement.T_W_S, placement.T_W_S * placement.bend.T_S_begin, placement.T_W_S * placement.bend.T_S_end};
}

std::vector<Index3> footprint(const Submap& submap, const Placement& placement, double resolution_m,
                              Knowledge knowledge) {
  const double side_G = kBlockSide * submap.resolution_m();
  const double side_W = kBlockSide * resolution_m;
  std::vector<Index3> out;
  const auto content = submap.content();
  const BlockStates& states = content->states();
  std::vector<PlacedBox> boxes;
  for (const Pose& T_W_S : extremes(placement)) boxes.emplace_back(T_W_S * submap.T_S_G(), side_G);
  for (std::size_t i = 0; i < states.size(); ++i) {
    if (knowledge == Knowledge::kObserved && !content->is_observed(i)) continue;
    const Index3& block = states.index(i);
    geometry::Aabb box;
    for (const PlacedBox& placed : boxes) placed.extend(block, &box);
    const Index3 low = floor_index(box.min / side_W);
    const Index3 high = floor_index(box.max / side_W);
    for (int z = low.z; z <= high.z; ++z) {
      for (int y = low.y; y <= high.y; ++y) {
        for (int x = low.x; x <= high.x; ++x) out.push_back({x, y, z});
      }
    }
  }
  sort_unique(&out);
  return out;
}

}  // namespace voxnav::submap
