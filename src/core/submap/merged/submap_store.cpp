// SPDX-License-Identifier: BSD-3-Clause
#include "submap/merged/submap_store.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstdio>

#include "submap/content/submap_content.hpp"

namespace voxnav::submap {
namespace {

/// The path of a page contains the address of the store, which tells two collections of one process apart.
std::string page_name(const SubmapEntry& entry) {
  char name[96];
  std::snprintf(name, sizeof(name), "/page_%ld_%p_%u.vxs", static_cast<long>(::getpid()),
                static_cast<const void*>(entry.submap.get()), entry.id);
  return name;
}

}  // namespace

void SubmapStore::add(SubmapEntry entry) {
  const SubmapKey key = key_of(entry);
  keys_[entry.id] = key;
  StoredSubmap& record = records_[key];
  record.bytes = entry.submap->memory_bytes();
  record.has_memory = entry.submap->content()->has_memory();
  bytes_ += record.bytes;
  record.entry = std::move(entry);
}

StoredSubmap* SubmapStore::find(std::uint32_t id) {
  const auto key = keys_.find(id);
  return key == keys_.end() ? nullptr : &records_.at(key->second);
}

const StoredSubmap* SubmapStore::find(std::uint32_t id) const {
  const auto key = keys_.find(id);
  return key == keys_.end() ? nullptr : &records_.at(key->second);
}

void SubmapStore::remove(std::uint32_t id) {
  const auto key = keys_.find(id);
  bytes_ -= records_.at(key->second).bytes;
  records_.erase(key->second);
  keys_.erase(key);
}

std::optional<std::uint32_t> SubmapStore::highest_id() const {
  if (keys_.empty()) return std::nullopt;
  return keys_.rbegin()->first;
}

bool SubmapStore::is_over_limit() const {
  return records_.size() > 1 && (records_.size() > static_cast<std::size_t>(config_.max_submaps) ||
                                 static_cast<double>(bytes_) > config_.max_memory_mb * 1e6);
}

void SubmapStore::page_out() {
  if (config_.page_dir.empty()) return;
  std::size_t resident = 0;
  std::vector<const StoredSubmap*> candidates;
  for (const auto& item : records_) {
    if (!item.second.entry.submap->is_resident()) continue;
    resident += item.second.bytes;
    candidates.push_back(&item.second);
  }
  const auto limit = static_cast<std::size_t>(config_.max_resident_mb * 1e6);
  if (resident <= limit) return;
  std::sort(candidates.begin(), candidates.end(),
            [](const StoredSubmap* a, const StoredSubmap* b) { return a->last_used < b->last_used; });
  for (const StoredSubmap* record : candidates) {
    if (resident <= limit) return;
    record->entry.submap->page_out(config_.page_dir + page_name(record->entry));
    resident -= record->bytes;
  }
}

std::size_t SubmapStore::num_resident() const {
  return static_cast<std::size_t>(std::count_if(
      records_.begin(), records_.end(), [](const auto& item) { return item.second.entry.submap->is_resident(); }));
}

std::size_t SubmapStore::memory_bytes() const {
  std::size_t bytes = 0;
  for (const auto& item : records_) {
    const StoredSubmap& record = item.second;
    bytes += sizeof(item) + record.entry.submap->memory_bytes() + record.blocks.capacity() * sizeof(geometry::Index3) +
             record.entry.T_S_B.capacity() * sizeof(geometry::StampedPose);
  }
  return bytes;
}

}  // namespace voxnav::submap
