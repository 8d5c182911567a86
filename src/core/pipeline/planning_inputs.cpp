// SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/planning_inputs.hpp"

#include <algorithm>

namespace voxnav::pipeline {
namespace {

template <class T>
std::optional<std::string> age_problem(const std::optional<Timed<T>>& input, const char* what, double now_s,
                                       double timeout_s) {
  if (!input) return std::string("no ") + what + " yet";
  // Without the age, which would make a new text of every tick.
  if (now_s - input->stamp_s > timeout_s) return std::string(what) + " lost";
  return std::nullopt;
}

}  // namespace

std::vector<std::string> PlanningManagerConfig::problems() const {
  std::vector<std::string> out;
  if (min_corridor_radius_m > corridor_radius_m) {
    out.emplace_back("min_corridor_radius_m must not be above corridor_radius_m");
  }
  return out;
}

std::optional<geometry::Vec3> Prediction::at(double time_s) const {
  if (times_s.empty() || times_s.size() != positions_O.size()) return std::nullopt;
  if (time_s < times_s.front() || time_s > times_s.back()) return std::nullopt;
  const auto after = std::lower_bound(times_s.begin(), times_s.end(), time_s);
  const auto i = static_cast<std::size_t>(after - times_s.begin());
  if (i == 0) return positions_O.front();
  const double ratio = (time_s - times_s[i - 1]) / std::max(1e-9, times_s[i] - times_s[i - 1]);
  return geometry::Vec3(positions_O[i - 1] + ratio * (positions_O[i] - positions_O[i - 1]));
}

std::optional<std::string> PlanningInputs::problem(double now_s, const PlanningManagerConfig& config) const {
  if (auto p = age_problem(vehicle, "odometry", now_s, config.odometry_timeout_s)) return p;
  if (auto p = age_problem(control, "control manager diagnostics", now_s, config.diagnostics_timeout_s)) return p;
  if (!control->value.is_flying) return "not flying";
  if (!control->value.accepts_goals) return "tracker does not accept goals";
  if (auto p = age_problem(limits, "constraints", now_s, config.constraints_timeout_s)) return p;
  if (!limits->value.is_valid()) return "constraints are not positive";
  if (auto p = age_problem(prediction, "tracker prediction", now_s, config.tracker_timeout_s)) return p;
  const std::optional<Timed<int>> map = map_stamp_s ? std::optional<Timed<int>>({*map_stamp_s, 0}) : std::nullopt;
  if (auto p = age_problem(map, "local map", now_s, config.map_timeout_s)) return p;
  if (!map_frame.empty() && !control_frame.empty() && map_frame != control_frame) {
    return "the local map is in frame " + map_frame + ", the vehicle in " + control_frame;
  }
  const double correction_s = config.correction_timeout_s > 0.0 ? config.correction_timeout_s : 1e18;
  if (auto p = age_problem(T_W_O, "map correction", now_s, correction_s)) return p;
  if (!lost_nodes.empty()) return *lost_nodes.begin() + " is not running";
  return std::nullopt;
}

}  // namespace voxnav::pipeline
