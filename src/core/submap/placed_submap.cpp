// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/submap/placed_submap.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "voxnav/submap/block_marks.hpp"
#include "voxnav/submap/voxel_walk.hpp"

namespace voxnav::submap {
namespace {

using geometry::Index3;
using geometry::kBlockSide;
using geometry::Pose;
using geometry::Vec3;

std::int8_t mean_byte(double edges) {
  const double units = std::min(127.0, std::max(-127.0, edges * 254.0));
  return static_cast<std::int8_t>(units + std::copysign(0.5, units));  // std::lround() is a call
}

std::uint8_t range_byte(const std::optional<double>& range_m) {
  return range_m ? static_cast<std::uint8_t>(std::min(255.0, 2.0 * *range_m)) : std::uint8_t{255};
}

/// Of what was seen at each time of the submap, 0 to 255; the same for all unless it is bent.
std::vector<Pose> poses_over_time(const Placement& placement, const Pose& T_S_G) {
  std::vector<Pose> out(256, placement.T_W_S * T_S_G);
  if (placement.bend.is_rigid()) return out;
  for (std::size_t time = 0; time < out.size(); ++time)
    out[time] = placement.T_W_S * placement.bend.at(static_cast<double>(time) / 255.0) * T_S_G;
  return out;
}

bool turns_about_vertical(const Pose& T) {
  constexpr double kLevel = 1e-5;  // a tenth of a millimetre over ten metres
  const Eigen::Matrix3d R = T.linear();
  return std::max({std::abs(R(2, 0)), std::abs(R(2, 1)), std::abs(R(0, 2)), std::abs(R(1, 2))}) < kLevel;
}

}  // namespace

PlacedSubmap::PlacedSubmap(const Submap& submap, std::uint32_t id, const Placement& placement, double resolution_m,
                           Knowledge knowledge, std::vector<Vec3> viewpoints_W)
    : field_(submap.field()),
      submap_resolution_m_(submap.resolution_m()),
      id_(id),
      knowledge_(knowledge),
      resolution_m_(resolution_m),
      T_S_G_(submap.T_S_G()),
      placement_(placement),
      viewpoints_W_(std::move(viewpoints_W)),
      is_level_(turns_about_vertical(placement.T_W_S * T_S_G_) && turns_about_vertical(placement.bend.T_S_begin) &&
                turns_about_vertical(placement.bend.T_S_end) && submap.resolution_m() == resolution_m) {
  if (knowledge == Knowledge::kAll) placement_.bend = {};
  free_.resize(field_->num_blocks());
  sort_leaves(submap.thin_leaves());
}

void PlacedSubmap::sort_leaves(const std::vector<bool>& is_thin) {
  struct Placed {
    Group* group;
    EvidenceLeaf leaf;
  };
  std::vector<Placed> placed;
  placed.reserve(knowledge_ == Knowledge::kOwn ? field_->num_own_leaves() : field_->num_leaves());
  const std::vector<Pose> T_W_G = poses_over_time(placement_, T_S_G_);
  Index3 last{1 << 30, 0, 0};
  Group* group = nullptr;
  const auto place = [&](const Index3& voxel, const CompressedField::Leaf& leaf, std::size_t i, std::uint8_t time) {
    const Vec3 p = T_W_G[time] * (surface_point(voxel, leaf) * submap_resolution_m_) / resolution_m_;
    const Index3 at = floor_index(p);
    const Index3 block = geometry::block_of(at);
    if (block != last) group = &groups_[block];
    last = block;
    ++group->count;
    group->time_sum += time;
    const Vec3 mean = p - geometry::center_of(at, 1.0);
    const auto offset = static_cast<std::uint16_t>(geometry::offset_in_block(at));
    const std::array<std::int8_t, 3> bytes{mean_byte(mean.x()), mean_byte(mean.y()), mean_byte(mean.z())};
    const bool thin = is_thin[i];
    const std::uint8_t range = thin ? range_byte(range_to(p * resolution_m_)) : std::uint8_t{255};
    placed.push_back({group, {offset, bytes, leaf.hits, range, thin, id_, false, false}});
  };
  if (knowledge_ == Knowledge::kOwn) {
    field_->for_each_own_leaf(place);
  } else {
    std::size_t i = 0;
    field_->for_each_leaf([&](const Index3& voxel, const CompressedField::Leaf& leaf) {
      place(voxel, leaf, i++, CompressedField::kUnknownTime);
    });
  }
  std::uint32_t next = 0;
  for (auto& item : groups_) {
    item.second.first = next;
    next += item.second.count;
    item.second.count = 0;
  }
  leaves_.resize(placed.size());
  for (const Placed& item : placed) leaves_[item.group->first + item.group->count++] = item.leaf;
}

/// For what is not a surface point and so has no time of its own: as the surface points of the same block, or of those
/// below, lie on average.
Pose PlacedSubmap::T_G_W_at(const Index3& block) const {
  Pose T_W_S = placement_.T_W_S;
  if (!placement_.bend.is_rigid()) {
    for (const int step : {0, -1, -2, 1}) {
      const auto found = groups_.find(block + Index3{0, 0, step});
      if (found == groups_.end()) continue;
      T_W_S = T_W_S * placement_.bend.at(found->second.time_sum / (255.0 * found->second.count));
      break;
    }
  }
  return (T_W_S * T_S_G_).inverse(Eigen::Isometry);
}

PlacedSubmap::Range PlacedSubmap::leaves(const Index3& block) const {
  const auto found = groups_.find(block);
  if (found == groups_.end()) return {};
  const EvidenceLeaf* first = leaves_.data() + found->second.first;
  return {first, first + found->second.count};
}

/// Unpacked when first asked for: most of the air is known from other submaps already.
const Columns* PlacedSubmap::free_of(const Index3& block_G) const {
  const int position = field_->position_of(block_G);
  if (position < 0) return nullptr;
  const auto i = static_cast<std::size_t>(position);
  if (!free_[i]) {
    const bool is_own = knowledge_ == Knowledge::kOwn;
    free_[i] = std::make_unique<Columns>(is_own ? field_->own_free(i) : field_->columns(i).free);
  }
  return free_[i].get();
}

bool PlacedSubmap::is_free_voxel(const Index3& voxel_G) const {
  const Columns* free = free_of(geometry::block_of(voxel_G));
  const int offset = geometry::offset_in_block(voxel_G);
  return free && (((*free)[static_cast<std::size_t>(offset & 255)] >> (offset >> 8)) & 1) != 0;
}

void PlacedSubmap::add_free(const Index3& block, Columns* free) const {
  is_level_ ? add_free_level(block, free) : add_free_tilted(block, free);
}

/// Columns of W are columns of G, all shifted alike.
void PlacedSubmap::add_free_level(const Index3& block, Columns* free) const {
  const Pose T_G_W = T_G_W_at(block);
  const Vec3 first = T_G_W * geometry::center_of(geometry::voxel_at(block, 0), resolution_m_) / resolution_m_;
  const Vec3 step_x = T_G_W.linear().col(0);
  const Vec3 step_y = T_G_W.linear().col(1);
  const Index3 lowest = floor_index(first);
  const int shift = lowest.z & (kBlockSide - 1);
  Index3 at{1 << 30, 0, lowest.z >> geometry::kBlockShift};
  const Columns* low = nullptr;
  const Columns* high = nullptr;
  for (int y = 0; y < kBlockSide; ++y) {
    Vec3 p = first + y * step_y;
    for (int x = 0; x < kBlockSide; ++x, p += step_x) {
      const Index3 voxel = floor_index(p);
      const Index3 block_G{voxel.x >> geometry::kBlockShift, voxel.y >> geometry::kBlockShift, at.z};
      if (block_G != at) {
        at = block_G;
        low = free_of(at);
        high = shift > 0 ? free_of(at + Index3{0, 0, 1}) : nullptr;
      }
      const auto column = static_cast<std::size_t>((voxel.x & 15) | ((voxel.y & 15) << 4));
      const unsigned bits = (low ? (*low)[column] >> shift : 0u) |
                            (high ? static_cast<unsigned>((*high)[column]) << (kBlockSide - shift) : 0u);
      (*free)[static_cast<std::size_t>(x + kBlockSide * y)] |= static_cast<std::uint16_t>(bits);
    }
  }
}

void PlacedSubmap::add_free_tilted(const Index3& block, Columns* free) const {
  const double v_G = submap_resolution_m_;
  const Pose T_G_W = T_G_W_at(block);
  const Vec3 first = T_G_W * geometry::center_of(geometry::voxel_at(block, 0), resolution_m_) / v_G;
  const Eigen::Matrix3d step = T_G_W.linear() * (resolution_m_ / v_G);
  for (int column = 0; column < kBlockSide * kBlockSide; ++column) {
    Vec3 p = first + step * Vec3(column & 15, column >> 4, 0);
    for (int z = 0; z < kBlockSide; ++z, p += step.col(2)) {
      if (!is_free_voxel(floor_index(p))) continue;
      (*free)[static_cast<std::size_t>(column)] |= static_cast<std::uint16_t>(1u << z);
    }
  }
}

PlacedSubmap::FreeInBlock::FreeInBlock(const PlacedSubmap& submap, const Index3& block)
    : submap_(&submap),
      T_G_W_(submap.T_G_W_at(block)),
      R_G_W_(T_G_W_.linear() * (submap.resolution_m_ / submap.submap_resolution_m_)) {
  const Vec3 first(block.x, block.y, block.z);
  origin_G_ = R_G_W_ * (first * kBlockSide) + T_G_W_.translation() / submap.submap_resolution_m_;
  // The lowest corner of the block and of the voxels below it.
  const Eigen::Matrix3d lowest = (R_G_W_ * kBlockSide).cwiseMin(0.0);
  first_G_ = geometry::block_of(floor_index(origin_G_ + lowest.rowwise().sum() - R_G_W_.col(2).cwiseMax(0.0)));
}

bool PlacedSubmap::FreeInBlock::is_free_at(const Vec3& p) const {
  const Index3 voxel = floor_index(origin_G_ + R_G_W_ * p);
  const Index3 step = geometry::block_of(voxel) - first_G_;
  const auto at = static_cast<std::size_t>(step.x + kSide * (step.y + kSide * step.z));
  if (std::max({step.x, step.y, step.z}) >= kSide || std::min({step.x, step.y, step.z}) < 0)
    return submap_->is_free_voxel(voxel);  // voxels of W larger than those of the submap
  if (((looked_up_ >> at) & 1) == 0) free_[at] = submap_->free_of(first_G_ + step);
  looked_up_ |= std::uint64_t{1} << at;
  const int column = (voxel.x & 15) | (voxel.y & 15) << 4;
  return free_[at] && (((*free_[at])[static_cast<std::size_t>(column)] >> (voxel.z & 15)) & 1) != 0;
}

bool PlacedSubmap::FreeInBlock::has_surface_within(const Vec3& p_W, double distance_m) const {
  const double v_G = submap_->submap_resolution_m_;
  return submap_->field_->has_own_surface_within(T_G_W_ * p_W / v_G, distance_m / v_G);
}

std::optional<double> PlacedSubmap::range_to(const Vec3& p_W) const {
  if (viewpoints_W_.empty()) return std::nullopt;
  double squared = std::numeric_limits<double>::infinity();
  for (const Vec3& view : viewpoints_W_) squared = std::min(squared, (view - p_W).squaredNorm());
  return std::sqrt(squared);
}

namespace {

/// Boxes around the blocks of a submap: all blocks are turned alike, so that of the first one, moved.
class PlacedBox {
 public:
  PlacedBox(const Pose& T_W_G, double side_G)
      : T_W_G_(T_W_G), side_G_(side_G), unit_(geometry::Aabb{Vec3::Zero(), Vec3::Constant(side_G)}.transformed(T_W_G)) {
    unit_.min -= T_W_G.translation();
    unit_.max -= T_W_G.translation();
  }
  void extend(const Index3& block, geometry::Aabb* box) const {
    const Vec3 origin = T_W_G_ * (Vec3(block.x, block.y, block.z) * side_G_);
    box->extend(origin + unit_.min);
    box->extend(origin + unit_.max);
  }

