// SPDX-License-Identifier: BSD-3-Clause
#include "submap/distance/distance_cache.hpp"

#include <deque>
#include <mutex>

#include "submap/distance/derive_distances.hpp"

namespace voxnav::submap {
namespace {

constexpr std::size_t kDefaultLimit = 24u << 20;

/// The cached blocks of all submaps, oldest first, evicted by the clock algorithm.
/// Source: Corbato, A Paging Experiment with the Multics System, MIT Project MAC report 1968 (clock algorithm).
class EvictionClock {
 public:
  static EvictionClock& instance() {
    static EvictionClock clock;
    return clock;
  }

  void add(const std::shared_ptr<DistanceCache::Slots>& slots, std::size_t position) {
    const std::lock_guard<std::mutex> lock(mutex_);
    entries_.push_back({slots, position});
    // A block that was used is spared once in each round; after that the oldest one is evicted.
    for (std::size_t spared = 0; entries_.size() > limit_ / sizeof(DistanceBlock) + 1;) {
      Entry entry = std::move(entries_.front());
      entries_.pop_front();
      const auto owner = entry.slots.lock();
      if (!owner) continue;
      std::shared_ptr<const DistanceBlock>* slot = &(*owner)[entry.position];
      const auto block = std::atomic_load(slot);
      if (block && spared < entries_.size() && block->was_used.exchange(false)) {
        ++spared;
        entries_.push_back(std::move(entry));
      } else {
        std::atomic_store(slot, std::shared_ptr<const DistanceBlock>());
      }
    }
  }
  void set_limit(std::size_t bytes) {
    const std::lock_guard<std::mutex> lock(mutex_);
    limit_ = bytes;
  }
  std::size_t limit() {
    const std::lock_guard<std::mutex> lock(mutex_);
    return limit_;
  }
  std::size_t used() {
    const std::lock_guard<std::mutex> lock(mutex_);
    std::size_t blocks = 0;
    for (const Entry& entry : entries_) blocks += !entry.slots.expired();
    return blocks * sizeof(DistanceBlock);
  }

 private:
  struct Entry {
    std::weak_ptr<DistanceCache::Slots> slots;
    std::size_t position;
  };
  std::mutex mutex_;
  std::deque<Entry> entries_;
  std::size_t limit_ = kDefaultLimit;
};

}  // namespace

DistanceCache::DistanceCache(std::size_t num_blocks) : slots_(std::make_shared<Slots>(num_blocks)) {}

std::shared_ptr<const DistanceBlock> DistanceCache::get(const SubmapContent& content, std::size_t position) const {
  static const auto nothing = std::make_shared<const DistanceBlock>(1.0);
  std::shared_ptr<const DistanceBlock> block = std::atomic_load(&(*slots_)[position]);
  if (block) {
    block->was_used.store(true, std::memory_order_relaxed);
    return block;
  }
  block = derive_distances(content, content.states().index(position));
  const bool is_counted = block != nullptr;
  if (!block) block = nothing;
  std::shared_ptr<const DistanceBlock> expected;
  // Another thread may have derived the same block meanwhile; its result is the same.
  if (std::atomic_compare_exchange_strong(&(*slots_)[position], &expected, block) && is_counted)
    EvictionClock::instance().add(slots_, position);
  return block;
}

void DistanceCache::set_limit_bytes(std::size_t bytes) { EvictionClock::instance().set_limit(bytes); }
std::size_t DistanceCache::limit_bytes() { return EvictionClock::instance().limit(); }
std::size_t DistanceCache::used_bytes() { return EvictionClock::instance().used(); }

}  // namespace voxnav::submap
