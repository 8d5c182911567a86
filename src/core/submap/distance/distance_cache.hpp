// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "submap/content/submap_content.hpp"
#include "submap/distance/distance_block.hpp"

namespace voxnav::submap {

/// Distance blocks of one submap that are at hand. All caches of a process share one limit; beyond it blocks that were
/// not used since the last round go first, whichever submap they belong to. Thread-safe; what is returned does not
/// depend on what is cached.
class DistanceCache {
 public:
  explicit DistanceCache(std::size_t num_blocks);

  /// Distances of the block at a position of the content, derived if they are not at hand. Never null.
  std::shared_ptr<const DistanceBlock> get(const SubmapContent& content, std::size_t position) const;

  static void set_limit_bytes(std::size_t bytes);
  static std::size_t limit_bytes();
  /// Of all caches of the process.
  static std::size_t used_bytes();

  using Slots = std::vector<std::shared_ptr<const DistanceBlock>>;

 private:
  std::shared_ptr<Slots> slots_;  ///< accessed atomically; null = not at hand
};

}  // namespace voxnav::submap
