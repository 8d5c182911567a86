// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav_simulation/trajectory_generator.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "heading_profile.hpp"
#include "path_smoothing.hpp"
#include "voxnav_simulation/speed_profile.hpp"

namespace voxnav_simulation {
namespace {

constexpr double kTolerance = 1e-3;     ///< of limits, for rounding
constexpr double kMinSegment_m = 1e-3;  ///< nearer waypoints are one
constexpr double kBrakingShare = 0.55;  ///< of the acceleration, for the distance to brake before the path
constexpr double kStraight = 0.03;      ///< smaller turns need no reserve
constexpr double kCornerShare = 0.75;   ///< of the acceleration, as a first guess of the speed at corners

/// Everything about one attempt to fly the waypoints.
struct Attempt {
  std::vector<Vec3> positions;  ///< every fine step, after smoothing
  std::vector<SpeedProfile::Sample>
      raw;  ///< raw[i + 2 * half] is averaged into positions[i] .. positions[i + 4 * half]
  std::vector<std::size_t> waypoint_vertices;
  double deviation_m = 0;
  int iterations = 0;
};

class Generator {
 public:
  Generator(const TrajectoryGeneratorConfig& config, const PathRequest& request, double window_share)
      : config_(config),
        request_(request),
        limits_(request.limits.scaled(config.limit_ratio)),
        deviation_m_(request.max_deviation_m > 0 ? request.max_deviation_m : config.default_deviation_m),
        windows_(limits_, window_share * deviation_m_) {}

  GeneratedTrajectory run() {
    GeneratedTrajectory out;
    out.message = problem();
    if (!out.message.empty()) return out;
    prepare();
    const std::optional<Attempt> attempt = best_attempt(&out);
    if (!attempt) {
      out.message = "the path takes longer than " + std::to_string(config_.max_duration_s) + " s";
      return out;
    }
    finish(*attempt, &out);
    return out;
  }

 private:
  std::string problem() const;
  void prepare();
  void settle_acceleration();
  std::vector<Vec3> vertices(double braking_ratio, std::vector<std::size_t>* waypoint_vertices) const;
  double corner_speed(const Polyline& path, std::size_t vertex) const;
  std::optional<Attempt> best_attempt(GeneratedTrajectory* out) const;
  std::optional<Attempt> attempt(double braking_ratio, bool stop_everywhere, bool* is_too_long) const;
  std::vector<double> reserves(const Polyline& path) const;
  bool fly(const Polyline& path, const SpeedProfile& profile, Attempt* out) const;
  std::vector<double> check(const Polyline& path, Attempt* attempt) const;
  bool slow_down(const std::vector<double>& ratios, const Attempt& attempt, SpeedProfile* profile) const;
  void finish(const Attempt& attempt, GeneratedTrajectory* out) const;
  std::vector<std::size_t> waypoint_steps(const Attempt& attempt, std::size_t offset) const;

