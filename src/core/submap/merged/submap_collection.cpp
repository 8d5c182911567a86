// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/submap/submap_collection.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <stdexcept>

#include "submap/merged/block_marks.hpp"

namespace voxnav::submap {
namespace {

using geometry::Index3;
using geometry::Pose;
using geometry::Vec3;

/// How far the corners of a box move between two poses.
double largest_move(const geometry::Aabb& box, const Pose& a, const Pose& b) {
  double largest = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 p((corner & 1) ? box.max.x() : box.min.x(), (corner & 2) ? box.max.y() : box.min.y(),
                 (corner & 4) ? box.max.z() : box.min.z());
    largest = std::max(largest, (a * p - b * p).norm());
  }
  return largest;
}

double largest_move(const geometry::Aabb& box, const Placement& a, const Placement& b) {
  if (box.empty()) return 0.0;
  return std::max({largest_move(box, a.T_W_S, b.T_W_S),
                   largest_move(box, a.T_W_S * a.bend.T_S_begin, b.T_W_S * b.bend.T_S_begin),
                   largest_move(box, a.T_W_S * a.bend.T_S_end, b.T_W_S * b.bend.T_S_end)});
}

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

/// The grid of W must be able to hold the submap, and hold it at a bearable cost.
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

/// Where the sensor was, in W: a few places along the way.
std::vector<Vec3> viewpoints(const std::vector<geometry::StampedPose>& T_S_B, const Pose& T_W_S) {
  constexpr std::size_t kMost = 5;
  std::vector<Vec3> out;
  const std::size_t count = std::min(kMost, T_S_B.size());
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t at = count == 1 ? 0 : i * (T_S_B.size() - 1) / (count - 1);
    out.push_back(T_W_S * T_S_B[at].pose.translation());
  }
  return out;
}

}  // namespace

SubmapCollection::SubmapCollection(const SubmapCollectionConfig& config)
    : config_(base::checked(config)),
      evidence_({config.resolution_m, config.clearing_distance_m, config.thin_range_m}) {}

void SubmapCollection::add(SubmapEntry entry) {
  if (!entry.submap) throw std::invalid_argument("a submap entry needs a submap");
  check_pose(entry.T_W_S);
  check_bend(entry.bend);
  check_extent(*entry.submap, entry.T_W_S, config_.resolution_m);
  remove(entry.id);
  const Key key = key_of(entry);
  keys_[entry.id] = key;
  Record& record = records_[key];
  record.bytes = entry.submap->memory_bytes();
  record.remembers = entry.submap->field()->has_memory();
  submap_bytes_ += record.bytes;
  record.entry = std::move(entry);
  enforce_limits();
}

void SubmapCollection::enforce_limits() {
  const double limit = config_.max_memory_mb * 1e6;
  while (records_.size() > 1 && (records_.size() > static_cast<std::size_t>(config_.max_submaps) ||
                                 static_cast<double>(submap_bytes_) > limit)) {
    remove(records_.begin()->second.entry.id);
    ++num_dropped_;
  }
}

bool SubmapCollection::set_pose(std::uint32_t id, const Pose& T_W_S, const geometry::Bend& bend) {
  check_pose(T_W_S);
  check_bend(bend);
  Record* found = record(id);
  if (!found) return false;
  found->entry.T_W_S = T_W_S;
  found->entry.bend = bend;
  return true;
}

bool SubmapCollection::remove(std::uint32_t id) {
  Record* found = record(id);
  if (!found) return false;
  forget(found, &stale_);
  submap_bytes_ -= found->bytes;
  records_.erase(keys_[id]);
  keys_.erase(id);
  return true;
}

void SubmapCollection::clear() {
  while (!records_.empty()) remove(records_.begin()->second.entry.id);
}

SubmapCollection::Record* SubmapCollection::record(std::uint32_t id) {
  const auto key = keys_.find(id);
  return key == keys_.end() ? nullptr : &records_.at(key->second);
}

