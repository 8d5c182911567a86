// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/submap/submap_collection.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <limits>
#include <stdexcept>

#include "voxnav/submap/voxel_walk.hpp"

namespace voxnav::submap {
namespace {

using geometry::Index3;
using geometry::Pose;
using geometry::Vec3;

void sort_unique(std::vector<Index3>* blocks) {
  std::sort(blocks->begin(), blocks->end());
  blocks->erase(std::unique(blocks->begin(), blocks->end()), blocks->end());
}

/// How far the corners of a box move between two poses.
double largest_move(const geometry::Aabb& box, const Pose& a, const Pose& b) {
  if (box.empty()) return 0.0;
  double largest = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 p((corner & 1) ? box.max.x() : box.min.x(), (corner & 2) ? box.max.y() : box.min.y(),
                 (corner & 4) ? box.max.z() : box.min.z());
    largest = std::max(largest, (a * p - b * p).norm());
  }
  return largest;
}

void check_pose(const Pose& T_W_S) {
  constexpr double kFarthest_m = 1e6;  // voxel indices stay within 32 bits
  if (!geometry::is_valid(T_W_S)) throw std::invalid_argument("T_W_S must be a finite rigid transform");
  if (T_W_S.translation().cwiseAbs().maxCoeff() > kFarthest_m)
    throw std::invalid_argument("T_W_S is farther than 1000 km");
}

}  // namespace

SubmapCollection::SubmapCollection(const SubmapCollectionConfig& config)
    : config_(base::checked(config)), evidence_(config.resolution_m, config.clearing_distance_m) {}