  const TrajectoryGeneratorConfig& config_;
  const PathRequest& request_;
  DynamicsLimits limits_;
  double deviation_m_;
  SmoothingWindows windows_;
  std::vector<HeadedPoint> waypoints_;
  std::vector<Vec3> lead_;        ///< fine samples in which the start acceleration goes to zero
  Vec3 start_ = Vec3::Zero();     ///< after that
  Vec3 velocity_ = Vec3::Zero();  ///< at start_
};

std::string Generator::problem() const {
  if (request_.waypoints.empty()) return "the path is empty";
  if (request_.waypoints.size() > static_cast<std::size_t>(config_.max_waypoints)) {
    return "the path has more than " + std::to_string(config_.max_waypoints) + " waypoints";
  }
  for (const HeadedPoint& point : request_.waypoints) {
    if (!is_finite(point)) return "the path contains a value that is not finite";
  }
  if (request_.start && !is_finite(*request_.start)) return "the start state is not finite";
  if (!(deviation_m_ >= 0.01)) return "the allowed deviation from the path is below 0.01 m or not a number";
  const auto positive = [](const AxisLimits& l) { return l.speed > 0 && l.acceleration > 0 && l.jerk > 0; };
  if (!positive(limits_.horizontal) || !positive(limits_.ascending) || !positive(limits_.descending) ||
      !positive(limits_.heading)) {
    return "the constraints are not positive";
  }
  return {};
}

void Generator::prepare() {
  waypoints_ = request_.waypoints;
  if (request_.is_loop) waypoints_.push_back(waypoints_.front());
  start_ = request_.start ? request_.start->position : waypoints_.front().position;
  if (request_.start) settle_acceleration();
}

/// Takes the acceleration to zero with constant jerk, so that the rest starts at constant velocity.
void Generator::settle_acceleration() {
  const KinematicState& s = *request_.start;
  const double needed_s = std::max(s.acceleration.head<2>().norm() / limits_.horizontal.jerk,
                                   std::abs(s.acceleration.z()) / limits_.vertical_jerk());
  const auto steps = static_cast<int>(std::ceil(needed_s / kFineStep_s - 1e-9));
  velocity_ = s.velocity;
  if (steps == 0) return;
  const double total = steps * kFineStep_s;
  for (int i = 0; i <= steps; ++i) {
    const double t = i * kFineStep_s;
    start_ = s.position + s.velocity * t + s.acceleration * (0.5 * t * t - t * t * t / (6 * total));
    if (i < steps) lead_.push_back(start_);
  }
  velocity_ = s.velocity + 0.5 * total * s.acceleration;
}

/// The straight lines that are flown: after the smoothing's half width at constant velocity, the distance to brake
/// (its share `braking_ratio`) straight on, then the waypoints. Waypoints already reached on the way are left out.
std::vector<Vec3> Generator::vertices(double braking_ratio, std::vector<std::size_t>* waypoint_vertices) const {
  std::vector<Vec3> out{start_ + velocity_ * windows_.half_s()};
  const double speed = velocity_.norm();
  if (braking_ratio > 0 && speed > 0) {
    const Vec3 direction = velocity_ / speed;
    const double braking = kBrakingShare * std::min(limits_.horizontal.acceleration, limits_.vertical_acceleration());
    const double length = braking_ratio * speed * speed / (2 * braking);
    if (length > kMinSegment_m) out.push_back(out.back() + direction * length);
  }
  const Polyline begin({start_ - Vec3(1e-6, 0, 0), out.back()});
  bool has_left = false;
  for (const HeadedPoint& waypoint : waypoints_) {
    const bool is_passed = !has_left && begin.distance(waypoint.position, 0, 0) < 0.5 * deviation_m_;
    const bool is_last = &waypoint == &waypoints_.back();
    has_left = has_left || !is_passed;
    if ((!is_passed || is_last) && (waypoint.position - out.back()).norm() > kMinSegment_m) {
      out.push_back(waypoint.position);
    }
    waypoint_vertices->push_back(out.size() - 1);
  }
  return out;
}

double Generator::corner_speed(const Polyline& path, std::size_t vertex) const {
  Vec3 before = vertex > 0 ? path.direction(vertex - 1) : velocity_;
  if (vertex == 0 && before.norm() > 1e-9) before.normalize();
  const Vec3 change = path.direction(vertex) - before;  // of velocity, per speed
  const double turn = 0.5 * change.norm();
  if (turn < 1e-6) return limits_.horizontal.speed + limits_.ascending.speed + velocity_.norm();
  const double budget = kCornerShare * windows_.width_s();
  const double horizontal = budget * limits_.horizontal.acceleration / std::max(change.head<2>().norm(), 1e-9);
  const double vertical = budget * limits_.vertical_acceleration() / std::max(std::abs(change.z()), 1e-9);
  return std::min({deviation_m_ / (turn * windows_.mean_s()), horizontal, vertical});
}

/// How far from each vertex its turn is felt: half a window at the speed of the corner, and accelerating from there.
std::vector<double> Generator::reserves(const Polyline& path) const {
  std::vector<double> out(path.vertices().size(), 0.0);
  const double half_s = 0.5 * windows_.width_s();
  for (std::size_t i = 1; i + 1 < out.size(); ++i) {
    if (path.turn(i) < kStraight) continue;
    const double speed = std::min(corner_speed(path, i), limits_.horizontal.speed);
    out[i] = half_s * (speed + 0.5 * half_s * limits_.horizontal.acceleration);
  }
  return out;
}

bool Generator::fly(const Polyline& path, const SpeedProfile& profile, Attempt* out) const {
  const auto half = static_cast<std::size_t>(windows_.steps());
  const auto max_samples = static_cast<std::size_t>(config_.max_duration_s / kFineStep_s);
  const auto samples = profile.sample(kFineStep_s, 2 * windows_.half_s(), max_samples);
  if (samples.empty()) return false;
  out->raw.clear();
  for (std::size_t i = 0; i < 2 * half; ++i) {
    const double t = (static_cast<double>(i) - static_cast<double>(half)) * kFineStep_s;
    out->raw.push_back({start_ + velocity_ * t, 0, 0});
  }
  out->raw.insert(out->raw.end(), samples.begin(), samples.end());
  out->raw.insert(out->raw.end(), 2 * half, {path.vertices().back(), path.num_segments() - 1, path.length_m()});
  std::vector<Vec3> positions;
  positions.reserve(out->raw.size());
  for (const auto& sample : out->raw) positions.push_back(sample.position);
  out->positions = moving_average(moving_average(positions, windows_.velocity_steps), windows_.acceleration_steps);
  return true;
}

/// Share of the present speed that would respect every limit, per sample of the attempt.
std::vector<double> Generator::check(const Polyline& path, Attempt* attempt) const {
  std::vector<double> ratios = limit_ratios(attempt->positions, limits_);
  const auto window = 2 * static_cast<std::size_t>(windows_.steps());
  const Polyline begin({start_ - Vec3(1e-6, 0, 0), path.vertices().front()});
  attempt->deviation_m = 0;
  for (std::size_t i = 0; i < attempt->positions.size(); ++i) {
    double distance = path.distance(attempt->positions[i], attempt->raw[i].segment, attempt->raw[i + window].segment);
    if (i < window) distance = std::min(distance, begin.distance(attempt->positions[i], 0, 0));
    attempt->deviation_m = std::max(attempt->deviation_m, distance);
    if (distance > deviation_m_) ratios[i] = std::min(ratios[i], deviation_m_ / distance);
  }
  // The corner itself must be met as well: there the cut is deeper than the distance to either line.
  for (std::size_t i = 0; i < attempt->positions.size(); ++i) {
    const SpeedProfile::Sample& centre = attempt->raw[i + window / 2];
    const SpeedProfile::Sample& next = attempt->raw[i + window / 2 + 1];
    if (next.segment == centre.segment) continue;
    const Vec3& corner = path.vertices()[next.segment];
    const double distance = (attempt->positions[i] - corner).norm();
    const double turn = path.turn(next.segment);
    if (turn > 1e-3 && distance > deviation_m_) ratios[i] = std::min(ratios[i], deviation_m_ / distance);
  }
  return ratios;
}

/// Lowers the speed wherever samples break a limit. False when there is nothing to lower.
bool Generator::slow_down(const std::vector<double>& ratios, const Attempt& attempt, SpeedProfile* profile) const {
  const auto window = 2 * static_cast<std::size_t>(windows_.steps());
  bool has_changed = false;
  for (std::size_t i = 0; i < ratios.size(); ++i) {
    if (ratios[i] >= 1 - kTolerance) continue;
    std::size_t last = i;
    double ratio = ratios[i];
    while (last + 1 < ratios.size() && ratios[last + 1] < 1 - kTolerance) ratio = std::min(ratio, ratios[++last]);
    profile->scale_caps(attempt.raw[i].arc_m, attempt.raw[last + window].arc_m, std::clamp(0.98 * ratio, 0.5, 0.97));
    has_changed = true;
    i = last;
  }
  return has_changed;
}

std::optional<Attempt> Generator::attempt(double braking_ratio, bool stop_everywhere, bool* is_too_long) const {
  Attempt out;
  const Polyline path(vertices(braking_ratio, &out.waypoint_vertices));
  if (path.vertices().size() < 2) {  // nothing to fly but the smoothing's own length
    const auto half = static_cast<std::size_t>(windows_.steps());
    if (velocity_.norm() > 1e-3) return std::nullopt;
    out.raw.assign(2 * half + 1, {path.vertices().front(), 0, 0});
    out.positions.assign(1, path.vertices().front());
    return out;
  }
  const double speed = velocity_.norm();
  if (speed > 1e-3 && braking_ratio < 1 && speed > corner_speed(path, 0)) return std::nullopt;
  SpeedProfile profile(path, limits_, reserves(path));
  for (std::size_t i = 1; i + 1 < path.vertices().size(); ++i) {
    profile.cap_vertex(i, stop_everywhere ? 0 : corner_speed(path, i));
  }
  if (request_.stop_at_waypoints) {
    for (const std::size_t vertex : out.waypoint_vertices) profile.cap_vertex(vertex, 0);
  }
  for (out.iterations = 1; out.iterations <= config_.max_iterations; ++out.iterations) {
    if (!profile.solve(speed)) return std::nullopt;
    if (!fly(path, profile, &out)) {
      *is_too_long = true;
      return std::nullopt;
    }
    const bool has_changed = slow_down(check(path, &out), out, &profile);
    if (!has_changed || stop_everywhere) return out;
  }
  return std::nullopt;
}

std::optional<Attempt> Generator::best_attempt(GeneratedTrajectory* out) const {
  bool is_too_long = false;
  const bool is_moving = velocity_.norm() > 1e-3;
  for (const double braking_ratio : {0.0, 0.25, 0.5, 0.75, 1.0}) {
    if (const auto result = attempt(braking_ratio, false, &is_too_long)) return result;
    if (is_too_long) return std::nullopt;
    if (!is_moving) break;
  }
  out->stops_at_corners = true;
  return attempt(1.0, true, &is_too_long);
}

/// Fine step at which each waypoint is nearest: averages are centred, so it is when the unsmoothed point is there.
std::vector<std::size_t> Generator::waypoint_steps(const Attempt& attempt, std::size_t offset) const {
  const auto half = static_cast<std::size_t>(windows_.steps());
  std::vector<std::size_t> out;
  std::size_t step = 0;
  for (const HeadedPoint& waypoint : waypoints_) {
    std::size_t best = step;
    const std::size_t vertex = attempt.waypoint_vertices[out.size()];
    for (std::size_t i = step; i < attempt.positions.size(); ++i) {
      if (attempt.raw[i + half].segment > vertex) break;
      if ((attempt.positions[i] - waypoint.position).norm() < (attempt.positions[best] - waypoint.position).norm())
        best = i;
    }
    step = best;
    out.push_back(best + offset);
  }
  return out;
}

void Generator::finish(const Attempt& attempt, GeneratedTrajectory* out) const {
  std::vector<Vec3> positions = lead_;
  positions.insert(positions.end(), attempt.positions.begin(), attempt.positions.end());
  const std::vector<std::size_t> steps = waypoint_steps(attempt, lead_.size());
  const std::vector<double> headings = heading_profile(request_, waypoints_, limits_.heading, steps, &positions);
  const auto stride = static_cast<std::size_t>(std::max(1.0, std::round(config_.sampling_s / kFineStep_s)));
  out->dt_s = static_cast<double>(stride) * kFineStep_s;
  for (std::size_t i = 0; i < positions.size() + stride - 1; i += stride) {
    const std::size_t k = std::min(i, positions.size() - 1);
    out->samples.push_back({positions[k], headings[k]});
  }
  for (const std::size_t step : steps)
    out->waypoint_samples.push_back(std::min((step + stride / 2) / stride, out->samples.size() - 1));
  out->duration_s = static_cast<double>(positions.size() - 1) * kFineStep_s;
  out->deviation_m = attempt.deviation_m;
  out->iterations = attempt.iterations;
  out->is_valid = true;
}

}  // namespace

GeneratedTrajectory generate_trajectory(const TrajectoryGeneratorConfig& config, const PathRequest& request) {
  // Wide windows take corners faster, narrow ones start and stop faster.
  GeneratedTrajectory wide = Generator(config, request, 1.0).run();
  if (!wide.is_valid) return wide;
  GeneratedTrajectory narrow = Generator(config, request, 0.2).run();
  if (!narrow.is_valid) return wide;
  return narrow.duration_s < wide.duration_s ? narrow : wide;
}

}  // namespace voxnav_simulation