const SubmapEntry* SubmapCollection::find(std::uint32_t id) const {
  const auto key = keys_.find(id);
  return key == keys_.end() ? nullptr : &records_.at(key->second).entry;
}

std::vector<const SubmapEntry*> SubmapCollection::entries() const {
  std::vector<const SubmapEntry*> out;
  for (const auto& item : records_) out.push_back(&item.second.entry);
  return out;
}

/// Submaps of a flight are numbered without gaps.
Knowledge SubmapCollection::knowledge_of(const Record& r) const {
  if (!r.remembers) return Knowledge::kOwn;
  const SubmapEntry* before = r.entry.id > 0 ? find(r.entry.id - 1) : nullptr;
  return before && before->flight == r.entry.flight ? Knowledge::kOwn : Knowledge::kAll;
}

/// Whether a submap that is merged in a block saw something of it itself.
bool SubmapCollection::owns(const Key& key, const Index3& block) const {
  const Record& r = records_.at(key);
  return r.merged == Knowledge::kOwn || std::binary_search(r.own_blocks.begin(), r.own_blocks.end(), block);
}

/// Whether the memory of the oldest submap of a block counts there. @param without  a submap that is left out of
/// account
bool SubmapCollection::memory_counts(const Index3& block, const Key* without) const {
  if (num_with_memory_ == 0) return false;
  const std::vector<Key>& keys = by_block_.at(block);
  if (records_.at(keys.front()).merged == Knowledge::kOwn) return false;
  return std::none_of(keys.begin() + 1, keys.end(),
                      [&](const Key& key) { return (!without || key != *without) && owns(key, block); });
}

bool SubmapCollection::has_changed(const Record& r) const {
  return r.merged != knowledge_of(r) || largest_move(r.entry.submap->known_bounds(), {r.entry.T_W_S, r.entry.bend},
                                                     r.merged_at) > config_.pose_tolerance_m;
}

/// Takes a submap out of the merge; its blocks have to be rebuilt.
void SubmapCollection::forget(Record* r, std::vector<Index3>* stale) {
  if (!r->is_merged) return;
  const Key key = key_of(r->entry);
  for (const Index3& block : r->blocks) {
    const auto it = by_block_.find(block);
    it->second.erase(std::remove(it->second.begin(), it->second.end(), key), it->second.end());
    if (it->second.empty()) by_block_.erase(it);
  }
  stale->insert(stale->end(), r->blocks.begin(), r->blocks.end());
  r->is_merged = false;
  if (r->merged == Knowledge::kAll) --num_with_memory_;
}

void SubmapCollection::append(const Key& key, Record* r) {
  r->merged_at = {r->entry.T_W_S, r->entry.bend};
  r->is_merged = true;
  r->merged = knowledge_of(*r);
  r->blocks = footprint(*r->entry.submap, r->merged_at, config_.resolution_m, r->merged);
  r->own_blocks.clear();
  if (r->merged == Knowledge::kAll) {
    r->own_blocks = footprint(*r->entry.submap, r->merged_at, config_.resolution_m, Knowledge::kOwn);
    ++num_with_memory_;
  }
  for (const Index3& block : r->blocks) {
    std::vector<Key>& keys = by_block_[block];
    keys.insert(std::lower_bound(keys.begin(), keys.end(), key), key);
  }
}

/// Merges by submap, oldest first, so that each is laid into the grid once however many blocks it has to give.
void SubmapCollection::integrate(std::map<Key, std::vector<Index3>> work) {
  for (auto& [key, blocks] : work) {
    Record& r = records_.at(key);
    r.last_used = ++num_uses_;
    if (r.merged == Knowledge::kAll) {
      const auto is_alone = [&, k = key](const Index3& block) {
        return by_block_.at(block).front() == k && memory_counts(block);
      };
      std::vector<Index3> alone;
      std::copy_if(blocks.begin(), blocks.end(), std::back_inserter(alone), is_alone);
      integrate(&r, Knowledge::kAll, alone);
      blocks.erase(std::remove_if(blocks.begin(), blocks.end(), is_alone), blocks.end());
    }
    integrate(&r, Knowledge::kOwn, blocks);
    page_out();
  }
}

