// SPDX-License-Identifier: BSD-3-Clause
#include "planning/cell_costs.hpp"

#include <algorithm>
#include <cmath>

namespace voxnav::planning {
namespace {

constexpr int kSide = geometry::kBlockSide;
constexpr float kFar = 1e9F;
constexpr int kMaxRadius = 64;
constexpr std::uint64_t kLowBits = 0x5555555555555555ull;

/// Returns the voxels of one state in a word of 32 states of two bits each; the lower bit of a voxel is set if it has
/// that state.
std::uint64_t occupied_bits(std::uint64_t word) { return (word >> 1) & kLowBits; }
std::uint64_t unknown_bits(std::uint64_t word) { return ~(word | (word >> 1)) & kLowBits; }

int floor_div(int a, int b) { return a >= 0 ? a / b : -((-a + b - 1) / b); }

/// Lower envelope along one axis: out[x] = min over k of in[x + k * stride] + weights[k], for 16 values of x.
void min_plus(const float* in, int stride, const std::vector<float>& weights, float* out) {
  std::fill(out, out + kSide, kFar);
  for (std::size_t k = 0; k < weights.size(); ++k) {
    const float* row = in + static_cast<std::ptrdiff_t>(k) * stride;
    const float weight = weights[k];
    for (int x = 0; x < kSide; ++x) out[x] = std::min(out[x], row[x] + weight);
  }
}

}  // namespace

CellCosts::CellCosts(const OccupancyView& view, const AStarConfig& config, const geometry::Vec3& start)
    : view_(view), config_(config), start_(start), fences_(view.fences()), resolution_m_(view.resolution_m()) {
  const geometry::Aabb box = view.bounds();
  // A voxel is inside the box if its centre is.
  const geometry::Vec3 half = geometry::Vec3::Constant(0.5 * resolution_m_ - 1e-9 * resolution_m_);
  if (box.empty()) {
    lowest_ = {0, 0, 0};
    highest_ = {-1, -1, -1};
  } else {
    const geometry::Vec3 limit = geometry::Vec3::Constant(1e9 * resolution_m_);
    lowest_ = geometry::index_of((box.min + half).cwiseMax(-limit), resolution_m_);
    highest_ = geometry::index_of((box.max - half).cwiseMin(limit), resolution_m_);
  }
  safety_ = std::max(0.0, config.safety_distance_m - view.grown_by_m()) / resolution_m_;
  clearance_ = std::max(safety_, config.clearance_distance_m / resolution_m_);
  // Rounding must not turn a voxel at exactly the safety distance into an obstacle.
  safety_sq_ = static_cast<float>(safety_ * safety_ - 1e-4);
  const double known =
      config.unknown_policy == UnknownPolicy::kOptimisticFar ? config.known_distance_m / resolution_m_ : 0.0;
  known_sq_ = static_cast<float>(known * known);
  radius_ = std::min(kMaxRadius, static_cast<int>(std::ceil(std::max(clearance_, known) + 0.5)));
  for (int k = -radius_; k <= radius_; ++k) {
    const float face = std::max(0.0F, static_cast<float>(std::abs(k)) - 0.5F);
    weights_.push_back(face * face);
  }
}

bool CellCosts::is_fenced(const geometry::Vec3& point) const {
  return fences_ != nullptr && fences_->contact(point, 0.0);
}

bool CellCosts::is_inside(const geometry::Index3& v) const {
  return v.x >= lowest_.x && v.y >= lowest_.y && v.z >= lowest_.z && v.x <= highest_.x && v.y <= highest_.y &&
         v.z <= highest_.z;
}

const StateBlock* CellCosts::states_of(const geometry::Index3& block) {
  const auto found = states_.find(block);
  if (found != states_.end()) return &found->second;
  StateBlock scratch;
  const StateBlock* states = view_.block(block, &scratch);
  return &states_.emplace(block, states != nullptr ? *states : StateBlock{}).first->second;
}

VoxelState CellCosts::state(const geometry::Index3& voxel) {
  return states_of(geometry::block_of(voxel))->get(geometry::offset_in_block(voxel));
}

/// Squared distance transform as a lower envelope, one axis after another: exact within the radius.
/// Source: Felzenszwalb & Huttenlocher, Theory of Computing 2012, section 2; here by brute force on each axis, which is
/// faster for radii of a few voxels.
template <class Select>
bool CellCosts::distances(const geometry::Index3& block, Select select, Distances* out) {
  const int side = kSide + 2 * radius_;
  const geometry::Index3 corner{block.x * kSide - radius_, block.y * kSide - radius_, block.z * kSide - radius_};
  const auto inside = [side](int v) { return v >= 0 && v < side; };
  bool is_any = false;
  const int reach = floor_div(kSide - 1 + radius_, kSide);
  for (int bz = -reach; bz <= reach; ++bz) {
    for (int by = -reach; by <= reach; ++by) {
      for (int bx = -reach; bx <= reach; ++bx) {
        const geometry::Index3 other = block + geometry::Index3{bx, by, bz};
        const StateBlock* states = states_of(other);
        for (int word = 0; word < static_cast<int>(states->words.size()); ++word) {
          for (std::uint64_t bits = select(states->words[word]); bits != 0; bits &= bits - 1) {
            const int offset = word * 32 + __builtin_ctzll(bits) / 2;
            const geometry::Index3 v = geometry::voxel_at(other, offset) - corner;
            if (!inside(v.x) || !inside(v.y) || !inside(v.z)) continue;
            if (!is_any) pass_a_.assign(static_cast<std::size_t>(side) * side * side, kFar);
            is_any = true;
            pass_a_[(static_cast<std::size_t>(v.z) * side + v.y) * side + v.x] = 0.0F;
          }
        }
      }
    }
  }
  if (!is_any) return false;
  const auto length = static_cast<std::size_t>(side);
  pass_b_.resize(length * length * kSide);
  for (std::size_t row = 0; row < length * length; ++row) {
    min_plus(&pass_a_[row * length], 1, weights_, &pass_b_[row * kSide]);
  }
  for (std::size_t z = 0; z < length; ++z) {
    for (std::size_t y = 0; y < kSide; ++y) {
      min_plus(&pass_b_[(z * length + y) * kSide], kSide, weights_, &pass_a_[(z * kSide + y) * kSide]);
    }
  }
  for (std::size_t row = 0; row < std::size_t{kSide} * kSide; ++row) {
    min_plus(&pass_a_[row * kSide], kSide * kSide, weights_, &(*out)[row * kSide]);
  }
  return true;
}

bool CellCosts::is_near_start(const geometry::Index3& voxel) const {
  return (geometry::center_of(voxel, resolution_m_) - start_).squaredNorm() < std::pow(config_.optimistic_range_m, 2);
}

bool CellCosts::touches_start_range(const geometry::Index3& block) const {
  const double side = kSide * resolution_m_;
  const geometry::Vec3 low = geometry::Vec3(block.x, block.y, block.z) * side;
  const geometry::Vec3 nearest = start_.cwiseMax(low).cwiseMin(low + geometry::Vec3::Constant(side));
  return (nearest - start_).squaredNorm() < std::pow(config_.optimistic_range_m, 2);
}

CellCost CellCosts::unknown_cost(const geometry::Index3& voxel) const {
  if (config_.unknown_policy == UnknownPolicy::kForbid) return 0;
  if (config_.unknown_policy == UnknownPolicy::kOptimisticFar && is_near_start(voxel)) return 0;
  return static_cast<CellCost>(std::lround(config_.unknown_cost * kUnitCost));
}

CellCost CellCosts::cost_of(const geometry::Index3& voxel, VoxelState state, bool is_near_occupied,
                            float distance_sq) const {
  if (state == VoxelState::kOccupied) return 0;
  if (is_near_occupied && safety_ > 0.0 && distance_sq < safety_sq_) return 0;
  const CellCost base = state == VoxelState::kUnknown ? unknown_cost(voxel) : kUnitCost;
  if (base == 0 || !is_near_occupied || clearance_ <= safety_) return base;
  const double lack = (clearance_ - std::sqrt(static_cast<double>(distance_sq))) / (clearance_ - safety_);
  if (lack <= 0.0) return base;
  const double extra = config_.clearance_weight * lack * lack * kUnitCost;
  return static_cast<CellCost>(std::min(65535.0, base + extra));
}

void CellCosts::compute(const geometry::Index3& block, CostBlock* out) {
  static constexpr auto kNoDistances = kFar;
  Distances to_occupied, to_unknown;
  const bool is_near_occupied = clearance_ > 0.0 && distances(block, occupied_bits, &to_occupied);
  BlockMask hard, soft;
  const bool has_forbidden = view_.forbidden(block, &hard, &soft);
  const bool is_short_of_known = known_sq_ > 0.0F && touches_start_range(block);
  const bool is_asked = is_short_of_known || (has_forbidden && soft.any());
  const bool is_near_unknown = is_asked && distances(block, unknown_bits, &to_unknown);
  const double near_unknown = config_.near_unknown_weight * kUnitCost;
  const StateBlock* states = states_of(block);
  for (int offset = 0; offset < geometry::kBlockVolume; ++offset) {
    const geometry::Index3 voxel = geometry::voxel_at(block, offset);
    CellCost& cost = (*out)[offset];
    cost = 0;
    if (!is_inside(voxel) || (has_forbidden && hard[offset])) continue;
    // A soft voxel, which another map forbids, may be entered only where this map knows all voxels around it.
    const bool knows_better = !is_near_unknown || (to_unknown[offset] > 0.0F && to_unknown[offset] >= safety_sq_);
    if (has_forbidden && soft[offset] && !knows_better) continue;
    cost = cost_of(voxel, states->get(offset), is_near_occupied, is_near_occupied ? to_occupied[offset] : kNoDistances);
    const bool is_dear = cost != 0 && is_short_of_known && is_near_unknown && to_unknown[offset] < known_sq_;
    if (is_dear && is_near_start(voxel)) cost = static_cast<CellCost>(std::min(65535.0, cost + near_unknown));
  }
}

}  // namespace voxnav::planning