 private:
  Pose T_W_G_;
  double side_G_;
  geometry::Aabb unit_;
};

}  // namespace

std::vector<Pose> extremes(const Placement& placement) {
  if (placement.bend.is_rigid()) return {placement.T_W_S};
  return {placement.T_W_S, placement.T_W_S * placement.bend.T_S_begin, placement.T_W_S * placement.bend.T_S_end};
}

std::vector<Index3> footprint(const Submap& submap, const Placement& placement, double resolution_m,
                              Knowledge knowledge) {
  const double side_G = kBlockSide * submap.resolution_m();
  const double side_W = kBlockSide * resolution_m;
  std::vector<Index3> out;
  const auto field = submap.field();
  std::vector<PlacedBox> boxes;
  for (const Pose& T_W_S : extremes(placement)) boxes.emplace_back(T_W_S * submap.T_S_G(), side_G);
  for (std::size_t i = 0; i < field->num_blocks(); ++i) {
    if (knowledge == Knowledge::kOwn && !field->has_own(i)) continue;
    const Index3& block = field->block_index(i);
    geometry::Aabb box;
    for (const PlacedBox& placed : boxes) placed.extend(block, &box);
    const Index3 low = floor_index(box.min / side_W);
    const Index3 high = floor_index(box.max / side_W);
    for (int z = low.z; z <= high.z; ++z) {
      for (int y = low.y; y <= high.y; ++y) {
        for (int x = low.x; x <= high.x; ++x) out.push_back({x, y, z});
      }
    }
  }
  sort_unique(&out);
  return out;
}

}  // namespace voxnav::submap
