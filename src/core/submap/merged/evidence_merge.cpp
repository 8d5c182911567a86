// SPDX-License-Identifier: BSD-3-Clause
#include "submap/merged/evidence_merge.hpp"

#include <algorithm>

namespace voxnav::submap {
namespace {

// A voxel with the offset x + 16 y + 256 z is bit z of the column x + 16 y.

bool has(const Columns& columns, const SurfaceEvidence& evidence) {
  return ((columns[evidence.offset & 255u] >> (evidence.offset >> 8)) & 1) != 0;
}

/// Returns true if the voxel below that of a surface point is set; false if it lies in another block.
bool has_below(const Columns& columns, const SurfaceEvidence& evidence) {
  const int z = evidence.offset >> 8;
  return z > 0 && ((columns[evidence.offset & 255u] >> (z - 1)) & 1) != 0;
}

/// Returns true if the voxel above that of a surface point is set; false if it lies in another block.
bool has_above(const Columns& columns, const SurfaceEvidence& evidence) {
  return (((columns[evidence.offset & 255u] >> 1) >> (evidence.offset >> 8)) & 1) != 0;
}

void set(const SurfaceEvidence& evidence, Columns* columns) {
  (*columns)[evidence.offset & 255u] |= static_cast<std::uint16_t>(1u << (evidence.offset >> 8));
}

/// Adds to the list of removed surface points, which holds at most one point, the last one, for each voxel.
class Removed {
 public:
  explicit Removed(std::vector<SurfaceEvidence>* points) : points_(points) {}
  void add(SurfaceEvidence point, std::uint32_t by) {
    if (!is_listed_) list();
    point.submap_id = by;
    if (has(voxels_, point)) {
      *std::find_if(points_->begin(), points_->end(),
                    [&](const SurfaceEvidence& other) { return other.offset == point.offset; }) = point;
    } else {
      points_->push_back(point);
      set(point, &voxels_);
    }
  }

 private:
  void list() {
    voxels_.fill(0);
    for (const SurfaceEvidence& point : *points_) set(point, &voxels_);
    is_listed_ = true;
  }

