// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "graph/place.hpp"

namespace voxnav::graph {
namespace {

using geometry::Vec3;

constexpr double kSame_m = 0.6;        // horizontal distance below which two landmarks are taken for the same
constexpr double kSameHeight_m = 1.0;  // difference in height of their feet up to which they are
constexpr float kSideTolerance_m = 0.5f;
constexpr double kVoteCell_m = 1.0;
constexpr double kVoteCell_rad = 0.1;
constexpr int kHypotheses = 12;
constexpr int kMinLandmarks = 6;
constexpr double kMinShare = 0.3;      // minimum share of the landmarks of the place that has fewer
constexpr double kMaxRunnerUp = 0.75;  // a second pose with more than this share of the best makes a match ambiguous

using Pairing = std::vector<std::pair<int, int>>;  // landmarks of A and B taken for the same

/// Returns the relative pose with the least sum of squared distances between paired landmarks.
Pose4 fit(const Place& a, const Place& b, const Pairing& pairs) {
  Vec3 mean_a = Vec3::Zero();
  Vec3 mean_b = Vec3::Zero();
  for (const auto& [i, j] : pairs) {
    mean_a += a.landmarks_S[static_cast<std::size_t>(i)];
    mean_b += b.landmarks_S[static_cast<std::size_t>(j)];
  }
  mean_a /= static_cast<double>(pairs.size());
  mean_b /= static_cast<double>(pairs.size());
  double dot = 0.0;
  double cross = 0.0;
  for (const auto& [i, j] : pairs) {
    const Vec3 u = a.landmarks_S[static_cast<std::size_t>(i)] - mean_a;
    const Vec3 v = b.landmarks_S[static_cast<std::size_t>(j)] - mean_b;
    dot += v.x() * u.x() + v.y() * u.y();
    cross += v.x() * u.y() - v.y() * u.x();
  }
  Pose4 out(0.0, 0.0, 0.0, std::atan2(cross, dot));
  out.head<3>() = mean_a - to_pose(out) * mean_b;
  return out;
}

/// Pairs the landmarks of B that fall on one of A, each of A at most once. O(landmarks²).
Pairing pairs_at(const Place& a, const Place& b, const Pose4& T_A_B) {
  const geometry::Pose T = to_pose(T_A_B);
  Pairing out;
  std::vector<bool> is_taken(a.landmarks_S.size(), false);
  for (std::size_t j = 0; j < b.landmarks_S.size(); ++j) {
    const Vec3 p = T * b.landmarks_S[j];
    double nearest_m = kSame_m;
    int best = -1;
    for (std::size_t i = 0; i < a.landmarks_S.size(); ++i) {
      const Vec3 d = a.landmarks_S[i] - p;
      if (is_taken[i] || std::abs(d.z()) > kSameHeight_m || d.head<2>().norm() >= nearest_m) continue;
      nearest_m = d.head<2>().norm();
      best = static_cast<int>(i);
    }
    if (best < 0) continue;
    is_taken[static_cast<std::size_t>(best)] = true;
    out.emplace_back(best, static_cast<int>(j));
  }
  return out;
}

bool have_same_sides(const LandmarkTriangle& a, const LandmarkTriangle& b) {
  for (int k = 0; k < 3; ++k) {
    if (std::abs(a.sides_m[k] - b.sides_m[k]) > kSideTolerance_m) return false;
  }
  return a.is_left == b.is_left;
}

struct Vote {
  int count = 0;
  Pose4 T_A_B;
};

/// Returns the relative poses at which triangles of the same shape coincide, those with most triangles first.
std::vector<Pose4> hypotheses(const Place& a, const Place& b) {
  std::unordered_map<std::uint32_t, std::vector<const LandmarkTriangle*>> table;
  for (const LandmarkTriangle& triangle : a.triangles) table[triangle_key(triangle)].push_back(&triangle);
  Vec3 center_b = Vec3::Zero();
  for (const Vec3& p : b.landmarks_S) center_b += p / static_cast<double>(b.landmarks_S.size());
  std::map<std::array<int, 3>, Vote> votes;
  for (const LandmarkTriangle& triangle : b.triangles) {
    for (int step = 0; step < 27; ++step) {
      const auto found = table.find(triangle_key(triangle, step % 3 - 1, step / 3 % 3 - 1, step / 9 - 1));
      if (found == table.end()) continue;
      for (const LandmarkTriangle* other : found->second) {
        if (!have_same_sides(*other, triangle)) continue;
        Pairing pairs;
        for (int k = 0; k < 3; ++k) pairs.emplace_back(other->vertices[k], triangle.vertices[k]);
        const Pose4 T_A_B = fit(a, b, pairs);
        const Vec3 at = to_pose(T_A_B) * center_b;  // an error of yaw moves the centre less than the origin of B
        Vote& vote = votes[{static_cast<int>(std::floor(at.x() / kVoteCell_m)),
                            static_cast<int>(std::floor(at.y() / kVoteCell_m)),
                            static_cast<int>(std::floor(T_A_B[3] / kVoteCell_rad))}];
        if (vote.count++ == 0) vote.T_A_B = T_A_B;
      }
    }
  }
  std::vector<const Vote*> order;
  order.reserve(votes.size());
  for (const auto& entry : votes) order.push_back(&entry.second);
  std::stable_sort(order.begin(), order.end(), [](const Vote* l, const Vote* r) { return l->count > r->count; });
  std::vector<Pose4> out;
  for (const Vote* vote : order) {
    if (out.size() < kHypotheses) out.push_back(vote->T_A_B);
  }
  return out;
}

PlaceMatch refined(const Place& a, const Place& b, const Pose4& T_A_B) {
  constexpr int kRounds = 3;
  PlaceMatch out{T_A_B, 0};
  for (int round = 0; round < kRounds; ++round) {
    const Pairing pairs = pairs_at(a, b, out.T_A_B);
    if (static_cast<int>(pairs.size()) <= out.num_landmarks) break;
    out.num_landmarks = static_cast<int>(pairs.size());
    if (pairs.size() >= 3) out.T_A_B = fit(a, b, pairs);
  }
  return out;
}

bool is_another(const Pose4& l, const Pose4& r) {
  constexpr double kApart_m = 2.0;
  constexpr double kApart_rad = 0.15;
  return (l - r).head<2>().norm() > kApart_m || std::abs(geometry::wrap_angle(l[3] - r[3])) > kApart_rad;
}

}  // namespace

std::optional<PlaceMatch> match_places(const Place& a, const Place& b) {
  std::vector<PlaceMatch> found;
  for (const Pose4& T_A_B : hypotheses(a, b)) found.push_back(refined(a, b, T_A_B));
  if (found.empty()) return std::nullopt;
  const PlaceMatch best = *std::max_element(found.begin(), found.end(), [](const PlaceMatch& l, const PlaceMatch& r) {
    return l.num_landmarks < r.num_landmarks;
  });
  const auto fewer = static_cast<double>(std::min(a.landmarks_S.size(), b.landmarks_S.size()));
  if (best.num_landmarks < kMinLandmarks || best.num_landmarks < kMinShare * fewer) return std::nullopt;
  for (const PlaceMatch& other : found) {
    const bool is_rival = other.num_landmarks > kMaxRunnerUp * best.num_landmarks;
    if (is_rival && is_another(other.T_A_B, best.T_A_B)) return std::nullopt;
  }
  return best;
}

}  // namespace voxnav::graph
