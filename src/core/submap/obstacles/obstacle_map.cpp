// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/submap/obstacle_map.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>

#include "submap/merged/block_marks.hpp"
#include "submap/obstacles/obstacle_inflation.hpp"

namespace voxnav::submap {
namespace {

using geometry::Index3;
using geometry::kBlockSide;

double checked_resolution(double resolution_m, double safety_distance_m) {
  if (!(resolution_m > 0.0)) throw std::invalid_argument("resolution_m must be positive");
  if (!(safety_distance_m >= 0.0 && safety_distance_m <= 10.0)) {
    throw std::invalid_argument("safety_distance_m must be from 0 to 10");
  }
  return resolution_m;
}

/// Computes a checksum of the positions of the surface points of a block; their submaps do not matter for obstacles.
std::uint64_t sum_of(const EvidenceBlock& block) {
  std::uint64_t sum = 0x9E3779B97F4A7C15ull;
  for (const SurfaceEvidence& point : block.points) {
    const std::uint64_t bits = point.offset |
                               static_cast<std::uint64_t>(static_cast<std::uint8_t>(point.point.mean[0])) << 16 |
                               static_cast<std::uint64_t>(static_cast<std::uint8_t>(point.point.mean[1])) << 24 |
                               static_cast<std::uint64_t>(static_cast<std::uint8_t>(point.point.mean[2])) << 32;
    sum = (sum ^ bits) * 0xBF58476D1CE4E5B9ull;
    sum ^= sum >> 29;
  }
  return sum;
}

/// Sort order of blocks by rows of y, so that windows can be dropped as soon as no later block needs them.
bool comes_later(const Index3& a, const Index3& b) {
  if (a.y != b.y) return a.y > b.y;
  return b < a;
}

/// The evidence of a block and of its neighbours, from which balls reach into the block. It moves from block to block;
/// a move along x keeps the neighbours that both blocks share.
class Surroundings {
 public:
  /// @param reach  radius of the balls, voxel edges
  Surroundings(const EvidenceMap& evidence, int reach_blocks, double reach)
      : evidence_(evidence), reach_blocks_(reach_blocks), side_(2 * reach_blocks + 1), reach_(reach) {
    const auto side = static_cast<std::size_t>(side_);
    sources_.resize(side * side * side);
  }

  void move_to(const Index3& index) {
    const std::size_t layer = sources_.size() / static_cast<std::size_t>(side_);
    const bool is_beside = is_anywhere_ && index == index_ + Index3{1, 0, 0};
    if (!is_anywhere_ || index.y != index_.y) drop_windows(index.y);
    index_ = index;
    is_anywhere_ = true;
    if (is_beside) std::move(sources_.begin() + static_cast<std::ptrdiff_t>(layer), sources_.end(), sources_.begin());
    for (int x = is_beside ? reach_blocks_ : -reach_blocks_; x <= reach_blocks_; ++x) {
      Source* to = &sources_[static_cast<std::size_t>(x + reach_blocks_) * layer];
      for (int z = -reach_blocks_; z <= reach_blocks_; ++z) {
        for (int y = -reach_blocks_; y <= reach_blocks_; ++y)
          *to++ = {evidence_.find(index + Index3{x, y, z}), nullptr};
      }
    }
  }
  const EvidenceBlock* center() const { return sources_[sources_.size() / 2].block; }
  void add_balls(Columns* mask) {
    Source* source = sources_.data();
    for (int x = -reach_blocks_; x <= reach_blocks_; ++x) {
      for (int z = -reach_blocks_; z <= reach_blocks_; ++z) {
        for (int y = -reach_blocks_; y <= reach_blocks_; ++y, ++source) {
          if (source->block && !source->block->points.empty()) add_balls({x, y, z}, source, mask);
        }
      }
    }
  }

