// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "voxnav/cloud/sweep.hpp"
#include "voxnav/geometry/points_view.hpp"

namespace voxnav::geometry {
class PoseBuffer;
}

namespace voxnav::pipeline {

/// Motion of the sensor during one sweep.
struct SweepMotion {
  geometry::Pose T_O_L_start = geometry::Pose::Identity();  ///< at time offset 0
  geometry::Pose T_O_L_end = geometry::Pose::Identity();    ///< at time offset duration_ns
  std::uint32_t duration_ns = 0;
};

/// Returns the pose of the sensor halfway through the sweep.
geometry::Pose middle_of(const SweepMotion& motion);

/// Deskews points in place: moves each point from the sensor frame at its own time to the sensor frame halfway through
/// the sweep. The motion is interpolated linearly in position and by slerp in rotation, in kDeskewSteps steps. Points
/// that are not finite stay so. O(points).
/// @param time_offsets_ns  time of each point after the start of the sweep
/// @throws std::invalid_argument if there are not as many times as points
void deskew(const geometry::MutablePointsView& points, const std::vector<std::uint32_t>& time_offsets_ns,
            const SweepMotion& motion);
constexpr int kDeskewSteps = 64;

/// The poses of sensor and body during a sweep.
struct SweepPoses {
  SweepMotion motion;                                 ///< motion of the sensor; with duration 0 it stood still
  geometry::Pose T_O_B = geometry::Pose::Identity();  ///< pose of the body halfway through the sweep
};

/// The poses of a sweep, or why they are not known. A pose that is not known is never assumed.
struct SweepLocation {
  enum class Status {
    kKnown,
    kNotYet,  ///< a later pose may make them known
    kNever,   ///< all later poses are too late for them
  };
  Status status = Status::kNotYet;
  SweepPoses poses;     ///< if known: the poses
  std::string problem;  ///< if not known: why
};

/// The interface of a source of poses of sweeps.
class SweepLocator {
 public:
  virtual ~SweepLocator() = default;
  /// Returns the poses of a sweep.
  /// @param duration_ns  duration of the sweep; 0 = the whole sweep is taken to be seen at its start
  virtual SweepLocation locate(const cloud::Sweep& sweep, std::uint32_t duration_ns) const = 0;
};

/// Locates sweeps by stamped poses of the body on which their sensors are mounted.
class PoseLocator final : public SweepLocator {
 public:
  PoseLocator();
  ~PoseLocator() override;
  PoseLocator(PoseLocator&&) noexcept;
  PoseLocator& operator=(PoseLocator&&) noexcept;

  /// @param sensor  see cloud::Sweep::sensor
  void set_mount(const geometry::Pose& T_B_L, std::size_t sensor = 0);
  /// Poses farther apart than this do not tell where the body was between them; without a limit all do.
  void set_max_gap(std::optional<base::StampNs> max_gap_ns);
  /// @return false for a pose that is refused: late, alone on another clock, or not rigid
  bool add(base::StampNs stamp_ns, const geometry::Pose& T_O_B);
  /// Gives all poses in another frame.
  void move_frame(const geometry::Pose& T_new_O);
  SweepLocation locate(const cloud::Sweep& sweep, std::uint32_t duration_ns) const override;

 private:
  std::unique_ptr<geometry::PoseBuffer> poses_;
  std::map<std::size_t, geometry::Pose> mounts_;  // T_B_L of each sensor whose mount is known
};

}  // namespace voxnav::pipeline
