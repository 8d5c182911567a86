// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <set>

#include "submap/content/make_content.hpp"
#include "submap/distance/derive_distances.hpp"
#include "submap/mesh/marching_cubes.hpp"
#include "voxnav/submap/mesh.hpp"

namespace voxnav::submap {
namespace {

using geometry::Index3;
using geometry::Vec3f;

/// The merged map around some blocks, as the content of one submap, so that its distances are derived like those of a
/// submap.
SubmapContent content_around(const EvidenceMap& evidence, const std::vector<Index3>& blocks) {
  std::set<Index3> around;
  for (const Index3& block : blocks) {
    for (int i = 0; i < 27; ++i) around.insert(block + Index3{i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1});
  }
  occupancy::MapContent content;
  content.resolution_m = evidence.resolution_m();
  for (const Index3& index : around) {
    const EvidenceBlock* known = evidence.find(index);
    if (!known) continue;
    occupancy::ContentBlock block{index, to_states(known->states), {}};
    for (const SurfaceEvidence& point : known->points)
      block.occupied.push_back({point.offset, point.point, {}, occupancy::kUnknownTime});
    auto& voxels = block.occupied;
    std::stable_sort(voxels.begin(), voxels.end(), [](const auto& a, const auto& b) { return a.offset < b.offset; });
    const auto is_same = [](const auto& a, const auto& b) { return a.offset == b.offset; };
    voxels.erase(std::unique(voxels.begin(), voxels.end(), is_same), voxels.end());
    content.blocks.push_back(std::move(block));
  }
  return make_content(content, SubmapConfig{}.band_voxels);
}

}  // namespace

Mesh extract_mesh(const Submap& submap, std::size_t max_triangles) {
  Mesh mesh;
  MarchingCubes cubes(submap.T_S_G(), submap.resolution_m(), &mesh);
  const auto content = submap.content();
  for (std::size_t i = 0; i < content->states().size(); ++i) {
    cubes.add_block(content->states().index(i), *submap.distances(*content, i), max_triangles);
  }
  return mesh;
}

Mesh extract_mesh(const EvidenceMap& evidence, const std::vector<Index3>& blocks, std::size_t max_triangles) {
  Mesh mesh;
  MarchingCubes cubes(geometry::Pose::Identity(), evidence.resolution_m(), &mesh);
  const SubmapContent content = content_around(evidence, blocks);
  for (const Index3& block : blocks) {
    const auto distances = derive_distances(content, block);
    if (distances) cubes.add_block(block, *distances, max_triangles);
  }
  for (const Vec3f& p : mesh.vertices) mesh.colors.push_back(color_of_height(p.z()));
  return mesh;
}

Mesh extract_mesh(SubmapCollection* collection, std::size_t max_triangles) {
  constexpr std::size_t kAtOnce = 64;  // blocks unpacked at a time, which bounds the memory
  collection->update();
  const EvidenceMap& evidence = collection->evidence();
  std::vector<Index3> order;
  for (const auto& item : evidence.blocks()) order.push_back(item.first);
  std::sort(order.begin(), order.end());
  Mesh out;
  for (std::size_t i = 0; i < order.size() && out.triangles.size() < max_triangles; i += kAtOnce) {
    const std::vector<Index3> some(order.begin() + static_cast<std::ptrdiff_t>(i),
                                   order.begin() + static_cast<std::ptrdiff_t>(std::min(order.size(), i + kAtOnce)));
    out.append(extract_mesh(evidence, some, max_triangles - out.triangles.size()));
  }
  return out;
}

}  // namespace voxnav::submap
