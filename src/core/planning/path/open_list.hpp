// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace voxnav::planning {

/// The open list of a best-first search: the smallest sum f of cost and heuristic comes first, among equals the larger
/// cost, since it is nearer to the goal, and then the lower place, so that the order depends on nothing else. Entries
/// whose cost was lowered later stay in it; whoever takes one checks whether it still holds.
template <class Cost, class Place>
class OpenList {
 public:
  struct Entry {
    Cost f;
    Cost cost;
    Place place;
  };

  bool empty() const { return entries_.empty(); }
  void push(Cost f, Cost cost, const Place& place) {
    entries_.push_back({f, cost, place});
    std::push_heap(entries_.begin(), entries_.end(), comes_later);
  }
  /// Precondition: it is not empty.
  Entry pop() {
    std::pop_heap(entries_.begin(), entries_.end(), comes_later);
    const Entry out = entries_.back();
    entries_.pop_back();
    return out;
  }
  std::size_t memory_bytes() const { return entries_.capacity() * sizeof(Entry); }

 private:
  static bool comes_later(const Entry& a, const Entry& b) {
    if (a.f != b.f) return a.f > b.f;
    return a.cost != b.cost ? a.cost < b.cost : b.place < a.place;
  }

  std::vector<Entry> entries_;
};

}  // namespace voxnav::planning
