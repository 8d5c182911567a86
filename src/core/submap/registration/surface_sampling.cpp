// SPDX-License-Identifier: BSD-3-Clause
#include "submap/registration/surface_sampling.hpp"

#include <algorithm>
#include <array>
#include <memory>

#include "submap/content/content_window.hpp"

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
  constexpr float kHalfway = 3.f;  // number of hits that gives half of the full weight
  const float hits = std::max<float>(num_hits, 1.f);
  return quality * hits / (hits + kHalfway);
}

/// Sorts the points of each cell, the best first, and leaves out empty cells.
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
    // In the last round the remaining points are taken from evenly spaced cells, not from the first ones.
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

std::vector<SurfacePoint> sample_surface(const SubmapContent& content, double resolution_m, const geometry::Pose& T_S_G,
                                         int max_points) {
  std::vector<Cell> all;
  const auto window = std::make_unique<ContentWindow>();
  std::vector<std::uint16_t> inside;
  std::vector<SurfaceNormal> normals;
  const BlockStates& states = content.states();
  for (std::size_t i = 0; i < states.size(); ++i) {
    if (!states.has_occupied(i)) continue;
    window->load(content, states.index(i), 1);
    const Vec3 first = geometry::center_of(geometry::voxel_at(states.index(i), 0), 1.0);
    inside = voxels_of_block(*window);
    estimate_normals(*window, inside, &normals);
    CellsOfBlock cells;
    for (std::size_t k = 0; k < inside.size(); ++k) {
      if (!(normals[k].quality > 0.f)) continue;
      const geometry::Index3& voxel = window->voxels()[inside[k]];
      const std::size_t number = window->numbers()[inside[k]];
      const Vec3 p = (first + Vec3(voxel.x, voxel.y, voxel.z) + window->mean(inside[k]).cast<double>()) * resolution_m;
      const int offset = geometry::offset_in_block(voxel);
      cells[static_cast<std::size_t>(cell_of(offset))].push_back(
          {p.cast<float>(), normals[k].normal, weight_of(normals[k].quality, content.points().believed(number).hits),
           content.points().phase_of(number)});
    }
    append_sorted(std::move(cells), &all);
  }
  return pick(all, T_S_G, max_points);
}

std::vector<SurfacePoint> sample_surface(const occupancy::MapContent& content,
                                         const std::vector<std::vector<SurfaceNormal>>& normals,
                                         const geometry::Pose& T_S_G, int max_points) {
  std::vector<Cell> all;
  for (std::size_t i = 0; i < content.blocks.size(); ++i) {
    CellsOfBlock cells;
    const occupancy::ContentBlock& block = content.blocks[i];
    for (std::size_t k = 0; k < block.occupied.size(); ++k) {
      const SurfaceNormal& surface = normals[i][k];
      if (!(surface.quality > 0.f)) continue;
      const occupancy::OccupiedVoxel& voxel = block.occupied[k];
      const Vec3 p = surface_point(geometry::voxel_at(block.index, voxel.offset), voxel.believed);
      cells[static_cast<std::size_t>(cell_of(voxel.offset))].push_back(
          {(p * content.resolution_m).cast<float>(), surface.normal, weight_of(surface.quality, voxel.believed.hits)});
    }
    append_sorted(std::move(cells), &all);
  }
  return pick(all, T_S_G, max_points);
}

}  // namespace voxnav::submap