 private:
  struct Source {
    const EvidenceBlock* block;
    const BallWindow* window;
  };
  void add_balls(const Index3& step, Source* source, Columns* mask) {
    const Index3 back{-step.x, -step.y, -step.z};
    if (reach_ > BallWindow::kMaxReach) return submap::add_balls(*source->block, back, reach_, mask);
    if (!source->window) {
      std::unique_ptr<BallWindow>& window = windows_[index_ + step];
      if (!window) {
        window = std::make_unique<BallWindow>();
        window->add_balls(*source->block, reach_);
      }
      source->window = window.get();
    }
    source->window->copy_to(back, mask);
  }
  /// Frees the windows that no block of the rows from `row` on needs.
  void drop_windows(std::int32_t row) {
    for (auto it = windows_.begin(); it != windows_.end();) it = it->first.y < row - 1 ? windows_.erase(it) : ++it;
  }

  const EvidenceMap& evidence_;
  int reach_blocks_;
  int side_;
  double reach_;
  bool is_anywhere_ = false;
  Index3 index_;
  std::vector<Source> sources_;  ///< neighbours, x slowest
  std::unordered_map<Index3, std::unique_ptr<BallWindow>, geometry::Index3Hash> windows_;
};

}  // namespace

ObstacleMap::ObstacleMap(double resolution_m, double safety_distance_m)
    : safety_distance_m_(safety_distance_m),
      reach_m_(safety_distance_m + 0.5 * std::sqrt(3.0) * checked_resolution(resolution_m, safety_distance_m)),
      reach_blocks_(static_cast<int>(std::ceil(reach_m_ / (resolution_m * kBlockSide)))),
      grid_(resolution_m) {}

void ObstacleMap::mark_changed(const std::vector<Index3>& blocks) {
  marked_.insert(marked_.end(), blocks.begin(), blocks.end());
}

bool ObstacleMap::surface_changed(const Index3& block, const EvidenceBlock* evidence) {
  const auto old = surfaces_.find(block);
  if (!evidence || evidence->points.empty()) {
    if (old == surfaces_.end()) return false;
    surfaces_.erase(old);
    return true;
  }
  const std::uint64_t sum = sum_of(*evidence);
  if (old != surfaces_.end() && old->second == sum) return false;
  surfaces_[block] = sum;
  return true;
}

void ObstacleMap::collect_due(const EvidenceMap& evidence) {
  if (marked_.empty()) return;
  std::vector<Index3> changed;
  for (const Index3& block : marked_) {
    if (surface_changed(block, evidence.find(block))) changed.push_back(block);
  }
  dilate(reach_blocks_, &changed);
  due_.insert(due_.end(), marked_.begin(), marked_.end());
  due_.insert(due_.end(), changed.begin(), changed.end());
  marked_.clear();
  sort_unique(&due_);
  std::sort(due_.begin(), due_.end(), comes_later);
}

std::size_t ObstacleMap::update(const EvidenceMap& evidence, std::size_t max_blocks) {
  collect_due(evidence);
  Surroundings around(evidence, reach_blocks_, reach_m_ / grid_.resolution_m());
  for (std::size_t done = 0; done < max_blocks && !due_.empty(); ++done) {
    const Index3 index = due_.back();
    due_.pop_back();
    around.move_to(index);
    ColumnBlock columns;
    if (around.center()) columns = around.center()->states;
    around.add_balls(&columns.occupied);
    const containers::StateBlock block = to_states(columns);
    const containers::StateBlock* old = grid_.find_block(index);
    const bool is_same = old ? old->words == block.words : block.all_unknown();
    if (is_same) continue;
    grid_.replace_block(index, block);
    changed_.push_back(index);
  }
  return due_.size();
}

containers::GridUpdate ObstacleMap::take_changes() {
  std::sort(changed_.begin(), changed_.end());
  changed_.erase(std::unique(changed_.begin(), changed_.end()), changed_.end());
  const std::vector<Index3> blocks = std::move(changed_);
  changed_.clear();
  return containers::changes_of(grid_, blocks);
}

std::size_t ObstacleMap::memory_bytes() const {
  constexpr std::size_t kNode = sizeof(std::pair<Index3, std::uint64_t>) + 2 * sizeof(void*);
  return grid_.memory_bytes() + surfaces_.size() * kNode +
         (marked_.capacity() + due_.capacity() + changed_.capacity()) * sizeof(Index3);
}

}  // namespace voxnav::submap
