// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "voxnav/cloud/sweep.hpp"
#include "voxnav/pipeline/deskew.hpp"

namespace voxnav::geometry {
class PoseBuffer;
}

namespace voxnav::pipeline {

/// Where sensor and body were during a sweep.
struct SweepPoses {
  SweepMotion motion;                                 ///< duration 0: the sweep is taken to be seen from one place
  geometry::Pose T_O_B = geometry::Pose::Identity();  ///< halfway through the sweep
};

/// What is known of a sweep's poses. Nothing is ever assumed about a pose.
struct SweepLocation {
  enum class Status {
    kKnown,
    kNotYet,  ///< a later pose may tell
    kNever,   ///< every later pose is too late for it
  };
  Status status = Status::kNotYet;
  SweepPoses poses;     ///< if known
  std::string problem;  ///< why they are not known
};

/// Tells poses of sweeps, from whatever source.
class SweepLocator {
 public:
  virtual ~SweepLocator() = default;
  /// @param duration_ns  of the motion that is asked for; 0 = as if the whole sweep were taken at its start
  virtual SweepLocation locate(const cloud::Sweep& sweep, std::uint32_t duration_ns) const = 0;
};

/// Locates the sweeps of one sensor by stamped poses of the body on which it is mounted.
class PoseLocator final : public SweepLocator {
 public:
  PoseLocator();
  ~PoseLocator() override;
  PoseLocator(PoseLocator&&) noexcept;
  PoseLocator& operator=(PoseLocator&&) noexcept;

  void set_mount(const geometry::Pose& T_B_L) { T_B_L_ = T_B_L; }
  /// @return false for a pose that is refused: late, alone on another clock, or not rigid
  bool add(base::StampNs stamp_ns, const geometry::Pose& T_O_B);
  SweepLocation locate(const cloud::Sweep& sweep, std::uint32_t duration_ns) const override;

 private:
  std::unique_ptr<geometry::PoseBuffer> poses_;
  std::optional<geometry::Pose> T_B_L_;
};

}  // namespace voxnav::pipeline
