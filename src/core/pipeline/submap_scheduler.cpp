// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/pipeline/submap_scheduler.hpp"

#include <algorithm>
#include <utility>

namespace voxnav::pipeline {
namespace {

constexpr base::StampNs kSecond_ns = 1000000000;

}  // namespace

SubmapScheduler::SubmapScheduler(const SubmapSchedulerConfig& config, std::optional<std::uint32_t> first_id)
    : config_(base::checked(config)), submap_id_(first_id) {}

std::optional<std::string> SubmapScheduler::add_scan(base::StampNs stamp_ns, const geometry::Pose& T_O_B) {
  if (!is_open()) {
    T_O_S_ = geometry::gravity_aligned(T_O_B);
    newest_ = {stamp_ns, T_O_B};
    if (!submap_id_) submap_id_ = static_cast<std::uint32_t>(std::max<base::StampNs>(stamp_ns, 0) / kSecond_ns);
  } else if (stamp_ns <= newest_.stamp_ns) {
    return std::nullopt;
  }
  distance_m_ += (T_O_B.translation() - newest_.pose.translation()).norm();
  newest_ = {stamp_ns, T_O_B};
  keep_pose(stamp_ns, T_O_B);
  const double age_s = base::to_seconds(stamp_ns - poses_.front().stamp_ns);
  if (age_s >= config_.period_s) return "time";
  if (distance_m_ >= config_.max_distance_m) return "distance";
  if (!requested_.empty() && age_s >= config_.min_period_s) return requested_;
  return std::nullopt;
}

void SubmapScheduler::request_close(const std::string& reason) {
  if (is_open() && requested_.empty()) requested_ = reason;
}

/// Adds a pose to the history, of which every other pose is dropped when it is full. The first and the newest pose are
/// always kept, so that it spans the whole submap.
void SubmapScheduler::keep_pose(base::StampNs stamp_ns, const geometry::Pose& T_O_B) {
  if (poses_.size() + 1 >= static_cast<std::size_t>(config_.max_poses)) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < poses_.size(); i += 2) poses_[kept++] = poses_[i];
    poses_.resize(kept);
  }
  poses_.push_back({stamp_ns, T_O_B});
}

void SubmapScheduler::add_evicted(const occupancy::MapContent& content) {
  if (!content.blocks.empty()) evicted_.merge(content);
}

Handover SubmapScheduler::header(const std::string& reason, bool is_final) const {
  Handover out;
  out.submap_id = submap_id();
  out.is_final = is_final;
  out.reason = reason;
  out.start_ns = poses_.front().stamp_ns;
  out.stamp_ns = newest_.stamp_ns;
  out.T_O_S = T_O_S_;
  const geometry::Pose T_S_O = T_O_S_.inverse();
  for (const geometry::StampedPose& pose : poses_) out.poses.push_back({pose.stamp_ns, T_S_O * pose.pose});
  return out;
}

std::optional<Handover> SubmapScheduler::take_early() {
  const bool is_due = evicted_.blocks.size() > static_cast<std::size_t>(config_.max_early_blocks);
  if (!is_open() || !is_due) return std::nullopt;
  Handover out = header("window", false);
  out.content = std::exchange(evicted_, occupancy::MapContent{});
  return out;
}

std::optional<Handover> SubmapScheduler::close(const std::string& reason, occupancy::MapContent content) {
  if (!is_open()) return std::nullopt;
  Handover out = header(reason, true);
  out.content = std::exchange(evicted_, occupancy::MapContent{});
  if (out.content.blocks.empty()) {
    out.content = std::move(content);
  } else {
    out.content.merge(content);
  }
  discard();
  return out;
}

std::vector<Handover> SubmapScheduler::add_scan(occupancy::LocalMap* map, base::StampNs stamp_ns,
                                                const geometry::Pose& T_O_B) {
  std::vector<Handover> out;
  const std::optional<std::string> reason = add_scan(stamp_ns, T_O_B);
  add_evicted(map->take_evicted());
  if (std::optional<Handover> early = take_early()) out.push_back(std::move(*early));
  if (!reason) return out;
  if (std::optional<Handover> closed = close(*reason, map->hand_over())) out.push_back(std::move(*closed));
  return out;
}

std::vector<Handover> SubmapScheduler::finish(occupancy::LocalMap* map, const std::string& reason) {
  std::vector<Handover> out;
  add_evicted(map->take_evicted());
  if (std::optional<Handover> closed = close(reason, map->hand_over())) out.push_back(std::move(*closed));
  return out;
}

void SubmapScheduler::discard() {
  if (is_open()) ++*submap_id_;
  poses_.clear();
  distance_m_ = 0.0;
  requested_.clear();
  evicted_ = occupancy::MapContent{};
}

}  // namespace voxnav::pipeline
