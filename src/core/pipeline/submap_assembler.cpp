// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/pipeline/submap_assembler.hpp"

#include <stdexcept>
#include <utility>

namespace voxnav::pipeline {
namespace {

/// Bound on the pose history of a submap of clouds, which would otherwise grow as long as nothing closes the submap.
constexpr std::size_t kMaxPoses = 10000;

/// Copies the fields of a handover besides its content.
submap::SubmapEntry entry_of(const Handover& handover) {
  submap::SubmapEntry entry;
  entry.id = handover.submap_id;
  entry.start_ns = handover.start_ns;
  entry.end_ns = handover.stamp_ns;
  entry.T_O_S = handover.T_O_S;
  entry.T_W_S = handover.T_O_S;
  entry.T_S_B = handover.poses;
  return entry;
}

}  // namespace

SubmapAssembler::SubmapAssembler(const SubmapAssemblerConfig& config) : config_(config) {
  if (config_.max_open_submaps < 1) throw std::invalid_argument("max_open_submaps must be at least 1");
  if (config_.projective) integrator_.emplace(*config_.projective);
}

SubmapAssembler::Result SubmapAssembler::add(const Handover& handover) {
  Result out;
  if (integrator_) {
    if (handover.is_final && config_.projective_period_s <= 0.0) out.submap = close_as(entry_of(handover));
    return out;
  }
  if (handover.is_final) {
    auto early = early_.extract(handover.submap_id);
    if (!early.empty()) early.mapped().merge(handover.content);
    out.submap = fill(handover, early.empty() ? handover.content : early.mapped());
    return out;
  }
  early_[handover.submap_id].merge(handover.content);
  if (early_.size() > static_cast<std::size_t>(config_.max_open_submaps)) {
    const auto oldest = early_.begin();
    out.dropped = "the early content of submap " + std::to_string(oldest->first) + " was given up: its last part has " +
                  "not come, and " + std::to_string(config_.max_open_submaps) + " other submaps wait for theirs";
    early_.erase(oldest);
  }
  return out;
}

submap::SubmapEntry SubmapAssembler::fill(const Handover& handover, const occupancy::MapContent& content) const {
  submap::SubmapEntry entry = entry_of(handover);
  entry.submap = submap::Submap::from_content(content, entry.T_O_S.inverse(Eigen::Isometry), config_.submap);
  return entry;
}

void SubmapAssembler::integrate(const std::vector<geometry::Vec3f>& points_L, const geometry::Pose& T_O_L,
                                base::StampNs stamp_ns) {
  if (!integrator_) throw std::logic_error("submaps are filled by handovers, not by clouds");
  integrator_->integrate(points_L, T_O_L);
  if (open_.T_S_B.empty()) {
    open_.start_ns = stamp_ns;
    open_.T_O_S = geometry::gravity_aligned(T_O_L);
  }
  if (open_.T_S_B.size() < kMaxPoses) open_.T_S_B.push_back({stamp_ns, open_.T_O_S.inverse(Eigen::Isometry) * T_O_L});
  open_.end_ns = stamp_ns;
}

bool SubmapAssembler::is_due() const {
  if (!integrator_ || open_.T_S_B.empty() || config_.projective_period_s <= 0.0) return false;
  const double age_s = base::to_seconds(open_.end_ns - open_.start_ns);
  return age_s >= config_.projective_period_s || age_s < 0.0;
}

submap::SubmapEntry SubmapAssembler::close() {
  if (!integrator_) throw std::logic_error("submaps are filled by handovers, not by clouds");
  submap::SubmapEntry entry = std::move(open_);
  entry.T_W_S = entry.T_O_S;
  return close_as(std::move(entry));
}

submap::SubmapEntry SubmapAssembler::close_as(submap::SubmapEntry entry) {
  entry.submap = integrator_->finish(config_.submap, entry.T_O_S.inverse(Eigen::Isometry));
  open_ = {};
  open_.id = entry.id + 1;
  return entry;
}

}  // namespace voxnav::pipeline
