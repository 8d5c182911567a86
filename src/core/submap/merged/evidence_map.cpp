// SPDX-License-Identifier: BSD-3-Clause
#include "submap/merged/evidence_map.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace voxnav::submap {
namespace {

using containers::State;
using geometry::Index3;
using geometry::kBlockSide;
using geometry::Vec3;

geometry::Aabb block_box(const Index3& block, double side_m) {
  return {Vec3(block.x, block.y, block.z) * side_m, Vec3(block.x + 1, block.y + 1, block.z + 1) * side_m};
}

bool has(const Columns& columns, const PlacedLeaf& leaf) {
  return ((columns[leaf.offset & 255u] >> (leaf.offset >> 8)) & 1) != 0;
}

/// Whether the voxel below that of a leaf is set, where both are in the block.
bool has_below(const Columns& columns, const PlacedLeaf& leaf) {
  const int z = leaf.offset >> 8;
  return z > 0 && ((columns[leaf.offset & 255u] >> (z - 1)) & 1) != 0;
}

/// The same of the voxel above.
bool has_above(const Columns& columns, const PlacedLeaf& leaf) {
  return (((columns[leaf.offset & 255u] >> 1) >> (leaf.offset >> 8)) & 1) != 0;
}

void set(const PlacedLeaf& leaf, Columns* columns) {
  (*columns)[leaf.offset & 255u] |= static_cast<std::uint16_t>(1u << (leaf.offset >> 8));
}

/// Leaves that were taken away, one per voxel.
class Gone {
 public:
  explicit Gone(std::vector<EvidenceLeaf>* leaves) : leaves_(leaves) {}
  void add(EvidenceLeaf leaf, std::uint32_t by) {
    if (!is_listed_) list();
    leaf.submap_id = by;
    if (has(voxels_, leaf)) {
      *std::find_if(leaves_->begin(), leaves_->end(),
                    [&](const EvidenceLeaf& other) { return other.offset == leaf.offset; }) = leaf;
    } else {
      leaves_->push_back(leaf);
      set(leaf, &voxels_);
    }
  }

 private:
  void list() {
    voxels_.fill(0);
    for (const EvidenceLeaf& leaf : *leaves_) set(leaf, &voxels_);
    is_listed_ = true;
  }

  std::vector<EvidenceLeaf>* leaves_;
  Columns voxels_;
  bool is_listed_ = false;
};

/// Whether every voxel is known, so that more free space says nothing new.
bool is_decided(const ColumnBlock& states) {
  unsigned all = 0xFFFFu;
  for (std::size_t i = 0; i < states.free.size(); ++i) all &= states.free[i] | states.occupied[i];
  return all == 0xFFFFu;
}

}  // namespace

EvidenceMap::EvidenceMap(const EvidenceRules& rules) : rules_(rules) {
  if (!(rules.resolution_m > 0.0)) throw std::invalid_argument("resolution_m must be positive");
}

void EvidenceMap::integrate(const Index3& index, const PlacedSubmap& submap) {
  static const Columns kNone{};
  const PlacedLeaves::Around around(submap.leaves(), index);
  const PlacedLeaves::Block* leaves = around.center();
  EvidenceBlock& block = blocks_[index];
  if (!leaves && block.leaves.empty() && is_decided(block.states)) return;
  const PlacedSubmap::FreeInBlock free(submap, index);
  drop_older({index, submap, around, free, leaves ? leaves->occupied : kNone}, &block);
  if (leaves) add_leaves(submap, *leaves, &block);
  if (!is_decided(block.states)) free.add_to(&block.states.free);
  // Under a leaf nothing is free, also not once a newer submap has taken the leaf away: that submap has to say so.
  for (std::size_t i = 0; i < block.states.free.size(); ++i) block.states.free[i] &= ~block.states.occupied[i];
  if (block.leaves.empty() && block.gone.empty() && block.states.all_unknown()) blocks_.erase(index);
}

