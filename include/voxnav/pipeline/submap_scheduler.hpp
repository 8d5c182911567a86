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
    v("max_distance_m", &C::max_distance_m, in(0.1, 10000.0), "m", "a submap closes after this distance travelled");
    v("min_period_s", &C::min_period_s, in(0.0, 3600.0), "s",
      "trouble with the poses closes a submap only if it is at least this old");
    v("max_poses", &C::max_poses, in(4, 1.0e6), "", "poses kept per submap; when full every other one is dropped");
    v("max_early_blocks", &C::max_early_blocks, in(1, 1.0e6), "",
      "blocks that left the window are handed over early once there are more of them");
  }
};

/// The content and the poses that the local map hands over for a submap (msg/Handover.msg).
struct Handover {
  std::uint32_t submap_id = 0;
  bool is_final = true;                               ///< false for early content of a submap that is still open
  std::string reason;                                 ///< time, distance, estimator, odometry, window, shutdown
  base::StampNs start_ns = 0;                         ///< stamp of the first scan
  base::StampNs stamp_ns = 0;                         ///< stamp of the newest scan
  geometry::Pose T_O_S = geometry::Pose::Identity();  ///< gravity-aligned
  std::vector<geometry::StampedPose> poses;           ///< T_S_B, rising stamps
  occupancy::MapContent content;                      ///< frame O
};

/// Decides when a submap closes and collects its content and poses. A submap opens with the first scan after the last
/// one closed. Not thread-safe.
class SubmapScheduler {
 public:
  /// @param first_id  id of the first submap; if not set, the seconds of its first stamp, so that a restarted node
  ///                  continues with unused ids (submaps are longer than a second)
  explicit SubmapScheduler(const SubmapSchedulerConfig& config, std::optional<std::uint32_t> first_id = 0);

  /// Adds a scan; to be called after each insertion. A scan that is not newer than the last one is ignored.
  /// @return why the open submap has to be closed now; nothing if it stays open
  std::optional<std::string> add_scan(base::StampNs stamp_ns, const geometry::Pose& T_O_B);
  /// Requests that the next add_scan() closes the open submap, because the odometry is in doubt. A submap younger than
  /// min_period_s is not closed.
  void request_close(const std::string& reason);
  /// Adds content that left the window while the submap is open.
  void add_evicted(const occupancy::MapContent& content);

  /// Combines the steps above for a map: adds a scan, takes the content that left the window of the map, and closes the
  /// submap with the content of the map if it is due. To be called after each insertion.
  /// @return handovers that are due, oldest first
  std::vector<Handover> add_scan(occupancy::LocalMap* map, base::StampNs stamp_ns, const geometry::Pose& T_O_B);
  /// Closes the open submap; to be called at the end of a run, and before or after the map is cleared.
  std::vector<Handover> finish(occupancy::LocalMap* map, const std::string& reason);

  bool is_open() const { return !poses_.empty(); }
  std::uint32_t submap_id() const { return submap_id_.value_or(0); }
  /// Returns a handover of early content, once there is more of it than max_early_blocks.
  std::optional<Handover> take_early();
  /// Closes the open submap with the content of the map and the content that left its window. Nothing if none is open.
  std::optional<Handover> close(const std::string& reason, occupancy::MapContent content);
  /// Forgets the open submap.
  void discard();

 private:
  Handover header(const std::string& reason, bool is_final) const;
  void keep_pose(base::StampNs stamp_ns, const geometry::Pose& T_O_B);

  SubmapSchedulerConfig config_;
  std::optional<std::uint32_t> submap_id_;  ///< not set before the first scan if the id follows from its stamp
  geometry::Pose T_O_S_ = geometry::Pose::Identity();
  std::vector<geometry::StampedPose> poses_;  ///< T_O_B
  geometry::StampedPose newest_;
  double distance_m_ = 0.0;
  std::string requested_;
  occupancy::MapContent evicted_;
};

}  // namespace voxnav::pipeline
