// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>

#include "voxnav/geometry/voxel.hpp"

namespace voxnav::occupancy {

/// Which blocks a local map lost, and at which of its sequences: what readers of changes have to be told. When nobody
/// reads for long they are given up, and who is older than that needs a snapshot.
class RemovedBlocks {
 public:
  void add(const geometry::Index3& block, std::uint64_t sequence) {
    if (at_.size() >= kMaxBlocks) {
      at_.clear();
      complete_since_ = sequence;
    }
    at_[block] = sequence;
  }
  /// Removals before this sequence are not known any more.
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
