// SPDX-License-Identifier: BSD-3-Clause
#include <cstdio>

#include "planning/sightings.hpp"
#include "voxnav/pipeline/planning_manager.hpp"
#include "voxnav/planning/corridor.hpp"

namespace voxnav::pipeline {
namespace {

using geometry::Vec3;
using planning::Sightings;
using planning::Trajectory;

/// The next sweep shows by this time whether a lone return was something.
constexpr double kNextSweep_s = 0.2;
/// Where something moves, stops are tried that are shorter by this from one to the next.
constexpr double kShorter_m = 0.25;

/// How far a trajectory may be flown.
struct Room {
  double length_m;   ///< from where the vehicle is to where it has to rest
  std::string text;  ///< what is there, for a person
};

std::string place_text(const planning::CorridorResult& corridor) {
  char buffer[160];
  const Vec3& p = corridor.unsafe_point;
  std::snprintf(buffer, sizeof buffer, "%s%s in %.1f m at (%.1f, %.1f, %.1f)",
                corridor.fence ? "" : "not known free: ", what_is_unsafe(corridor), corridor.first_unsafe_m, p.x(),
                p.y(), p.z());
  return buffer;
}

std::string distance_text(const char* format, double distance_m) {
  char buffer[120];
  std::snprintf(buffer, sizeof buffer, format, distance_m);
  return buffer;
}

std::string what_is_met(const planning::Meeting& meeting) {
  const std::string what = meeting.name.empty() ? "something that moves" : meeting.name;
  return "not free: " + what + distance_text(" is met in %.1f m", meeting.arc_m);
}

/// Checks and cuts one trajectory.
class Checker {
 public:
  Checker(const PlanningManagerConfig& config, const planning::OccupancyView& view, const FlownTrajectory& flown)
      : config_(config), view_(view), flown_(flown), sightings_(view.sightings()) {
    if (sightings_ != nullptr) begin_ns_ = flown.now_ns.value_or(sightings_->stamp_ns);
  }

  std::optional<Room> room() const {
    std::optional<Room> out = room_in_corridor();
    for (std::optional<Room> other : {room_to_lone_hit(), room_to_meeting(flown_.trajectory, flown_.from_arc_m)}) {
      if (other && (!out || other->length_m < out->length_m)) out = std::move(other);
    }
    return out;
  }

  /// Returns the trajectory braked to rest within some room; nothing if that is too short.
  std::optional<Trajectory> stopped_in(double room_m) const {
    while (room_m >= stopping_m(room_m)) {
      auto out = flown_.trajectory.stopped_at(flown_.from_arc_m, flown_.from_arc_m + room_m, deceleration(room_m));
      if (!out || !room_to_meeting(*out, 0.0)) return out;
      room_m -= kShorter_m;
    }
    return std::nullopt;
  }

 private:
  std::optional<Room> room_in_corridor() const {
    const std::vector<Vec3> line = flown_.trajectory.points_from_arc(flown_.from_arc_m);
    const auto corridor = check_corridor(view_, line, flown_.radius_m);
    if (corridor.is_safe) return std::nullopt;
    return Room{corridor.first_unsafe_m - config_.stop_margin_m, place_text(corridor)};
  }

  std::optional<Room> room_to_lone_hit() const {
    if (sightings_ == nullptr || sightings_->lone_hits.empty()) return std::nullopt;
    const std::vector<Vec3> line = flown_.trajectory.points_from_arc(flown_.from_arc_m);
    const auto touch_m = planning::first_touch_m(line, flown_.radius_m, sightings_->lone_hits, view_.resolution_m());
    if (!touch_m) return std::nullopt;
    const double room_m = *touch_m - config_.stop_margin_m;
    if (room_m >= stopping_m(room_m) + kNextSweep_s * flown_.velocity_O.norm()) return std::nullopt;
    return Room{room_m, distance_text("not known free: a return in %.1f m", *touch_m)};
  }

  std::optional<Room> room_to_meeting(const Trajectory& trajectory, double from_arc_m) const {
    if (sightings_ == nullptr || sightings_->has_nothing_to_meet()) return std::nullopt;
    const auto meeting =
        planning::first_meeting(*sightings_, planning::timed_line(trajectory, from_arc_m), begin_ns_, flown_.radius_m);
    if (!meeting) return std::nullopt;
    return Room{meeting->arc_m - config_.stop_margin_m, what_is_met(*meeting)};
  }

  double deceleration(double room_m) const {
    return config_.deceleration_ratio * planning::braking_deceleration(flown_.trajectory, flown_.from_arc_m,
                                                                       flown_.from_arc_m + room_m, flown_.velocity_O,
                                                                       flown_.limits);
  }
  double stopping_m(double room_m) const {
    return planning::stopping_distance(flown_.velocity_O.norm(), deceleration(room_m), config_.reaction_time_s);
  }

  const PlanningManagerConfig& config_;
  const planning::OccupancyView& view_;
  const FlownTrajectory& flown_;
  const Sightings* sightings_;
  base::StampNs begin_ns_ = 0;
};

}  // namespace

std::optional<PlaceOfMeeting> place_of_meeting(const planning::OccupancyView& view, const Trajectory& trajectory,
                                               base::StampNs now_ns, double radius_m) {
  if (view.sightings() == nullptr || trajectory.empty()) return std::nullopt;
  const auto meeting =
      planning::first_meeting(*view.sightings(), planning::timed_line(trajectory, 0.0), now_ns, radius_m);
  if (!meeting) return std::nullopt;
  return PlaceOfMeeting{meeting->arc_m, meeting->after_s};
}

SafePart safe_part(const PlanningManagerConfig& config, const planning::OccupancyView& view,
                   const FlownTrajectory& flown) {
  const Checker checker(config, view, flown);
  std::optional<Room> room = checker.room();
  if (!room) return {flown.trajectory, {}};
  return {checker.stopped_in(room->length_m), std::move(room->text)};
}

}  // namespace voxnav::pipeline