void SubmapCollection::add(SubmapEntry entry) {
  if (!entry.submap) throw std::invalid_argument("a submap entry needs a submap");
  check_pose(entry.T_W_S);
  remove(entry.id);
  const Key key(entry.end_ns, entry.id);
  keys_[entry.id] = key;
  Record& record = records_[key];
  record.bytes = entry.submap->memory_bytes();
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

bool SubmapCollection::set_pose(std::uint32_t id, const Pose& T_W_S) {
  check_pose(T_W_S);
  Record* found = record(id);
  if (found) found->entry.T_W_S = T_W_S;
  return found != nullptr;
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

bool SubmapCollection::has_moved(const Record& r) const {
  return largest_move(r.entry.submap->known_bounds(), r.entry.T_W_S, r.merged_T_W_S) > config_.pose_tolerance_m;
}

/// Takes a submap out of the merge; its blocks have to be rebuilt.
void SubmapCollection::forget(Record* r, std::vector<Index3>* stale) {
  if (!r->is_merged) return;
  const Key key(r->entry.end_ns, r->entry.id);
  for (const Index3& block : r->blocks) {
    const auto it = by_block_.find(block);
    it->second.erase(std::remove(it->second.begin(), it->second.end(), key), it->second.end());
    if (it->second.empty()) by_block_.erase(it);
  }
  stale->insert(stale->end(), r->blocks.begin(), r->blocks.end());
  r->is_merged = false;
}

void SubmapCollection::append(const Key& key, Record* r) {
  r->merged_T_W_S = r->entry.T_W_S;
  r->is_merged = true;
  r->blocks = footprint(*r->entry.submap, r->entry.T_W_S, config_.resolution_m);
  for (const Index3& block : r->blocks) {
    std::vector<Key>& keys = by_block_[block];
    keys.insert(std::lower_bound(keys.begin(), keys.end(), key), key);
  }
}

/// Merges by submap, oldest first, so that each is laid into the grid once however many blocks it has to give.
void SubmapCollection::integrate(const std::map<Key, std::vector<Index3>>& work) {
  for (const auto& [key, blocks] : work) {
    Record& r = records_.at(key);
    r.last_used = ++num_uses_;
    const PlacedSubmap placed(*r.entry.submap, r.entry.id, r.merged_T_W_S, config_.resolution_m);
    for (const Index3& block : blocks) evidence_.integrate(block, placed);
    page_out();
  }
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
    if (item.second.is_merged && has_moved(item.second)) forget(&item.second, &stale);
  }
  std::map<Key, std::vector<Index3>> fresh;  // blocks to which submaps newer than all that is there are added
  for (auto& [key, r] : records_) {
    if (r.is_merged) continue;
    append(key, &r);
    for (const Index3& block : r.blocks) (by_block_[block].back() == key ? fresh[key] : stale).push_back(block);
  }
  sort_unique(&stale);
  std::map<Key, std::vector<Index3>> work;
  for (const Index3& block : stale) {
    evidence_.clear_block(block);
    const auto found = by_block_.find(block);
    if (found == by_block_.end()) continue;
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
  integrate(work);
  sort_unique(&changed);
  return changed;
}

std::vector<geometry::Vec3f> SubmapCollection::occupied_points() {
  update();
  std::vector<Index3> order;
  for (const auto& item : evidence_.blocks()) order.push_back(item.first);
  std::sort(order.begin(), order.end());
  std::vector<geometry::Vec3f> out;
  for (const Index3& index : order) {
    for (const EvidenceLeaf& leaf : evidence_.find(index)->leaves) {
      out.push_back(evidence_.point_of(index, leaf).cast<float>());
    }
  }
  return out;
}

containers::StateGrid SubmapCollection::obstacles(double safety_distance_m) {
  update();
  ObstacleMap obstacles(config_.resolution_m, safety_distance_m);
  std::vector<Index3> all;
  for (const auto& item : evidence_.blocks()) all.push_back(item.first);
  obstacles.mark_changed(all);
  obstacles.update(evidence_, std::numeric_limits<std::size_t>::max());
  return obstacles.grid();
}

containers::State SubmapCollection::state(const Vec3& p_W) {
  update();
  return evidence_.state(p_W);
}

std::optional<double> SubmapCollection::distance(const Vec3& p_W, double max_distance_m) {
  update();
  if (evidence_.state(p_W) == containers::State::kUnknown) return std::nullopt;
  return evidence_.distance_to_surface(p_W, max_distance_m).value_or(max_distance_m);
}

std::optional<Vec3> SubmapCollection::gradient(const Vec3& p_W, double max_distance_m) {
  update();
  if (evidence_.state(p_W) == containers::State::kUnknown) return std::nullopt;
  const auto nearest = evidence_.nearest_surface(p_W, max_distance_m);
  if (!nearest || nearest->distance_m == 0.0) return Vec3(Vec3::Zero());
  return Vec3((p_W - nearest->point_W) / nearest->distance_m);
}

SubmapCollection::Ray SubmapCollection::cast_ray(const Vec3& a_W, const Vec3& b_W) {
  constexpr double kLongest_m = 1e4;
  if (!a_W.allFinite() || !b_W.allFinite() || !((b_W - a_W).norm() < kLongest_m) || a_W.cwiseAbs().maxCoeff() > 1e7)
    throw std::invalid_argument("a ray needs finite ends less than 10 km apart");
  update();
  Ray out;
  const double length_m = (b_W - a_W).norm();
  VoxelWalk walk(a_W / config_.resolution_m, b_W / config_.resolution_m);
  Index3 at{1 << 30, 0, 0};
  const EvidenceBlock* block = nullptr;
  for (int axis = 0; axis >= 0; axis = walk.advance()) {
    const Index3 voxel = walk.index();
    if (geometry::block_of(voxel) != at) {
      at = geometry::block_of(voxel);
      block = evidence_.find(at);
    }
    out.state = block ? block->states.get(geometry::offset_in_block(voxel)) : containers::State::kUnknown;
    out.distance_m = walk.entered() * length_m;
    if (out.state != containers::State::kFree) return out;
  }
  out.distance_m = length_m;
  return out;
}

std::vector<SceneChange> SubmapCollection::changes(std::size_t min_voxels) {
  update();
  return scene_changes(evidence_, min_voxels);
}

std::uint32_t SubmapCollection::merge(const SubmapCollection& other, const Pose& T_W_other) {
  check_pose(T_W_other);
  if (other.config_.resolution_m != config_.resolution_m)
    throw std::invalid_argument("the other map has voxels of another size");
  const std::uint32_t shift = keys_.empty() ? 0 : keys_.rbegin()->first + 1;
  for (const SubmapEntry* entry : other.entries()) {
    SubmapEntry moved = *entry;
    moved.id += shift;
    moved.T_W_S = T_W_other * entry->T_W_S;
    add(std::move(moved));
  }
  return shift;
}

std::size_t SubmapCollection::memory_bytes() const {
  std::size_t bytes = sizeof(*this) + evidence_.memory_bytes();
  for (const auto& item : records_) {
    bytes += sizeof(item) + item.second.entry.submap->memory_bytes() + item.second.blocks.capacity() * sizeof(Index3) +
             item.second.entry.T_S_B.capacity() * sizeof(geometry::StampedPose);
  }
  for (const auto& item : by_block_) bytes += sizeof(item) + item.second.capacity() * sizeof(Key);
  return bytes;
}

}  // namespace voxnav::submap
