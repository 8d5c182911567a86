// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <unordered_map>
#include <vector>

#include "submap/merged/submap_store.hpp"
#include "voxnav/submap/evidence_map.hpp"

namespace voxnav::submap {

/// Keeps the evidence of W up to date with the submaps of a store: those that came, went or moved. Only blocks that one
/// of these touches are merged anew. Not thread-safe.
class SubmapMerge {
 public:
  explicit SubmapMerge(const SubmapCollectionConfig& config);

  const EvidenceMap& evidence() const { return evidence_; }
  /// A submap is about to be removed from the store.
  void remove(SubmapRecord* record) { take_out(record, &stale_); }
  /// @return blocks that changed, sorted
  std::vector<geometry::Index3> update(SubmapStore* store);
  std::size_t memory_bytes() const;

 private:
  /// Blocks to be integrated, by submap, oldest first: so each is laid into the grid once however many blocks it has to
  /// give.
  using Work = std::map<SubmapKey, std::vector<geometry::Index3>>;

  Knowledge knowledge_of(const SubmapStore& store, const SubmapRecord& record) const;
  bool has_changed(const SubmapStore& store, const SubmapRecord& record) const;
  bool has_observed(const SubmapStore& store, const SubmapKey& key, const geometry::Index3& block) const;
  bool memory_counts(const SubmapStore& store, const geometry::Index3& block, const SubmapKey* without = nullptr) const;
  void take_out(SubmapRecord* record, std::vector<geometry::Index3>* stale);
  void put_in(const SubmapStore& store, const SubmapKey& key, SubmapRecord* record);
  Work put_in_new(SubmapStore* store, std::vector<geometry::Index3>* stale);
  void add_stale(const std::vector<geometry::Index3>& stale, Work* work);
  void integrate(SubmapStore* store, Work work);
  void integrate(const SubmapRecord& record, Knowledge knowledge, const std::vector<geometry::Index3>& blocks);

  double resolution_m_;
  double pose_tolerance_m_;
  EvidenceMap evidence_;
  /// Submaps that are merged in each block, oldest first.
  std::unordered_map<geometry::Index3, std::vector<SubmapKey>, geometry::Index3Hash> by_block_;
  std::vector<geometry::Index3> stale_;  ///< blocks of submaps that were removed
  std::size_t num_with_memory_ = 0;      ///< submaps merged with what they remember
};

}  // namespace voxnav::submap
