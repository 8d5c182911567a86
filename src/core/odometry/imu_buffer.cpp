// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/imu_buffer.hpp"

#include <algorithm>
#include <cmath>

namespace voxnav::odometry {
namespace {

using geometry::Vec3;

bool is_before(const ImuSample& sample, base::StampNs stamp_ns) { return sample.stamp_ns < stamp_ns; }

}  // namespace

Eigen::Quaterniond exp_so3(const Vec3& rotation) {
  const double angle = rotation.norm();
  const double scale = angle < 1e-9 ? 0.5 : std::sin(angle / 2) / angle;
  const Vec3 v = rotation * scale;
  return Eigen::Quaterniond(std::cos(angle / 2), v.x(), v.y(), v.z()).normalized();
}

Vec3 log_so3(const Eigen::Quaterniond& q) {
  const double sine = q.vec().norm();
  // q and -q are the same rotation, of which the vector with the smaller angle is wanted.
  const double angle = 2.0 * std::atan2(sine, std::abs(q.w()));
  const double sign = q.w() < 0 ? -1.0 : 1.0;
  return sine < 1e-12 ? Vec3(2.0 * sign * q.vec()) : Vec3(q.vec() * (sign * angle / sine));
}

ImuBuffer::AddResult ImuBuffer::add(const ImuSample& sample) {
  if (!sample.gyro_radps.allFinite() || !sample.accel_mps2.allFinite()) return AddResult::kNotFinite;
  const auto verdict = clock_.add(sample.stamp_ns);
  if (verdict == base::StampVerdict::kLate || verdict == base::StampVerdict::kRepeated) return AddResult::kNotNewer;
  if (verdict == base::StampVerdict::kStray) return AddResult::kOtherClock;
  const bool is_new_clock = verdict == base::StampVerdict::kNewClock;
  if (is_new_clock) samples_.clear();
  samples_.push_back(sample);
  if (samples_.size() > kMaxSamples) samples_.pop_front();
  return is_new_clock ? AddResult::kAddedOnNewClock : AddResult::kAdded;
}

void ImuBuffer::clear() {
  samples_.clear();
  clock_.reset();
}

void ImuBuffer::forget_before(base::StampNs stamp_ns) {
  while (!samples_.empty() && samples_.front().stamp_ns < stamp_ns) samples_.pop_front();
}

std::optional<Eigen::Quaterniond> ImuBuffer::rotation(base::StampNs from_ns, base::StampNs to_ns,
                                                      const Vec3& bias_radps, double max_gap_s) const {
  if (to_ns < from_ns) {
    const auto backward = rotation(to_ns, from_ns, bias_radps, max_gap_s);
    if (!backward) return std::nullopt;
    return backward->conjugate();
  }
  const base::StampNs gap_ns = base::from_seconds(max_gap_s);
  auto next = std::lower_bound(samples_.begin(), samples_.end(), from_ns, is_before);
  if (next == samples_.end()) {
    if (samples_.empty() || to_ns - samples_.back().stamp_ns > gap_ns) return std::nullopt;
    return exp_so3((samples_.back().gyro_radps - bias_radps) * base::to_seconds(to_ns - from_ns));
  }
  auto previous = next == samples_.begin() ? next : std::prev(next);
  if (next->stamp_ns - std::min(previous->stamp_ns, from_ns) > gap_ns) return std::nullopt;
  Eigen::Quaterniond total = Eigen::Quaterniond::Identity();
  base::StampNs now = from_ns;
  while (now < to_ns) {
    const bool is_last = next == samples_.end();
    const base::StampNs until = is_last ? to_ns : std::min(next->stamp_ns, to_ns);
    if (until - previous->stamp_ns > gap_ns && until > previous->stamp_ns) return std::nullopt;
    const Vec3 rate = is_last ? previous->gyro_radps : Vec3(0.5 * (previous->gyro_radps + next->gyro_radps));
    total = total * exp_so3((rate - bias_radps) * base::to_seconds(until - now));
    now = until;
    if (!is_last) {
      previous = next;
      ++next;
    }
  }
  return total.normalized();
}

std::optional<MeanForce> ImuBuffer::mean_force(base::StampNs from_ns, base::StampNs to_ns) const {
  MeanForce out;
  int count = 0;
  for (auto it = std::lower_bound(samples_.begin(), samples_.end(), from_ns, is_before);
       it != samples_.end() && it->stamp_ns <= to_ns; ++it) {
    out.mean += it->accel_mps2;
    out.mean_norm += it->accel_mps2.norm();
    ++count;
  }
  if (count == 0) return std::nullopt;
  out.mean /= count;
  out.mean_norm /= count;
  return out;
}

}  // namespace voxnav::odometry
