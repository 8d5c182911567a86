// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <unordered_map>
#include <vector>

#include "submap/merged/submap_store.hpp"
#include "voxnav/submap/evidence_map.hpp"

namespace voxnav::submap {

/// Updates the evidence of W with the submaps of a store that were added, removed or moved. Only blocks that one of
/// these touches are merged again. Not thread-safe.
class SubmapMerge {
 public:
  explicit SubmapMerge(const SubmapCollectionConfig& config);

  const EvidenceMap& evidence() const { return evidence_; }
  /// Removes a submap from the merged map; to be called before it is removed from the store.
  void remove(StoredSubmap* record) { take_out(record, &stale_); }
  /// Brings the evidence up to date. @return blocks that changed, sorted
  std::vector<geometry::Index3> update(SubmapStore* store);
  std::size_t memory_bytes() const;

 private:
  /// The blocks to be integrated, by submap, oldest first, so that each submap is placed in the grid only once.
  using Work = std::map<SubmapKey, std::vector<geometry::Index3>>;

  Knowledge knowledge_of(const SubmapStore& store, const StoredSubmap& record) const;
  bool has_changed(const SubmapStore& store, const StoredSubmap& record) const;
  bool has_observed(const SubmapStore& store, const SubmapKey& key, const geometry::Index3& block) const;
  bool memory_counts(const SubmapStore& store, const geometry::Index3& block, const SubmapKey* without = nullptr) const;
  void take_out(StoredSubmap* record, std::vector<geometry::Index3>* stale);
  void put_in(const SubmapStore& store, const SubmapKey& key, StoredSubmap* record);
  Work put_in_new(SubmapStore* store, std::vector<geometry::Index3>* stale);
  void add_stale(const std::vector<geometry::Index3>& stale, Work* work);
  void integrate(SubmapStore* store, Work&& work);
  void integrate(const StoredSubmap& record, Knowledge knowledge, const std::vector<geometry::Index3>& blocks);

  double resolution_m_;
  double pose_tolerance_m_;
  EvidenceMap evidence_;
  /// The submaps that are merged in each block, oldest first.
  std::unordered_map<geometry::Index3, std::vector<SubmapKey>, geometry::Index3Hash> by_block_;
  std::vector<geometry::Index3> stale_;  ///< blocks of submaps that were removed
  std::size_t num_with_memory_ = 0;      ///< number of submaps that are merged with their remembered content
};

}  // namespace voxnav::submap
