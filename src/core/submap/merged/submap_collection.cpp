// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/submap/submap_collection.hpp"

#include <stdexcept>
#include <utility>

#include "submap/merged/collection_parts.hpp"

namespace voxnav::submap {
namespace {

using geometry::Index3;
using geometry::Pose;

void check_bend(const geometry::Bend& bend) {
  constexpr double kMost_m = 100.0;
  for (const Pose& T : {bend.T_S_begin, bend.T_S_end}) {
    if (!geometry::is_valid(T) || T.translation().norm() > kMost_m)
      throw std::invalid_argument("a bend must be made of finite rigid transforms of less than 100 m");
  }
}

void check_pose(const Pose& T_W_S) {
  constexpr double kFarthest_m = 1e6;  // voxel indices stay within 32 bits
  if (!geometry::is_valid(T_W_S)) throw std::invalid_argument("T_W_S must be a finite rigid transform");
  if (T_W_S.translation().cwiseAbs().maxCoeff() > kFarthest_m)
    throw std::invalid_argument("T_W_S is farther than 1000 km");
}

/// Checks that the submap lies within the index range of the grid of W, and that its voxels are not much smaller or
/// larger than those of W, which bounds the cost of merging it.
void check_extent(const Submap& submap, const Pose& T_W_S, double resolution_m) {
  constexpr double kLastVoxel = 1 << 28;
  constexpr double kMostRatio = 4.0;
  const double ratio = submap.resolution_m() / resolution_m;
  if (!(ratio <= kMostRatio && ratio >= 1.0 / kMostRatio))
    throw std::invalid_argument("a submap has voxels more than 4 times larger or smaller than the map's");
  const geometry::Aabb box = submap.known_bounds().transformed(T_W_S);
  if (box.empty()) return;
  const double farthest_m = std::max(box.min.cwiseAbs().maxCoeff(), box.max.cwiseAbs().maxCoeff());
  if (!(farthest_m / resolution_m < kLastVoxel))
    throw std::invalid_argument("a submap reaches farther than the map can");
}

}  // namespace

SubmapCollection::SubmapCollection(const SubmapCollectionConfig& config) : parts_(std::make_unique<Parts>(config)) {}
SubmapCollection::~SubmapCollection() = default;
SubmapCollection::SubmapCollection(SubmapCollection&&) noexcept = default;
SubmapCollection& SubmapCollection::operator=(SubmapCollection&&) noexcept = default;

const SubmapCollectionConfig& SubmapCollection::config() const { return parts_->config; }

void SubmapCollection::add(SubmapEntry entry) {
  if (!entry.submap) throw std::invalid_argument("a submap entry needs a submap");
  check_pose(entry.T_W_S);
  check_bend(entry.bend);
  check_extent(*entry.submap, entry.T_W_S, config().resolution_m);
  remove(entry.id);
  parts_->store.add(std::move(entry));
  while (parts_->store.is_over_limit()) {
    remove(parts_->store.records().begin()->second.entry.id);
    ++parts_->num_dropped;
  }
}

bool SubmapCollection::set_pose(std::uint32_t id, const Pose& T_W_S, const geometry::Bend& bend) {
  check_pose(T_W_S);
  check_bend(bend);
  StoredSubmap* found = parts_->store.find(id);
  if (!found) return false;
  found->entry.T_W_S = T_W_S;
  found->entry.bend = bend;
  return true;
}

bool SubmapCollection::remove(std::uint32_t id) {
  StoredSubmap* found = parts_->store.find(id);
  if (!found) return false;
  parts_->merge.remove(found);
  parts_->store.remove(id);
  return true;
}

void SubmapCollection::clear() {
  while (size() > 0) remove(parts_->store.records().begin()->second.entry.id);
}

const SubmapEntry* SubmapCollection::find(std::uint32_t id) const {
  const StoredSubmap* found = std::as_const(parts_->store).find(id);
  return found ? &found->entry : nullptr;
}

std::vector<const SubmapEntry*> SubmapCollection::entries() const {
  std::vector<const SubmapEntry*> out;
  for (const auto& item : parts_->store.records()) out.push_back(&item.second.entry);
  return out;
}

const SubmapEntry* SubmapCollection::newest() const {
  return size() == 0 ? nullptr : &parts_->store.records().rbegin()->second.entry;
}

std::size_t SubmapCollection::size() const { return parts_->store.size(); }

std::uint64_t SubmapCollection::num_dropped() const { return parts_->num_dropped; }

std::size_t SubmapCollection::num_resident() const { return parts_->store.num_resident(); }

std::vector<Index3> SubmapCollection::update() { return parts_->merge.update(&parts_->store); }

const EvidenceMap& SubmapCollection::evidence() const { return parts_->merge.evidence(); }

void SubmapCollection::page_out() { parts_->store.page_out(); }

std::uint32_t SubmapCollection::merge(const SubmapCollection& other, const Pose& T_W_other) {
  check_pose(T_W_other);
  if (other.config().resolution_m != config().resolution_m)
    throw std::invalid_argument("the other map has voxels of another size");
  const std::optional<std::uint32_t> highest = parts_->store.highest_id();
  const std::uint32_t shift = highest ? *highest + 1 : 0;
  const std::uint32_t first_flight = newest() ? newest()->flight + 1 : 0;
  for (const SubmapEntry* entry : other.entries()) {
    SubmapEntry moved = *entry;
    moved.id += shift;
    moved.flight += first_flight;
    moved.T_W_S = T_W_other * entry->T_W_S;
    add(std::move(moved));
  }
  return shift;
}

}  // namespace voxnav::submap