void EvidenceMap::add_leaves(const PlacedSubmap& submap, const PlacedLeaves::Block& leaves, EvidenceBlock* block) {
  const PlacedLeaf* from = submap.leaves().begin(leaves);
  const auto count = static_cast<std::size_t>(submap.leaves().end(leaves) - from);
  const std::size_t num_older = block->leaves.size();
  block->leaves.resize(num_older + count);
  for (std::size_t i = 0; i < count; ++i) {
    EvidenceLeaf& leaf = block->leaves[num_older + i];
    static_cast<PlacedLeaf&>(leaf) = from[i];
    leaf.submap_id = submap.id();
    leaf.is_new = has(block->states.free, from[i]);
    leaf.is_doubted = false;
  }
  for (std::size_t i = 0; i < leaves.occupied.size(); ++i) block->states.occupied[i] |= leaves.occupied[i];
}

/// A doubt lasts until a submap has a surface there: a sparse sensor sees a voxel and the one below it at other times.
/// Of leaves that are replaced anyway, only those are asked for that another one stands on.
/// @return whether any is in doubt
bool EvidenceMap::doubt(const Newer& newer, EvidenceBlock* block) const {
  bool any_doubted = false;
  const double clearing = rules_.clearing_distance_m / rules_.resolution_m;
  Columns unseen;
  for (std::size_t i = 0; i < unseen.size(); ++i) {
    unseen[i] = static_cast<std::uint16_t>(block->states.occupied[i] & ~newer.seen[i]);
  }
  for (EvidenceLeaf& leaf : block->leaves) {
    if (has(newer.seen, leaf) && !has_above(unseen, leaf)) continue;
    const bool is_free = (newer.free.at(leaf) & 2u) != 0;
    if (!is_free && !leaf.is_doubted) continue;
    if (newer.around.has_within(units_of(leaf), clearing)) {
      leaf.is_doubted = false;
    } else if (is_free) {
      leaf.is_doubted = leaf.is_doubted || is_near_enough(newer, leaf);
    }
    any_doubted |= leaf.is_doubted;
  }
  return any_doubted;
}

/// Newer points replace the older ones of their voxel; newer free space removes others.
void EvidenceMap::drop_older(const Newer& newer, EvidenceBlock* block) const {
  if (!block->leaves.empty() && doubt(newer, block)) drop_doubted(newer, block);
  if (!newer.around.center()) return;
  const auto is_replaced = [&](const EvidenceLeaf& leaf) { return has(newer.seen, leaf); };
  for (std::vector<EvidenceLeaf>* leaves : {&block->leaves, &block->gone}) {
    leaves->erase(std::remove_if(leaves->begin(), leaves->end(), is_replaced), leaves->end());
  }
  for (std::size_t i = 0; i < newer.seen.size(); ++i) block->states.occupied[i] &= ~newer.seen[i];
}

/// Those below which is free space too, or the ground that something stood on.
void EvidenceMap::drop_doubted(const Newer& newer, EvidenceBlock* block) const {
  // Of blocks below only the submap's own word counts: what is merged there may be of any age.
  Columns open = block->states.free;
  for (const EvidenceLeaf& leaf : block->leaves) {
    if (leaf.is_doubted) set(leaf, &open);
  }
  Gone gone(&block->gone);
  const auto is_over = [&](const EvidenceLeaf& leaf) {
    if (!leaf.is_doubted || has(newer.seen, leaf)) return false;
    if (!has_below(open, leaf) && (newer.free.at(leaf) & 1u) == 0) {
      if (!newer.around.has_within(units_of(leaf) - Units3{0, 0, kUnitsPerEdge}, 1.0)) return false;
    }
    gone.add(leaf, newer.submap.id());
    return true;
  };
  block->leaves.erase(std::remove_if(block->leaves.begin(), block->leaves.end(), is_over), block->leaves.end());
  block->states.occupied.fill(0);
  for (const EvidenceLeaf& leaf : block->leaves) set(leaf, &block->states.occupied);
}

