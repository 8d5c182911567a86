// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <map>

#include "voxnav/submap/evidence_map.hpp"

namespace voxnav::submap {
namespace {

using geometry::Index3;
using geometry::Vec3;

struct Changed {
  Vec3 point_W;
  std::uint32_t submap_id;
};
using ChangedVoxels = std::map<Index3, Changed>;

template <class F>
bool any_neighbor(const Index3& voxel, F&& f) {
  for (int i = 0; i < 27; ++i) {
    if (i != 13 && f(voxel + Index3{i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1})) return true;
  }
  return false;
}

/// Returns true if a voxel holds a surface point where no older submap saw free space.
bool is_old_surface(const EvidenceMap& evidence, const Index3& voxel) {
  const EvidenceBlock* block = evidence.find(geometry::block_of(voxel));
  const int offset = geometry::offset_in_block(voxel);
  if (!block || block->states.get(offset) != containers::VoxelState::kOccupied) return false;
  return std::none_of(block->points.begin(), block->points.end(),
                      [&](const SurfaceEvidence& point) { return point.offset == offset && point.is_new; });
}

ChangedVoxels appeared(const EvidenceMap& evidence) {
  ChangedVoxels out;
  for (const auto& [index, block] : evidence.blocks()) {
    for (const SurfaceEvidence& point : block.points) {
      if (!point.is_new) continue;
      const Index3 voxel = geometry::voxel_at(index, point.offset);
      if (any_neighbor(voxel, [&](const Index3& other) { return is_old_surface(evidence, other); })) continue;
      out[voxel] = {evidence.point_of(index, point), point.submap_id};
    }
  }
  return out;
}

ChangedVoxels disappeared(const EvidenceMap& evidence) {
  ChangedVoxels out;
  for (const auto& [index, block] : evidence.blocks()) {
    for (const SurfaceEvidence& point : block.removed) {
      out[geometry::voxel_at(index, point.offset)] = {evidence.point_of(index, point), point.submap_id};
    }
  }
  return out;
}

/// Removes the connected group of the first voxel from the set and returns it.
SceneChange take_group(SceneChange::Kind kind, ChangedVoxels* voxels) {
  SceneChange out{kind, {}, Vec3::Zero(), 0, 0};
  std::vector<Index3> open = {voxels->begin()->first};
  const auto take = [&](const Index3& voxel) {
    const auto found = voxels->find(voxel);
    if (found == voxels->end()) return false;
    out.box_W.extend(found->second.point_W);
    out.center_W += found->second.point_W;
    out.submap_id = std::max(out.submap_id, found->second.submap_id);
    ++out.num_voxels;
    voxels->erase(found);
    return true;
  };
  take(open.front());
  while (!open.empty()) {
    const Index3 voxel = open.back();
    open.pop_back();
    any_neighbor(voxel, [&](const Index3& other) {
      if (take(other)) open.push_back(other);
      return false;
    });
  }
  out.center_W /= static_cast<double>(out.num_voxels);
  return out;
}

}  // namespace

std::vector<SceneChange> scene_changes(const EvidenceMap& evidence, std::size_t min_voxels) {
  std::vector<SceneChange> out;
  for (const auto kind : {SceneChange::Kind::kAppeared, SceneChange::Kind::kDisappeared}) {
    ChangedVoxels voxels = kind == SceneChange::Kind::kAppeared ? appeared(evidence) : disappeared(evidence);
    while (!voxels.empty()) {
      const SceneChange group = take_group(kind, &voxels);
      if (group.num_voxels >= min_voxels) out.push_back(group);
    }
  }
  return out;
}

}  // namespace voxnav::submap
