// SPDX-License-Identifier: BSD-3-Clause
#include "submap/merged/submap_merge.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

#include "submap/merged/block_marks.hpp"
#include "submap/merged/placed_submap.hpp"

namespace voxnav::submap {
namespace {

using geometry::Index3;
using geometry::Pose;
using geometry::Vec3;

/// Returns how far the corners of a box move at most between two placements.
double largest_move(const geometry::Aabb& box, const Pose& a, const Pose& b) {
  double largest = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 p((corner & 1) ? box.max.x() : box.min.x(), (corner & 2) ? box.max.y() : box.min.y(),
                 (corner & 4) ? box.max.z() : box.min.z());
    largest = std::max(largest, (a * p - b * p).norm());
  }
  return largest;
}

double largest_move(const geometry::Aabb& box, const Placement& a, const Placement& b) {
  if (box.empty()) return 0.0;
  return std::max({largest_move(box, a.T_W_S, b.T_W_S),
                   largest_move(box, a.T_W_S * a.bend.T_S_begin, b.T_W_S * b.bend.T_S_begin),
                   largest_move(box, a.T_W_S * a.bend.T_S_end, b.T_W_S * b.bend.T_S_end)});
}

/// Returns a few positions of the sensor along its path, in W.
std::vector<Vec3> viewpoints(const std::vector<geometry::StampedPose>& T_S_B, const Pose& T_W_S) {
  constexpr std::size_t kMost = 5;
  std::vector<Vec3> out;
  const std::size_t count = std::min(kMost, T_S_B.size());
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t at = count == 1 ? 0 : i * (T_S_B.size() - 1) / (count - 1);
    out.emplace_back(T_W_S * T_S_B[at].pose.translation());
  }
  return out;
}

}  // namespace

SubmapMerge::SubmapMerge(const SubmapCollectionConfig& config)
    : resolution_m_(config.resolution_m),
      pose_tolerance_m_(config.pose_tolerance_m),
      evidence_({config.resolution_m, config.clearing_distance_m, config.thin_range_m}) {}

/// Decides which content of a submap is merged. Remembered content is merged only if the submap before it is absent,
/// which shows in its id: the submaps of a flight are numbered without gaps.
Knowledge SubmapMerge::knowledge_of(const SubmapStore& store, const StoredSubmap& record) const {
  if (!record.has_memory) return Knowledge::kObserved;
  const StoredSubmap* before = record.entry.id > 0 ? store.find(record.entry.id - 1) : nullptr;
  return before && before->entry.flight == record.entry.flight ? Knowledge::kObserved : Knowledge::kAll;
}

bool SubmapMerge::has_changed(const SubmapStore& store, const StoredSubmap& record) const {
  const Placement now{record.entry.T_W_S, record.entry.bend};
  return record.merged != knowledge_of(store, record) ||
         largest_move(record.entry.submap->known_bounds(), now, record.merged_at) > pose_tolerance_m_;
}

/// Returns true if a submap that is merged in a block observed something in it.
bool SubmapMerge::has_observed(const SubmapStore& store, const SubmapKey& key, const Index3& block) const {
  const StoredSubmap& record = store.at(key);
  return record.merged == Knowledge::kObserved ||
         std::binary_search(record.observed_blocks.begin(), record.observed_blocks.end(), block);
}

/// Returns true if the remembered content of the oldest submap of a block is merged there: no other submap observed the
/// block.
/// @param without  submap that is not considered, or null
bool SubmapMerge::memory_counts(const SubmapStore& store, const Index3& block, const SubmapKey* without) const {
  if (num_with_memory_ == 0) return false;
  const std::vector<SubmapKey>& keys = by_block_.at(block);
  if (store.at(keys.front()).merged == Knowledge::kObserved) return false;
  return std::none_of(keys.begin() + 1, keys.end(), [&](const SubmapKey& key) {
    return (!without || key != *without) && has_observed(store, key, block);
  });
}

/// Removes a submap from the merged map and marks its blocks as stale: they have to be merged again.
void SubmapMerge::take_out(StoredSubmap* record, std::vector<Index3>* stale) {
  if (!record->is_merged) return;
  const SubmapKey key = key_of(record->entry);
  for (const Index3& block : record->blocks) {
    const auto it = by_block_.find(block);
    it->second.erase(std::remove(it->second.begin(), it->second.end(), key), it->second.end());
    if (it->second.empty()) by_block_.erase(it);
  }
  stale->insert(stale->end(), record->blocks.begin(), record->blocks.end());
  record->is_merged = false;
  if (record->merged == Knowledge::kAll) --num_with_memory_;
}

