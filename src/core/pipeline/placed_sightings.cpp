// SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/placed_sightings.hpp"

#include <algorithm>
#include <unordered_map>
#include <utility>

namespace voxnav::pipeline {
namespace {

using containers::MovingThing;
using geometry::Index3;
using geometry::Vec3;

constexpr int kSide = geometry::kBlockSide;
/// Connected voxels with at least this many returns are something; fewer may be a drop of rain or a fault of the
/// sensor. The filter of the cloud lets three neighbours through.
constexpr int kFirmReturns = 5;
/// Places of things are tried at times that are this far apart.
constexpr double kStep_s = 0.2;

/// Finds which of some voxels are connected with others to parts that have enough returns.
std::vector<bool> firm_ones(const SweepSightings& sweep) {
  std::unordered_map<Index3, std::size_t, geometry::Index3Hash> numbers;
  for (std::size_t i = 0; i < sweep.hits.size(); ++i) numbers.emplace(sweep.hits[i].voxel, i);
  std::vector<bool> is_firm(sweep.hits.size(), false), is_reached(sweep.hits.size(), false);
  for (std::size_t first = 0; first < sweep.hits.size(); ++first) {
    if (is_reached[first]) continue;
    std::vector<std::size_t> part{first};
    is_reached[first] = true;
    int returns = 0;
    for (std::size_t next = 0; next < part.size(); ++next) {
      returns += sweep.hits[part[next]].num_returns;
      for (int k = 0; k < 27; ++k) {
        const Index3 step{k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1};
        const auto found = numbers.find(sweep.hits[part[next]].voxel + step);
        if (found == numbers.end() || is_reached[found->second]) continue;
        is_reached[found->second] = true;
        part.push_back(found->second);
      }
    }
    for (const std::size_t i : part) is_firm[i] = returns >= kFirmReturns;
  }
  return is_firm;
}

}  // namespace

PlacedSightings::PlacedSightings(const NavigationMapConfig& config, const SweepSightings& sweep,
                                 planning::SharedOthers others)
    : resolution_m_(sweep.resolution_m),
      clearance_m_(config.moving_clearance_m),
      meeting_speed_mps_(config.meeting_speed_mps) {
  sightings_.stamp_ns = sweep.stamp_ns;
  sightings_.others = std::move(others);
  if (sightings_.others != nullptr) {
    for (const containers::OtherUav& other : *sightings_.others) {
      tracks_.emplace_back(other, sweep.stamp_ns, clearance_m_);
    }
  }
  sightings_.rules = {config.moving_horizon_s, config.moving_growth_mps};
  if (config.moving_horizon_s > 0.0) sightings_.things = sweep.things;
  if (!config.use_new_hits) return;
  const std::vector<bool> is_firm = firm_ones(sweep);
  for (std::size_t i = 0; i < sweep.hits.size(); ++i) {
    const Index3& voxel = sweep.hits[i].voxel;
    if (!is_firm[i]) {
      sightings_.lone_hits.push_back(voxel);
    } else {
      hits_[geometry::block_of(voxel)].push_back(static_cast<std::uint16_t>(geometry::offset_in_block(voxel)));
    }
  }
}

bool PlacedSightings::is_hit(const Index3& voxel) const {
  const auto found = hits_.find(geometry::block_of(voxel));
  if (found == hits_.end()) return false;
  const auto offset = static_cast<std::uint16_t>(geometry::offset_in_block(voxel));
  return std::find(found->second.begin(), found->second.end(), offset) != found->second.end();
}

bool PlacedSightings::add_hits(const Index3& block, containers::StateBlock* states) const {
  const auto found = hits_.find(block);
  if (found == hits_.end()) return false;
  for (const std::uint16_t offset : found->second) states->set(offset, containers::VoxelState::kOccupied);
  return true;
}

/// The way of a thing is straight, so the box around its first and its last place holds those between.
geometry::Aabb PlacedSightings::box_of(const MovingThing& thing) const {
  const planning::MovingRules& rules = sightings_.rules;
  const double grown_m =
      thing.position_sigma_m + rules.horizon_s * (thing.velocity_sigma_mps + rules.growth_mps) + clearance_m_;
  const double across_m = thing.half_size_m.head<2>().norm() + grown_m;
  const Vec3 half(across_m, across_m, thing.half_size_m.z() + grown_m);
  const Vec3 last = thing.position + rules.horizon_s * thing.velocity;
  return {thing.position.cwiseMin(last) - half, thing.position.cwiseMax(last) + half};
}

std::vector<geometry::Aabb> PlacedSightings::boxes() const {
  std::vector<geometry::Aabb> out;
  for (const MovingThing& thing : sightings_.things) out.push_back(box_of(thing));
  for (const planning::OtherUavTrack& track : tracks_) {
    if (!track.empty()) out.push_back(track.box());
  }
  return out;
}

bool PlacedSightings::is_forbidden(const MovingThing& thing, const Vec3& center) const {
  for (int step = 0; step * kStep_s <= sightings_.rules.horizon_s; ++step) {
    if (planning::may_touch(thing, sightings_.rules, step * kStep_s, center, clearance_m_)) return true;
  }
  return false;
}

bool PlacedSightings::forbid(const Index3& block, const Vec3& vehicle, planning::BlockMask* mask) const {
  const bool has_things = forbid_things(block, mask);
  return forbid_others(block, vehicle, mask) || has_things;
}

bool PlacedSightings::forbid_others(const Index3& block, const Vec3& vehicle, planning::BlockMask* mask) const {
  bool is_any = false;
  const double side = kSide * resolution_m_;
  const Vec3 corner = Vec3(block.x, block.y, block.z) * side;
  const planning::Arrival arrival{sightings_.stamp_ns, vehicle, meeting_speed_mps_};
  for (const planning::OtherUavTrack& track : tracks_) {
    const planning::OtherUavTrack here = track.within({corner, corner + Vec3::Constant(side)});
    if (here.empty()) continue;
    for (int offset = 0; offset < geometry::kBlockVolume; ++offset) {
      const Vec3 center = geometry::center_of(geometry::voxel_at(block, offset), resolution_m_);
      if (!here.may_meet(arrival, center)) continue;
      mask->set(static_cast<std::size_t>(offset));
      is_any = true;
    }
  }
  return is_any;
}

bool PlacedSightings::forbid_things(const Index3& block, planning::BlockMask* mask) const {
  bool is_any = false;
  const double side = kSide * resolution_m_;
  const Vec3 corner = Vec3(block.x, block.y, block.z) * side;
  for (const MovingThing& thing : sightings_.things) {
    const geometry::Aabb box = box_of(thing);
    if (!box.intersects({corner, corner + Vec3::Constant(side)})) continue;
    for (int offset = 0; offset < geometry::kBlockVolume; ++offset) {
      const Vec3 center = geometry::center_of(geometry::voxel_at(block, offset), resolution_m_);
      if (!box.contains(center) || !is_forbidden(thing, center)) continue;
      mask->set(static_cast<std::size_t>(offset));
      is_any = true;
    }
  }
  return is_any;
}

}  // namespace voxnav::pipeline