  std::vector<SurfaceEvidence>* points_;
  Columns voxels_;
  bool is_listed_ = false;
};

/// Where beams only passed by, no surface of the newer submap may lie within this many clearing distances.
constexpr double kPassedClearings = 2.0;

const Columns& occupied_of(const PlacedPoints::Block* points) {
  static const Columns kNone{};
  return points ? points->occupied : kNone;
}

}  // namespace

bool is_decided(const ColumnBlock& states) {
  unsigned all = 0xFFFFu;
  for (std::size_t i = 0; i < states.free.size(); ++i) all &= states.free[i] | states.occupied[i];
  return all == 0xFFFFu;
}

EvidenceMerge::EvidenceMerge(const EvidenceRules& rules, const PlacedSubmap& submap, const PlacedPoints::Around& around,
                             EvidenceBlock* block)
    : rules_(rules),
      submap_(submap),
      around_(around),
      block_(block),
      free_(submap, around.index()),
      seen_(occupied_of(around_.center())) {}

void EvidenceMerge::run() {
  if (!block_->points.empty() && doubt()) remove_doubted();
  if (around_.center()) {
    drop_replaced();
    add_points(*around_.center());
  }
  ColumnBlock& states = block_->states;
  if (!is_decided(states)) free_.add_to(&states.free);
  // The voxel of a surface point is never free. It does not become free again when a newer submap removes the point,
  // unless that submap observed free space there.
  for (std::size_t i = 0; i < states.free.size(); ++i) states.free[i] &= ~states.occupied[i];
}

/// Casts doubt on older points in voxels that this submap observed as free. The doubt lasts until a submap has a
/// surface there, because a sparse sensor observes a voxel and the one below it at different times. Points that this
/// submap replaces are skipped, except below a voxel with another point, whose removal depends on them.
/// @return true if any point is in doubt
bool EvidenceMerge::doubt() {
  bool any_doubted = false;
  const double clearing = rules_.clearing_distance_m / rules_.resolution_m;
  Columns unseen;
  for (std::size_t i = 0; i < unseen.size(); ++i) {
    unseen[i] = static_cast<std::uint16_t>(block_->states.occupied[i] & ~seen_[i]);
  }
  for (SurfaceEvidence& point : block_->points) {
    if (has(seen_, point) && !has_above(unseen, point)) continue;
    const FreeAt free = free_.is_free(point);
    const bool is_free = free.at_point || is_passed(point, free);
    if (!is_free && !point.is_doubted) continue;
    if (around_.has_within(units_of(point), clearing)) {
      point.is_doubted = false;
    } else if (is_free) {
      point.is_doubted = point.is_doubted || is_near_enough(point);
    }
    any_doubted |= point.is_doubted;
  }
  return any_doubted;
}

/// Returns true if beams passed closely below and above a point without a surface anywhere near: a sparse sensor at
/// one height looks between the same voxels again and again, and never into some. A thin thing may hide between beams.
bool EvidenceMerge::is_passed(const SurfaceEvidence& point, const FreeAt& free) const {
  if (point.is_thin || has(seen_, point) || !free.below || !free.above) return false;
  return !around_.has_within(units_of(point), kPassedClearings * rules_.clearing_distance_m / rules_.resolution_m);
}

/// Removes the points in doubt below which is free space as well, or a surface of this submap: the ground on which the
/// thing stood.
void EvidenceMerge::remove_doubted() {
  // If the voxel below lies in another block, only what this submap observed there counts: that block may be merged up
  // to any submap at this time.
  Columns open = block_->states.free;
  for (const SurfaceEvidence& point : block_->points) {
    if (point.is_doubted) set(point, &open);
  }
  Removed removed(&block_->removed);
  const auto is_over = [&](const SurfaceEvidence& point) {
    if (!point.is_doubted || has(seen_, point)) return false;
    if (!has_below(open, point) && !free_.is_free(point).below) {
      if (!around_.has_within(units_of(point) - Units3{0, 0, kUnitsPerEdge}, 1.0)) return false;
    }
    removed.add(point, submap_.id());
    return true;
  };
  std::vector<SurfaceEvidence>& points = block_->points;
  points.erase(std::remove_if(points.begin(), points.end(), is_over), points.end());
  block_->states.occupied.fill(0);
  for (const SurfaceEvidence& point : points) set(point, &block_->states.occupied);
}

void EvidenceMerge::drop_replaced() {
  const auto is_replaced = [&](const SurfaceEvidence& point) { return has(seen_, point); };
  for (std::vector<SurfaceEvidence>* points : {&block_->points, &block_->removed}) {
    points->erase(std::remove_if(points->begin(), points->end(), is_replaced), points->end());
  }
  for (std::size_t i = 0; i < seen_.size(); ++i) block_->states.occupied[i] &= ~seen_[i];
}

void EvidenceMerge::add_points(const PlacedPoints::Block& points) {
  const std::size_t num_older = block_->points.size();
  block_->points.insert(block_->points.end(), submap_.points().begin(points), submap_.points().end(points));
  for (std::size_t i = num_older; i < block_->points.size(); ++i) {
    SurfaceEvidence& point = block_->points[i];
    point.is_new = has(block_->states.free, point);
  }
  for (std::size_t i = 0; i < seen_.size(); ++i) block_->states.occupied[i] |= seen_[i];
}

/// Returns true if a thin thing was observed from near enough to be sure that it is gone: from afar beams miss it.
bool EvidenceMerge::is_near_enough(const SurfaceEvidence& evidence) const {
  if (!evidence.is_thin) return true;
  const auto range_m = submap_.range_to(point_in_W(around_.index(), evidence, rules_.resolution_m));
  return !range_m || *range_m <= std::max(rules_.thin_range_m, evidence.range_m());
}

}  // namespace voxnav::submap
