// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>

#include "voxnav/geometry/voxel.hpp"

namespace voxnav::occupancy {

/// Records which blocks a local map removed and at which sequence number, so that readers of changes can be told. The
/// record is bounded: when it is full it is cleared, and a reader that has only an older sequence needs a snapshot.
class RemovedBlocks {
 public:
  void add(const geometry::Index3& block, std::uint64_t sequence) {
    if (at_.size() >= kMaxBlocks) {
      at_.clear();
      complete_since_ = sequence;
    }
    at_[block] = sequence;
  }
  /// The sequence number from which on the record is complete; earlier removals are forgotten.
  std::uint64_t complete_since() const { return complete_since_; }
  const std::map<geometry::Index3, std::uint64_t>& all() const { return at_; }
  std::size_t memory_bytes() const { return at_.size() * kBytesPerEntry; }

 private:
  static constexpr std::size_t kMaxBlocks = 10000;
  static constexpr std::size_t kBytesPerEntry = 56;

  std::map<geometry::Index3, std::uint64_t> at_;
  std::uint64_t complete_since_ = 0;
};

}  // namespace voxnav::occupancy