/// Beams miss thin things from afar.
bool EvidenceMap::is_near_enough(const Newer& newer, const EvidenceLeaf& leaf) const {
  if (!leaf.is_thin) return true;
  const auto range_m = newer.submap.range_to(point_of(newer.index, leaf));
  return !range_m || *range_m <= std::max(rules_.thin_range_m, leaf.range_m());
}

void EvidenceMap::reset_block(const Index3& index) {
  const auto found = blocks_.find(index);
  if (found == blocks_.end()) return;
  found->second.states = {};
  found->second.leaves.clear();
  found->second.gone.clear();
}

const EvidenceBlock* EvidenceMap::find(const Index3& block) const {
  const auto it = blocks_.find(block);
  return it == blocks_.end() ? nullptr : &it->second;
}

State EvidenceMap::state(const Vec3& p_W) const {
  if (!((p_W.array().abs() / rules_.resolution_m) < 1073741824.0).all()) return State::kUnknown;
  const Index3 voxel = geometry::index_of(p_W, rules_.resolution_m);
  const EvidenceBlock* block = find(geometry::block_of(voxel));
  return block ? block->states.get(geometry::offset_in_block(voxel)) : State::kUnknown;
}

Vec3 EvidenceMap::point_of(const Index3& block, const EvidenceLeaf& leaf) const {
  const Vec3 mean(leaf.mean[0], leaf.mean[1], leaf.mean[2]);
  return geometry::center_of(geometry::voxel_at(block, leaf.offset), rules_.resolution_m) +
         mean * (rules_.resolution_m / 254.0);
}

std::optional<double> EvidenceMap::distance_to_surface(const Vec3& p_W, double max_distance_m) const {
  const auto nearest = nearest_surface(p_W, max_distance_m);
  if (!nearest) return std::nullopt;
  return nearest->distance_m;
}

std::optional<NearestSurface> EvidenceMap::nearest_surface(const Vec3& p_W, double max_distance_m) const {
  if (!((p_W.array().abs() / rules_.resolution_m) < 1073741824.0).all()) return std::nullopt;
  const double side_m = kBlockSide * rules_.resolution_m;
  const double limit = max_distance_m * max_distance_m;
  NearestSurface best{Vec3::Zero(), limit};  // squared until the end
  const auto search = [&](const Index3& index) {
    const geometry::Aabb box = block_box(index, side_m);
    if ((p_W - p_W.cwiseMax(box.min).cwiseMin(box.max)).squaredNorm() >= best.distance_m) return;
    const EvidenceBlock* block = find(index);
    if (!block) return;
    for (const EvidenceLeaf& leaf : block->leaves) {
      const Vec3 point = point_of(index, leaf);
      const double squared = (p_W - point).squaredNorm();
      if (squared < best.distance_m) best = {point, squared};
    }
  };
  // The block of the point first: what it holds rules most of the others out.
  search(geometry::index_of(p_W, side_m));
  const Index3 low = geometry::index_of(p_W - Vec3::Constant(max_distance_m), side_m);
  const Index3 high = geometry::index_of(p_W + Vec3::Constant(max_distance_m), side_m);
  for (int z = low.z; z <= high.z; ++z) {
    for (int y = low.y; y <= high.y; ++y) {
      for (int x = low.x; x <= high.x; ++x) search({x, y, z});
    }
  }
  if (!(best.distance_m < limit)) return std::nullopt;
  best.distance_m = std::sqrt(best.distance_m);
  return best;
}

std::size_t EvidenceMap::memory_bytes() const {
  std::size_t bytes = sizeof(*this) + blocks_.bucket_count() * sizeof(void*);
  for (const auto& entry : blocks_) {
    bytes += sizeof(entry) + 2 * sizeof(void*) +
             (entry.second.leaves.capacity() + entry.second.gone.capacity()) * sizeof(EvidenceLeaf);
  }
  return bytes;
}

}  // namespace voxnav::submap
