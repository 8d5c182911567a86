// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav_simulation/visitors.hpp"

#include <algorithm>

namespace voxnav_simulation {
namespace {

using voxnav::base::StampNs;
using voxnav::base::to_seconds;

/// Places come 100 times a second; older ones than of the last second or so are not asked for.
constexpr std::size_t kMaxPlaces = 128;
/// A visitor is believed to fly on for this long after its last place.
constexpr double kMaxAhead_s = 0.3;

Vec3 middle_at(const std::vector<std::pair<StampNs, Vec3>>& places, StampNs stamp_ns) {
  if (places.size() == 1 || stamp_ns <= places.front().first) return places.front().second;
  const auto after = std::upper_bound(places.begin() + 1, places.end() - 1, stamp_ns,
                                      [](StampNs stamp, const auto& place) { return stamp < place.first; });
  const auto& [from_ns, from] = *(after - 1);
  const auto& [to_ns, to] = *after;
  const double length_s = to_seconds(to_ns - from_ns);
  const double share = std::min(to_seconds(stamp_ns - from_ns), length_s + kMaxAhead_s) / length_s;
  return from + share * (to - from);
}

}  // namespace

void Visitors::note(const std::string& name, StampNs stamp_ns, const Vec3& middle) {
  if (!middle.allFinite()) return;
  const std::lock_guard<std::mutex> lock(mutex_);
  Places& places = places_[name];
  if (!places.empty() && stamp_ns <= places.back().first) places.clear();
  if (places.size() == kMaxPlaces) places.erase(places.begin(), places.begin() + kMaxPlaces / 2);
  places.emplace_back(stamp_ns, middle);
}

std::vector<std::pair<const Mover*, Vec3>> Visitors::at(StampNs stamp_ns) const {
  static const Mover kShape = flyer();
  const std::lock_guard<std::mutex> lock(mutex_);
  std::vector<std::pair<const Mover*, Vec3>> out;
  for (const auto& [name, places] : places_) {
    out.emplace_back(&kShape, middle_at(places, stamp_ns) - Vec3(0, 0, 0.5 * kShape.height_m));
  }
  return out;
}

}  // namespace voxnav_simulation