void SubmapCollection::integrate(Record* r, Knowledge knowledge, const std::vector<Index3>& blocks) {
  if (blocks.empty()) return;
  const PlacedSubmap placed(*r->entry.submap, r->entry.id, r->merged_at, config_.resolution_m, knowledge,
                            viewpoints(r->entry.T_S_B, r->merged_at.T_W_S));
  for (const Index3& block : blocks) evidence_.integrate(block, placed);
}

void SubmapCollection::page_out() {
  if (config_.page_dir.empty()) return;
  std::size_t resident = 0;
  std::vector<const Record*> candidates;
  for (const auto& item : records_) {
    if (!item.second.entry.submap->is_resident()) continue;
    resident += item.second.bytes;
    candidates.push_back(&item.second);
  }
  const auto limit = static_cast<std::size_t>(config_.max_resident_mb * 1e6);
  if (resident <= limit) return;
  std::sort(candidates.begin(), candidates.end(),
            [](const Record* a, const Record* b) { return a->last_used < b->last_used; });
  for (const Record* r : candidates) {
    if (resident <= limit) return;
    // The address keeps two collections of one process apart.
    char name[96];
    std::snprintf(name, sizeof(name), "/page_%ld_%p_%u.vxs", static_cast<long>(::getpid()),
                  static_cast<const void*>(r->entry.submap.get()), r->entry.id);
    r->entry.submap->page_out(config_.page_dir + name);
    resident -= r->bytes;
  }
}

std::size_t SubmapCollection::num_resident() const {
  return static_cast<std::size_t>(std::count_if(
      records_.begin(), records_.end(), [](const auto& item) { return item.second.entry.submap->is_resident(); }));
}

std::vector<Index3> SubmapCollection::update() {
  std::vector<Index3> stale = std::move(stale_);
  stale_.clear();
  for (auto& item : records_) {
    if (item.second.is_merged && has_changed(item.second)) forget(&item.second, &stale);
  }
  std::map<Key, std::vector<Index3>> fresh;  // blocks to which submaps newer than all that is there are added
  for (auto& [key, r] : records_) {
    if (r.is_merged) continue;
    append(key, &r);
    for (const Index3& block : r.blocks) {
      const std::vector<Key>& keys = by_block_[block];
      // Who sees a place takes the memory of others away.
      const bool is_added = keys.back() == key && (keys.size() == 1 || !memory_counts(block, &key));
      (is_added ? fresh[key] : stale).push_back(block);
    }
  }
  sort_unique(&stale);
  std::map<Key, std::vector<Index3>> work;
  for (const Index3& block : stale) {
    const auto found = by_block_.find(block);
    if (found == by_block_.end()) {
      evidence_.clear_block(block);
      continue;
    }
    evidence_.reset_block(block);
    for (const Key& key : found->second) work[key].push_back(block);
  }
  std::vector<Index3> changed = stale;
  for (const auto& [key, blocks] : fresh) {
    for (const Index3& block : blocks) {
      if (std::binary_search(stale.begin(), stale.end(), block)) continue;
      work[key].push_back(block);
      changed.push_back(block);
    }
  }
  integrate(std::move(work));
  sort_unique(&changed);
  return changed;
}

std::uint32_t SubmapCollection::merge(const SubmapCollection& other, const Pose& T_W_other) {
  check_pose(T_W_other);
  if (other.config_.resolution_m != config_.resolution_m)
    throw std::invalid_argument("the other map has voxels of another size");
  const std::uint32_t shift = keys_.empty() ? 0 : keys_.rbegin()->first + 1;
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
