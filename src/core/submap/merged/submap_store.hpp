// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <tuple>
#include <vector>

#include "submap/merged/footprint.hpp"
#include "voxnav/submap/submap_collection.hpp"

namespace voxnav::submap {

/// Sort key of submaps by age: the flight, then the end stamp, then the id.
using SubmapKey = std::tuple<std::uint32_t, base::StampNs, std::uint32_t>;
inline SubmapKey key_of(const SubmapEntry& entry) { return {entry.flight, entry.end_ns, entry.id}; }

/// A submap of a collection, and how it was merged.
struct StoredSubmap {
  SubmapEntry entry;
  bool has_memory = false;      ///< whether it holds remembered content, which it did not observe
  std::size_t bytes = 0;        ///< memory of the submap when it was added
  std::uint64_t last_used = 0;  ///< number of the merge that needed it last
  // How it was merged, if it is in the merged map.
  bool is_merged = false;
  Placement merged_at;
  Knowledge merged = Knowledge::kObserved;        ///< which of its content was merged
  std::vector<geometry::Index3> blocks;           ///< blocks of W that it touches
  std::vector<geometry::Index3> observed_blocks;  ///< those that it observed; filled only if `merged` is kAll
};

/// The submaps of a collection, oldest first, within the limits of its configuration. Not thread-safe.
class SubmapStore {
 public:
  explicit SubmapStore(const SubmapCollectionConfig& config) : config_(config) {}

  void add(SubmapEntry entry);
  /// Returns null if there is no such submap.
  StoredSubmap* find(std::uint32_t id);
  const StoredSubmap* find(std::uint32_t id) const;
  StoredSubmap& at(const SubmapKey& key) { return records_.at(key); }
  const StoredSubmap& at(const SubmapKey& key) const { return records_.at(key); }
  /// @param id  id of a submap of the store
  void remove(std::uint32_t id);
  std::map<SubmapKey, StoredSubmap>& records() { return records_; }
  const std::map<SubmapKey, StoredSubmap>& records() const { return records_; }
  std::size_t size() const { return records_.size(); }
  std::optional<std::uint32_t> highest_id() const;
  /// Returns true if the oldest submap has to be removed: the number of submaps or their memory exceeds its limit.
  bool is_over_limit() const;

  /// Marks a submap as the one that was used last.
  void touch(StoredSubmap* record) { record->last_used = ++num_uses_; }
  /// Moves the least recently used submaps to disk until the others fit the limit.
  void page_out();
  std::size_t num_resident() const;
  std::size_t memory_bytes() const;

 private:
  SubmapCollectionConfig config_;
  std::map<SubmapKey, StoredSubmap> records_;
  std::map<std::uint32_t, SubmapKey> keys_;  ///< keys by id
  std::size_t bytes_ = 0;                    ///< memory of all submaps
  std::uint64_t num_uses_ = 0;
};

}  // namespace voxnav::submap
