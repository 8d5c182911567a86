// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "submap/content/submap_content.hpp"
#include "submap/distance/distance_block.hpp"

namespace voxnav::submap {

/// The cached distance blocks of one submap. All caches of a process share one limit; beyond it, blocks that were not
/// used since the last round of the clock algorithm are evicted first, whichever submap they belong to. Thread-safe;
/// the distances that are returned do not depend on what is cached.
class DistanceCache {
 public:
  explicit DistanceCache(std::size_t num_blocks);

  /// Returns the distances of the block at a position of the content, derived if they are not cached. Never null.
  std::shared_ptr<const DistanceBlock> get(const SubmapContent& content, std::size_t position) const;

  static void set_limit_bytes(std::size_t bytes);
  static std::size_t limit_bytes();
  /// The limit and the use of all caches of the process together.
  static std::size_t used_bytes();

  using Slots = std::vector<std::shared_ptr<const DistanceBlock>>;

 private:
  std::shared_ptr<Slots> slots_;  ///< one for each block, accessed atomically; null = not cached
};

}  // namespace voxnav::submap