/// Enters a submap in the lists of the blocks that it touches. Its evidence is integrated later.
void SubmapMerge::put_in(const SubmapStore& store, const SubmapKey& key, StoredSubmap* record) {
  record->merged_at = {record->entry.T_W_S, record->entry.bend};
  record->is_merged = true;
  record->merged = knowledge_of(store, *record);
  record->blocks = footprint(*record->entry.submap, record->merged_at, resolution_m_, record->merged);
  record->observed_blocks.clear();
  if (record->merged == Knowledge::kAll) {
    record->observed_blocks = footprint(*record->entry.submap, record->merged_at, resolution_m_, Knowledge::kObserved);
    ++num_with_memory_;
  }
  for (const Index3& block : record->blocks) {
    std::vector<SubmapKey>& keys = by_block_[block];
    keys.insert(std::lower_bound(keys.begin(), keys.end(), key), key);
  }
}

/// Enters all submaps that are not in the merged map yet.
/// @param stale  receives the blocks that have to be merged again
/// @return the other blocks of each such submap; it is the newest one there, so its evidence is only added
SubmapMerge::Work SubmapMerge::put_in_new(SubmapStore* store, std::vector<Index3>* stale) {
  Work fresh;
  for (auto& [key, record] : store->records()) {
    if (record.is_merged) continue;
    put_in(*store, key, &record);
    for (const Index3& block : record.blocks) {
      const std::vector<SubmapKey>& keys = by_block_[block];
      // Remembered content of an older submap has to be removed from a block that the new submap observed.
      const bool is_added = keys.back() == key && (keys.size() == 1 || !memory_counts(*store, block, &key));
      (is_added ? fresh[key] : *stale).push_back(block);
    }
  }
  return fresh;
}

/// Empties the blocks that have to be merged again, and lists them for every submap that touches them.
void SubmapMerge::add_stale(const std::vector<Index3>& stale, Work* work) {
  for (const Index3& block : stale) {
    const auto found = by_block_.find(block);
    if (found == by_block_.end()) {
      evidence_.clear_block(block);
      continue;
    }
    evidence_.reset_block(block);
    for (const SubmapKey& key : found->second) (*work)[key].push_back(block);
  }
}

void SubmapMerge::integrate(SubmapStore* store, Work&& work) {
  for (auto& [key, blocks] : work) {
    StoredSubmap& record = store->at(key);
    store->touch(&record);
    if (record.merged == Knowledge::kAll) {
      const auto is_alone = [&, k = key](const Index3& block) {
        return by_block_.at(block).front() == k && memory_counts(*store, block);
      };
      std::vector<Index3> alone;
      std::copy_if(blocks.begin(), blocks.end(), std::back_inserter(alone), is_alone);
      integrate(record, Knowledge::kAll, alone);
      blocks.erase(std::remove_if(blocks.begin(), blocks.end(), is_alone), blocks.end());
    }
    integrate(record, Knowledge::kObserved, blocks);
    store->page_out();
  }
}

void SubmapMerge::integrate(const StoredSubmap& record, Knowledge knowledge, const std::vector<Index3>& blocks) {
  if (blocks.empty()) return;
  const PlacedSubmap placed(*record.entry.submap, record.entry.id, record.merged_at, resolution_m_, knowledge,
                            viewpoints(record.entry.T_S_B, record.merged_at.T_W_S));
  for (const Index3& block : blocks) evidence_.integrate(block, placed);
}

std::vector<Index3> SubmapMerge::update(SubmapStore* store) {
  std::vector<Index3> stale = std::exchange(stale_, {});
  for (auto& item : store->records()) {
    if (item.second.is_merged && has_changed(*store, item.second)) take_out(&item.second, &stale);
  }
  const Work fresh = put_in_new(store, &stale);
  sort_unique(&stale);
  Work work;
  add_stale(stale, &work);
  std::vector<Index3> changed = stale;
  for (const auto& [key, blocks] : fresh) {
    for (const Index3& block : blocks) {
      if (std::binary_search(stale.begin(), stale.end(), block)) continue;
      work[key].push_back(block);
      changed.push_back(block);
    }
  }
  integrate(store, std::move(work));
  sort_unique(&changed);
  return changed;
}

std::size_t SubmapMerge::memory_bytes() const {
  std::size_t bytes = evidence_.memory_bytes();
  for (const auto& item : by_block_) bytes += sizeof(item) + item.second.capacity() * sizeof(SubmapKey);
  return bytes;
}

}  // namespace voxnav::submap
