// SPDX-License-Identifier: BSD-3-Clause
#include "heading_profile.hpp"

#include <cmath>

#include "path_smoothing.hpp"
#include "voxnav_simulation/limited_motion.hpp"

namespace voxnav_simulation {
namespace {

constexpr double kMinSpeedForHeading = 0.3;
constexpr int kMaxSettleSteps = 6000;
using voxnav::geometry::wrap_angle;

/// Interpolates headings linearly between (step, heading) knots, without jumps of a full turn.
class Knots {
 public:
  void add(std::size_t step, double heading) {
    if (!headings_.empty()) heading = headings_.back() + wrap_angle(heading - headings_.back());
    steps_.push_back(step);
    headings_.push_back(heading);
  }
  double at(std::size_t step) {
    while (next_ < steps_.size() && steps_[next_] <= step) ++next_;
    if (next_ == 0) return headings_.front();
    if (next_ == steps_.size()) return headings_.back();
    const auto span = static_cast<double>(steps_[next_] - steps_[next_ - 1]);
    const double ratio = static_cast<double>(step - steps_[next_ - 1]) / span;
    return headings_[next_ - 1] + ratio * (headings_[next_] - headings_[next_ - 1]);
  }

 private:
  std::vector<std::size_t> steps_;
  std::vector<double> headings_;
  std::size_t next_ = 0;
};

std::vector<double> wanted(const PathRequest& request, const std::vector<HeadedPoint>& waypoints, double start,
                           const std::vector<std::size_t>& waypoint_steps, const std::vector<Vec3>& positions) {
  std::vector<double> out(positions.size(), start);
  if (request.has_heading_of_motion) {
    for (std::size_t i = 1; i < positions.size(); ++i) {
      const Vec3 v = (positions[i] - positions[i - 1]) / kFineStep_s;
      const double target = v.head<2>().norm() > kMinSpeedForHeading ? std::atan2(v.y(), v.x()) : out[i - 1];
      out[i] = out[i - 1] + wrap_angle(target - out[i - 1]);
    }
  } else if (request.use_heading) {
    Knots knots;
    knots.add(0, start);
    for (std::size_t i = 0; i < waypoints.size(); ++i) {
      if (!request.has_relaxed_heading || i + 1 == waypoints.size())
        knots.add(waypoint_steps[i], waypoints[i].heading_rad);
    }
    for (std::size_t i = 0; i < positions.size(); ++i) out[i] = knots.at(i);
  }
  return out;
}

}  // namespace

std::vector<double> heading_profile(const PathRequest& request, const std::vector<HeadedPoint>& waypoints,
                                    const TrackerAxisLimits& limits, const std::vector<std::size_t>& waypoint_steps,
                                    std::vector<Vec3>* positions) {
  MotionState<1> state;
  state.position[0] = request.start ? request.start->heading_rad : waypoints.front().heading_rad;
  if (request.start) {
    state.velocity[0] = request.start->heading_rate;
    state.acceleration[0] = request.start->heading_acceleration;
  }
  const std::vector<double> targets = wanted(request, waypoints, state.position[0], waypoint_steps, *positions);
  const MotionLimits motion_limits{limits.speed, limits.acceleration, limits.jerk};
  std::vector<double> out;
  const std::size_t given = positions->size();
  for (std::size_t i = 0; i < given + kMaxSettleSteps; ++i) {
    const std::size_t k = std::min(i, given - 1);
    if (i >= given) {
      if (std::abs(state.position[0] - targets.back()) < 2e-3 && std::abs(state.velocity[0]) < 5e-3) break;
      positions->push_back(positions->back());
    }
    out.push_back(wrap_angle(state.position[0]));
    MotionReference<1> reference;
    reference.position[0] = targets[k];
    if (k + 1 < given) reference.velocity[0] = (targets[k + 1] - targets[k]) / kFineStep_s;
    state = limited_step<1>(state, reference, motion_limits, kFineStep_s);
  }
  return out;
}

}  // namespace voxnav_simulation
