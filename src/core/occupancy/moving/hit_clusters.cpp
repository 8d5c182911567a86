// SPDX-License-Identifier: BSD-3-Clause
#include "occupancy/moving/hit_clusters.hpp"

#include <algorithm>
#include <unordered_map>

namespace voxnav::occupancy {
namespace {

/// A cell, and the hits in it.
struct Cell {
  geometry::Index3 index;
  std::vector<std::size_t> hits;
  bool is_reached = false;
};

using CellNumbers = std::unordered_map<geometry::Index3, std::size_t, geometry::Index3Hash>;

/// Appends the neighbours of a cell that were not reached before.
void reach_neighbours(std::size_t from, const CellNumbers& numbers, std::vector<Cell>* cells,
                      std::vector<std::size_t>* reached) {
  for (int z = -1; z <= 1; ++z) {
    for (int y = -1; y <= 1; ++y) {
      for (int x = -1; x <= 1; ++x) {
        const auto found = numbers.find((*cells)[from].index + geometry::Index3{x, y, z});
        if (found == numbers.end() || (*cells)[found->second].is_reached) continue;
        (*cells)[found->second].is_reached = true;
        reached->push_back(found->second);
      }
    }
  }
}

}  // namespace

void HitCluster::add(std::size_t index, const NewHit& hit) {
  const geometry::Vec3 point = hit.point.cast<double>();
  hits.push_back(index);
  box.extend(point);
  num_returns += hit.num_points;
  center += (point - center) / static_cast<double>(hits.size());
}

void HitCluster::add(const HitCluster& other) {
  const double share = static_cast<double>(other.hits.size()) / static_cast<double>(hits.size() + other.hits.size());
  center += share * (other.center - center);
  hits.insert(hits.end(), other.hits.begin(), other.hits.end());
  num_returns += other.num_returns;
  box.extend(other.box.min);
  box.extend(other.box.max);
}

std::vector<HitCluster> connected_hits(const std::vector<NewHit>& hits, double cell_m) {
  CellNumbers numbers;
  std::vector<Cell> cells;
  for (std::size_t i = 0; i < hits.size(); ++i) {
    if (!hits[i].is_clear) continue;
    const geometry::Index3 index = geometry::index_of(hits[i].point.cast<double>(), cell_m);
    const auto [at, is_new] = numbers.try_emplace(index, cells.size());
    if (is_new) cells.push_back({index, {}});
    cells[at->second].hits.push_back(i);
  }
  std::vector<HitCluster> out;
  std::vector<std::size_t> reached;
  for (std::size_t first = 0; first < cells.size(); ++first) {
    if (cells[first].is_reached) continue;
    cells[first].is_reached = true;
    reached.assign(1, first);
    for (std::size_t next = 0; next < reached.size(); ++next)
      reach_neighbours(reached[next], numbers, &cells, &reached);
    std::vector<std::size_t> members;
    for (const std::size_t cell : reached) {
      members.insert(members.end(), cells[cell].hits.begin(), cells[cell].hits.end());
    }
    std::sort(members.begin(), members.end());
    HitCluster cluster;
    for (const std::size_t i : members) cluster.add(i, hits[i]);
    out.push_back(std::move(cluster));
  }
  std::stable_sort(out.begin(), out.end(),
                   [](const HitCluster& a, const HitCluster& b) { return a.hits.size() > b.hits.size(); });
  return out;
}

}  // namespace voxnav::occupancy
