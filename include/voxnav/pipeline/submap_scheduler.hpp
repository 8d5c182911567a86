// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "voxnav/base/config.hpp"
#include "voxnav/geometry/pose.hpp"
#include "voxnav/occupancy/local_map.hpp"

namespace voxnav::pipeline {

struct SubmapSchedulerConfig {
  double period_s = 10.0;
  double max_distance_m = 50.0;
  double min_period_s = 1.0;
  int max_poses = 2000;
  int max_early_blocks = 1024;

  template <class V>
  static void fields(V&& v) {
    using C = SubmapSchedulerConfig;
    using base::in;
    v("period_s", &C::period_s, in(0.1, 3600.0), "s", "a submap closes after this time");
    v("max_distance_m", &C::max_distance_m, in(0.1, 10000.0), "m", "or after this way travelled");
    v("min_period_s", &C::min_period_s, in(0.0, 3600.0), "s",
      "trouble closes a submap only if it is at least this old");
    v("max_poses", &C::max_poses, in(4, 1.0e6), "", "poses kept per submap; when full every other one is dropped");
    v("max_early_blocks", &C::max_early_blocks, in(1, 1.0e6), "",
      "blocks that left the window are handed over early once there are more of them");
  }
};

/// What the local map hands to the global map (msg/Handover.msg).
struct Handover {
  std::uint32_t submap_id = 0;
  bool is_final = true;                               ///< false: early content of a submap that is still open
  std::string reason;                                 ///< time, distance, estimator, odometry, window, shutdown
  base::StampNs start_ns = 0;                         ///< first scan inside
  base::StampNs stamp_ns = 0;                         ///< newest scan inside
  geometry::Pose T_O_S = geometry::Pose::Identity();  ///< gravity-aligned
  std::vector<geometry::StampedPose> poses;           ///< T_S_B, rising stamps
  occupancy::MapContent content;                      ///< frame O
};

/// Decides when a submap closes and gathers what belongs to it. A submap opens with the first scan after the last
/// one closed. Not thread-safe.
class SubmapScheduler {
 public:
  /// @param first_id of the first submap; none = the seconds of its first stamp, so that a restarted node goes on
  ///        with ids that nobody has seen yet (submaps are longer than a second)
  explicit SubmapScheduler(const SubmapSchedulerConfig& config, std::optional<std::uint32_t> first_id = 0);

  /// Call after each inserted scan. A scan that is not newer than the last one is ignored.
  /// @return why the open submap is to be closed now, nothing if it stays open
  std::optional<std::string> add_scan(base::StampNs stamp_ns, const geometry::Pose& T_O_B);
  /// The odometry is in doubt: the next add_scan() closes, unless the submap is younger than min_period_s.
  void request_close(const std::string& reason);
  /// Content that left the window while the submap is open.
  void add_evicted(const occupancy::MapContent& content);

  /// The two steps above with a map, as nodes and the offline runner use them: takes what left its window, and closes
  /// over its content when due. Call after each insertion.
  /// @return what is to be handed over now, oldest first
  std::vector<Handover> add_scan(occupancy::LocalMap* map, base::StampNs stamp_ns, const geometry::Pose& T_O_B);
  /// Closes what is open, at the end of a run, before the map is cleared, or after it was.
  std::vector<Handover> finish(occupancy::LocalMap* map, const std::string& reason);

  bool is_open() const { return !poses_.empty(); }
  std::uint32_t submap_id() const { return submap_id_.value_or(0); }
  /// Early content, once there is more of it than max_early_blocks.
  std::optional<Handover> take_early();
  /// Closes the open submap over the map's content, to which what left the window is added. Nothing if none is open.
  std::optional<Handover> close(const std::string& reason, occupancy::MapContent content);
  /// Forgets the open submap.
  void discard();

 private:
  Handover header(const std::string& reason, bool is_final) const;
  void keep_pose(base::StampNs stamp_ns, const geometry::Pose& T_O_B);

  SubmapSchedulerConfig config_;
  std::optional<std::uint32_t> submap_id_;  ///< none before the first scan, if the stamp is to give it
  geometry::Pose T_O_S_ = geometry::Pose::Identity();
  std::vector<geometry::StampedPose> poses_;  ///< T_O_B
  geometry::StampedPose newest_;
  double distance_m_ = 0.0;
  std::string requested_;
  occupancy::MapContent evicted_;
};

}  // namespace voxnav::pipeline
