// SPDX-License-Identifier: BSD-3-Clause
#include "planning/path/shorten.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace voxnav::planning {

using geometry::Vec3;

namespace {

constexpr double kTolerance = 1e-9;
constexpr double kLeastGain = 5e-4;
constexpr int kMaxRounds = 12;
constexpr int kBisections = 5;
constexpr double kShortestPull = 1.0 / 32.0;
/// Cutting a corner that gains less than this share of a voxel edge is not worth a turn more.
constexpr double kLeastCut = 0.01;
/// A turn that moved by less [voxel edges] has come to rest.
constexpr double kLeastMove = 0.02;

}  // namespace

std::vector<Vec3> PathShortening::run(const std::vector<Vec3>& sights) {
  make_clear(sights);
  leave_out();
  for (round_ = 1; round_ <= kMaxRounds && !is_spent(); ++round_) {
    const double before = total();
    for (std::size_t i = 1; i + 1 < turns_.size() && !is_spent(); ++i) {
      if (is_in_motion(i) && pull(i)) --i;
    }
    for (std::size_t i = 1; i + 1 < turns_.size() && !is_spent(); ++i) {
      if (is_in_motion(i) && cut_corner(i)) ++i;
    }
    if (total() > before * (1.0 - kLeastGain)) break;
  }
  leave_out();
  std::vector<Vec3> out;
  for (const Turn& turn : turns_) out.push_back(turn.point);
  return out;
}

double PathShortening::cost_of(const std::vector<Vec3>& path) {
  double out = 0.0;
  for (std::size_t i = 1; i < path.size(); ++i) {
    out += sight_cost(&graph_, path[i - 1], path[i], SightRule::kExactlyClear)
               .value_or(std::numeric_limits<double>::infinity());
  }
  return out;
}

std::optional<double> PathShortening::segment_cost(const Vec3& from, const Vec3& to) {
  if (!clearance_.is_clear(from, to) || !clearance_.is_known(from, to)) return std::nullopt;
  return sight_cost(&graph_, from, to, SightRule::kExactlyClear);
}

/// Lines of sight that are not exactly clear become ways over cells.
void PathShortening::make_clear(const std::vector<Vec3>& sights) {
  turns_ = {{sights.front(), 0.0}};
  for (std::size_t i = 1; i < sights.size(); ++i) {
    const auto cost = segment_cost(sights[i - 1], sights[i]);
    if (cost) {
      turns_.push_back({sights[i], *cost});
      continue;
    }
    const std::vector<Vec3> cells = cells_along(sights[i - 1], sights[i]);
    for (std::size_t k = 1; k < cells.size(); ++k) {
      const auto step = sight_cost(&graph_, cells[k - 1], cells[k], SightRule::kExactlyClear);
      turns_.push_back({cells[k], step.value_or((cells[k] - cells[k - 1]).norm())});
    }
  }
}

/// Leaves out turns: the farthest point to which a straight line may lead is found by doubling and bisection.
void PathShortening::leave_out() {
  std::vector<double> cost_to(turns_.size(), 0.0);
  for (std::size_t i = 1; i < turns_.size(); ++i) cost_to[i] = cost_to[i - 1] + turns_[i].cost;
  std::vector<Turn> kept = {turns_.front()};
  for (std::size_t at = 0; at + 1 < turns_.size();) {
    std::size_t good = at + 1, stride = 1;
    double good_cost = turns_[good].cost;
    const auto reaches = [&](std::size_t to) {
      if (is_spent()) return false;
      const auto cost = segment_cost(turns_[at].point, turns_[to].point);
      if (!cost || *cost > cost_to[to] - cost_to[at] + kTolerance) return false;
      good = to;
      good_cost = *cost;
      return true;
    };
    while (good + stride < turns_.size() && reaches(good + stride)) stride *= 2;
    std::size_t bad = std::min(turns_.size(), good + stride);
    while (bad - good > 1) {
      const std::size_t middle = (good + bad) / 2;
      if (!reaches(middle)) bad = middle;
    }
    kept.push_back({turns_[good].point, good_cost});
    at = good;
  }
  turns_ = std::move(kept);
}

bool PathShortening::replace(std::size_t at, const Vec3& point) {
  const auto to = segment_cost(turns_[at - 1].point, point);
  if (!to) return false;
  const auto from = segment_cost(point, turns_[at + 1].point);
  if (!from || *to + *from > turns_[at].cost + turns_[at + 1].cost - kTolerance) return false;
  turns_[at].point = point;
  turns_[at].cost = *to;
  turns_[at + 1].cost = *from;
  return true;
}

/// Notes that a turn has changed: what was tried in vain with it, or with those beside it, may succeed now.
void PathShortening::touch(std::size_t at) {
  for (std::size_t i = at == 0 ? 0 : at - 1; i <= at + 1 && i < turns_.size(); ++i) turns_[i].changed = round_;
}

/// Pulls a turn towards the line between its neighbours; returns true if it was left out.
bool PathShortening::pull(std::size_t at) {
  const Vec3 a = turns_[at - 1].point, b = turns_[at + 1].point, turn = turns_[at].point;
  const auto cost = segment_cost(a, b);
  if (cost && *cost <= turns_[at].cost + turns_[at + 1].cost + kTolerance) {
    turns_[at + 1].cost = *cost;
    turns_.erase(turns_.begin() + static_cast<std::ptrdiff_t>(at));
    touch(at - 1);
    touch(at);
    return true;
  }
  const double before = (turn - a).norm(), after = (b - turn).norm();
  const Vec3 aim = a + (b - a) * (before / std::max(before + after, kTolerance));
  // Most turns lie at an obstacle already, where not even the shortest step leads on.
  double low = kShortestPull, high = 1.0;
  if (!replace(at, turn + (aim - turn) * low)) return false;
  for (int i = 0; i < kBisections; ++i) {
    const double middle = 0.5 * (low + high);
    (replace(at, turn + (aim - turn) * middle) ? low : high) = middle;
  }
  if ((turns_[at].point - turn).norm() > kLeastMove) touch(at);
  return false;
}

/// Replaces a turn by two on the segments beside it; returns true if there is one turn more.
bool PathShortening::cut_corner(std::size_t at) {
  const Vec3 a = turns_[at - 1].point, b = turns_[at + 1].point, turn = turns_[at].point;
  const double before = (turn - a).norm(), after = (b - turn).norm();
  const Vec3 u = (a - turn) / std::max(before, kTolerance), v = (b - turn) / std::max(after, kTolerance);
  for (double side = 0.5 * std::min(before, after); side * (2.0 - (u - v).norm()) > kLeastCut; side *= 0.5) {
    if (is_spent()) return false;
    const Vec3 first = turn + side * u, second = turn + side * v;
    const auto chord = segment_cost(first, second);
    if (!chord) continue;
    const auto to = segment_cost(a, first), from = segment_cost(second, b);
    if (!to || !from || *to + *chord + *from > turns_[at].cost + turns_[at + 1].cost - kTolerance) return false;
    turns_[at + 1].cost = *from;
    turns_[at] = {second, *chord};
    turns_.insert(turns_.begin() + static_cast<std::ptrdiff_t>(at), {first, *to});
    touch(at);
    touch(at + 1);
    return true;
  }
  return false;
}

double PathShortening::total() const {
  double out = 0.0;
  for (const Turn& turn : turns_) out += turn.cost;
  return out;
}

}  // namespace voxnav::planning
