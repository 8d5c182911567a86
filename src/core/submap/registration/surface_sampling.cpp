// SPDX-License-Identifier: BSD-3-Clause
#include "submap/registration/surface_sampling.hpp"

#include <algorithm>
#include <array>
#include <memory>

#include "submap/content/field_window.hpp"

namespace voxnav::submap {
namespace {

using geometry::SurfacePoint;
using geometry::Vec3;

struct Candidate {
  geometry::Vec3f point;  ///< m, frame G
  geometry::Vec3f normal;
  float weight;
  float phase = 0.5f;
};
using Cell = std::vector<Candidate>;
using CellsOfBlock = std::array<Cell, 64>;

float weight_of(float quality, std::uint8_t num_hits) {
  constexpr float kHalfway = 3.f;  // hits that give half of the full weight
  const float hits = std::max<float>(num_hits, 1.f);
  return quality * hits / (hits + kHalfway);
}

/// Best first, empty ones left out.
void append_sorted(CellsOfBlock&& cells, std::vector<Cell>* out) {
  for (Cell& cell : cells) {
    if (cell.empty()) continue;
    std::stable_sort(cell.begin(), cell.end(),
                     [](const Candidate& a, const Candidate& b) { return a.weight > b.weight; });
    out->push_back(std::move(cell));
  }
}

std::vector<SurfacePoint> pick(const std::vector<Cell>& cells, const geometry::Pose& T_S_G, int max_points) {
  std::vector<SurfacePoint> out;
  const auto limit = static_cast<std::size_t>(max_points);
  for (std::size_t round = 0; round < 64; ++round) {
    std::vector<const Candidate*> next;
    for (const Cell& cell : cells) {
      if (round < cell.size()) next.push_back(&cell[round]);
    }
    if (next.empty() || out.size() >= limit) break;
    // In the last round the places left go to evenly spaced cells, not to the first ones.
    const std::size_t take = std::min(next.size(), limit - out.size());
    for (std::size_t i = 0; i < take; ++i) {
      const Candidate& chosen = *next[i * next.size() / take];
      const Vec3 normal = T_S_G.linear() * chosen.normal.cast<double>();
      out.push_back({(T_S_G * chosen.point.cast<double>().eval()).cast<float>(), normal.cast<float>(), chosen.weight,
                     chosen.phase});
    }
  }
  return out;
}

}  // namespace

std::vector<SurfacePoint> sample_surface(const CompressedField& field, double resolution_m, const geometry::Pose& T_S_G,
                                         int max_points) {
  std::vector<Cell> all;
  const auto window = std::make_unique<FieldWindow>();
  std::vector<std::uint16_t> inside;
  std::vector<LeafNormal> normals;
  for (std::size_t i = 0; i < field.num_blocks(); ++i) {
    if (!field.has_surface(static_cast<int>(i))) continue;
    window->load(field, field.block_index(i), 1);
    const Vec3 first = geometry::center_of(geometry::voxel_at(field.block_index(i), 0), 1.0);
    inside = leaves_of_block(*window);
    estimate_normals(*window, inside, &normals);
    CellsOfBlock cells;
    for (std::size_t k = 0; k < inside.size(); ++k) {
      const WindowLeaf& leaf = window->leaves()[inside[k]];
      const LeafNormal& surface = normals[k];
      if (!(surface.quality > 0.f)) continue;
      const Vec3 p = (first + Vec3(leaf.x, leaf.y, leaf.z) + leaf.mean().cast<double>()) * resolution_m;
      const int cell = CompressedField::cell_of(leaf.x | (leaf.y << 4) | (leaf.z << 8));
      cells[static_cast<std::size_t>(cell)].push_back(
          {p.cast<float>(), surface.normal, weight_of(surface.quality, leaf.leaf.hits), leaf.phase});
    }
    append_sorted(std::move(cells), &all);
  }
  return pick(all, T_S_G, max_points);
}

std::vector<SurfacePoint> sample_surface(const std::vector<FilledBlock>& blocks, double resolution_m,
                                         const geometry::Pose& T_S_G, int max_points) {
  std::vector<Cell> all;
  for (const FilledBlock& block : blocks) {
    CellsOfBlock cells;
    for (const FilledLeaf& leaf : block.leaves) {
      if (!(leaf.quality > 0.f)) continue;
      const Vec3 p = surface_point(geometry::voxel_at(block.index, leaf.offset), {leaf.mean, leaf.hits});
      cells[static_cast<std::size_t>(CompressedField::cell_of(leaf.offset))].push_back(
          {(p * resolution_m).cast<float>(), leaf.normal, weight_of(leaf.quality, leaf.hits)});
    }
    append_sorted(std::move(cells), &all);
  }
  return pick(all, T_S_G, max_points);
}

}  // namespace voxnav::submap
