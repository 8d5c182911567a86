// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace voxnav::containers {

/// Finds the number that a key has in a list of things, as the position of a block by its index. The keys themselves
/// stay in that list, so that a number takes four bytes here: whoever calls says by `key_of(number)` what the key of a
/// number is. Open addressing with linear probing, at most half full; numbers are forgotten only all at once.
/// @tparam Hash  function object from a key to std::size_t; its lower bits decide
template <class Key, class Hash>
class NumberTable {
 public:
  /// Forgets everything and makes room for `count` keys.
  void reset(std::size_t count) {
    std::size_t size = kLeastSlots;
    while (size < 2 * count) size *= 2;
    slots_.assign(size, kEmpty);
    size_ = 0;
  }
  /// Forgets everything and keeps the room.
  void clear() {
    std::fill(slots_.begin(), slots_.end(), kEmpty);
    size_ = 0;
  }

  template <class KeyOf>
  std::optional<std::uint32_t> find(const Key& key, KeyOf&& key_of) const {
    if (slots_.empty()) return std::nullopt;
    const std::uint32_t number = slots_[slot_of(key, key_of)];
    return number == kEmpty ? std::nullopt : std::optional<std::uint32_t>(number);
  }
  /// The number of a key; `number`, which key_of() may not know yet, from now on if it has none.
  template <class KeyOf>
  std::uint32_t insert(const Key& key, std::uint32_t number, KeyOf&& key_of) {
    if (2 * (size_ + 1) > slots_.size()) grow(key_of);
    std::uint32_t& slot = slots_[slot_of(key, key_of)];
    if (slot == kEmpty) {
      slot = number;
      ++size_;
    }
    return slot;
  }

  std::size_t size() const { return size_; }
  std::size_t memory_bytes() const { return slots_.capacity() * sizeof(std::uint32_t); }

 private:
  static constexpr std::uint32_t kEmpty = 0xFFFFFFFFu;
  static constexpr std::size_t kLeastSlots = 16;

  /// Returns the slot of a key, or the empty slot where it would go; there is always an empty one. The number of slots
  /// is a power of two, so that lower bits are a remainder.
  template <class KeyOf>
  std::size_t slot_of(const Key& key, KeyOf&& key_of) const {
    const std::size_t mask = slots_.size() - 1;
    std::size_t slot = Hash{}(key)&mask;
    while (slots_[slot] != kEmpty && !(key_of(slots_[slot]) == key)) slot = (slot + 1) & mask;
    return slot;
  }
  template <class KeyOf>
  void grow(KeyOf&& key_of) {
    std::vector<std::uint32_t> old(std::max(kLeastSlots, 2 * slots_.size()), kEmpty);
    old.swap(slots_);
    for (const std::uint32_t number : old) {
      if (number != kEmpty) slots_[slot_of(key_of(number), key_of)] = number;
    }
  }

  std::vector<std::uint32_t> slots_;
  std::size_t size_ = 0;
};

/// Numbers keys from 0 on, in the order in which they are met.
template <class Key, class Hash>
class KeyNumbers {
 public:
  /// Forgets everything and makes room for `count` keys.
  void reset(std::size_t count) {
    numbers_.reset(count);
    keys_.clear();
  }
  /// Forgets everything and keeps the room.
  void clear() {
    numbers_.clear();
    keys_.clear();
  }
  /// The number of a key, which is size() as it was before for one that is new.
  std::uint32_t number_of(const Key& key) {
    const auto next = static_cast<std::uint32_t>(keys_.size());
    const std::uint32_t number =
        numbers_.insert(key, next, [this](std::uint32_t other) -> const Key& { return keys_[other]; });
    if (number == next) keys_.push_back(key);
    return number;
  }
  std::size_t size() const { return keys_.size(); }

 private:
  NumberTable<Key, Hash> numbers_;
  std::vector<Key> keys_;  ///< by number
};

}  // namespace voxnav::containers
