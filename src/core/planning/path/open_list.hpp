// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <vector>

namespace voxnav::planning {

/// Slots of an open list for each voxel edge of cost at unit cost.
constexpr int kSlotsPerEdge = 32;

/// The open list of a best-first search: the smallest sum f of cost and heuristic comes first, among equals the larger
/// cost, since it is nearer to the goal, and then the lower place, so that the order depends on nothing else. Entries
/// whose cost was lowered later stay in it; whoever takes one checks whether it still holds.
/// Sums are sorted into slots of equal width, and only the entries of the lowest slot form a heap, which holds a few
/// entries where a heap of all would hold thousands. The order is that of one heap, whatever the width.
/// Source: Denardo & Fox, Operations Research 27 (1979), 161-186, section 3 (buckets); here with a heap for the lowest.
template <class Cost, class Place>
class OpenList {
 public:
  struct Entry {
    Cost f;
    Cost cost;
    Place place;
  };

  /// @param width  of a slot, above 0; best such that a slot holds a few entries
  explicit OpenList(Cost width) : width_(width), limit_(width * static_cast<Cost>(kSlots)) { slots_.fill(kNone); }

  bool empty() const { return size_ == 0; }
  void push(Cost f, Cost cost, const Place& place) {
    if (size_++ == 0) begin_at(f);
    insert({f, cost, place});
  }
  /// Precondition: it is not empty.
  Entry pop() {
    while (lowest_.empty()) advance();
    std::pop_heap(lowest_.begin(), lowest_.end(), ComesLater());
    const Entry out = lowest_.back();
    lowest_.pop_back();
    --size_;
    return out;
  }
  std::size_t memory_bytes() const {
    return (lowest_.capacity() + beyond_.capacity()) * sizeof(Entry) + linked_.capacity() * sizeof(Linked);
  }

 private:
  static constexpr int kSlots = 4096;
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  struct Linked {
    Entry entry;
    std::uint32_t next;
  };

  struct ComesLater {
    bool operator()(const Entry& a, const Entry& b) const {
      if (a.f != b.f) return a.f > b.f;
      return a.cost != b.cost ? a.cost < b.cost : b.place < a.place;
    }
  };

  void begin_at(Cost f) {
    base_ = f;
    current_ = 0;
  }
  /// Sums below the lowest slot, which searches with a weight may come to, join its heap.
  void insert(const Entry& entry) {
    if (!(entry.f > base_)) return insert_lowest(entry);
    const Cost offset = entry.f - base_;
    if (!(offset < limit_)) {
      beyond_.push_back(entry);
      return;
    }
    const int slot = std::min(kSlots - 1, static_cast<int>(offset / width_));
    if (slot <= current_) return insert_lowest(entry);
    std::uint32_t at = unused_;
    if (at == kNone) {
      at = static_cast<std::uint32_t>(linked_.size());
      linked_.emplace_back();
    } else {
      unused_ = linked_[at].next;
    }
    linked_[at] = {entry, slots_[slot]};
    slots_[slot] = at;
  }
  void insert_lowest(const Entry& entry) {
    lowest_.push_back(entry);
    std::push_heap(lowest_.begin(), lowest_.end(), ComesLater());
  }
  /// Goes on to the next slot that holds entries. Precondition: the lowest one is empty, the list is not.
  void advance() {
    while (++current_ < kSlots && slots_[current_] == kNone) {
    }
    if (current_ == kSlots) return restart();
    std::uint32_t last = kNone;
    for (std::uint32_t at = slots_[current_]; at != kNone; at = linked_[at].next) {
      lowest_.push_back(linked_[at].entry);
      last = at;
    }
    linked_[last].next = unused_;
    unused_ = slots_[current_];
    slots_[current_] = kNone;
    std::make_heap(lowest_.begin(), lowest_.end(), ComesLater());
  }
  /// Sorts what lay beyond all slots into new ones.
  void restart() {
    std::vector<Entry> entries;
    entries.swap(beyond_);
    begin_at(
        std::min_element(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) { return a.f < b.f; })->f);
    for (const Entry& entry : entries) insert(entry);
  }

  Cost width_;
  Cost limit_;  ///< sums this far above the base lie beyond all slots
  Cost base_{};
  int current_ = 0;  ///< the lowest slot
  std::size_t size_ = 0;
  std::vector<Entry> lowest_;                ///< a heap of the entries of the lowest slot, and below it
  std::array<std::uint32_t, kSlots> slots_;  ///< the last entry that was put into each
  std::vector<Linked> linked_;
  std::uint32_t unused_ = kNone;
  std::vector<Entry> beyond_;
};

}  // namespace voxnav::planning
