// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "voxnav/occupancy/local_map.hpp"
#include "voxnav/odometry/lidar_odometry.hpp"
#include "voxnav/pipeline/mapper_config.hpp"
#include "voxnav/pipeline/sweep_locator.hpp"

namespace voxnav::pipeline {

enum class SweepFate : std::uint8_t {
  kMapped,
  kNoPose,   ///< no pose came, or none ever can
  kCrowded,  ///< too many sweeps waited for their pose
  kLate,     ///< newer ones are in the map already
};

constexpr auto words_of(SweepFate) { return std::array{"mapped", "no_pose", "crowded", "late"}; }

/// What became of one sweep.
struct MapperStep {
  SweepFate fate = SweepFate::kMapped;
  std::string reason;                                 ///< a sentence, unless it was mapped
  base::StampNs stamp_ns = 0;                         ///< of the sweep's message
  std::optional<std::string> map_cleared;             ///< why the map was cleared before it, a sentence; if it was
  geometry::Pose T_O_B = geometry::Pose::Identity();  ///< halfway through the sweep; if mapped
  occupancy::InsertStatistics statistics;             ///< if mapped
  std::vector<Handover> handovers;                    ///< of the submap that was closed before the map was cleared
};

/// The one mapping pipeline: filtered sweeps in, local map and handovers out. Sweeps wait, in order, until their poses
/// are known; then they are thinned out if there is too little time, deskewed, and inserted into the local map, over
/// which submaps are closed. Results depend on what is added and in which order, on nothing else: the core reads no
/// clock. Not thread-safe.
class Mapper {
 public:
  /// @param T_B_L    LiDAR on the body, for poses that are added here
  /// @param locator  tells poses instead; must outlive the mapper
  /// @throws base::ConfigError
  explicit Mapper(const MapperConfig& config, const geometry::Pose& T_B_L = geometry::Pose::Identity(),
                  const SweepLocator* locator = nullptr);
  ~Mapper();

  /// For the mapper's own LiDAR odometry.
  void add_imu(const odometry::ImuSample& sample);
  /// @return false for a pose that is refused: late, alone on another clock, or not rigid
  bool add_pose(base::StampNs stamp_ns, const geometry::Pose& T_O_B);
  /// Lets a sweep wait for its poses.
  /// @param poses  when they are known already
  /// @param now_s  by any clock, see drop_overdue()
  void add_sweep(cloud::Sweep sweep, const std::optional<SweepPoses>& poses = std::nullopt, double now_s = 0.0);
  /// Sweeps that have waited for their poses longer than this will be dropped by next().
  void drop_overdue(double now_s, double timeout_s);
  /// Nothing more will be added: sweeps that wait for IMU samples or poses are done without the ones, and dropped
  /// without the others, by next().
  void end_input();

  bool is_waiting_for_imu() const;
  /// Whether next() has something to do.
  bool has_next();
  /// Maps the oldest sweep, or tells why it is dropped. @throws std::logic_error unless has_next()
  MapperStep next();
  /// What is to be handed over after the sweep that next() mapped, oldest first.
  std::vector<Handover> close_due();
  /// Closes the open submap now, if there is one. @param reason see Handover
  std::vector<Handover> finish(const std::string& reason);
  /// The poses are in doubt: the next close_due() closes, unless the submap is too young.
  void request_close(const std::string& reason);
  /// Closes the open submap and forgets the map.
  std::vector<Handover> clear(const std::string& reason);

  /// How long the last sweep took, and the time since the one before: by these, load control thins out.
  void add_load(double work_s, double period_s);
  int decimation() const;

  occupancy::LocalMap& map();
  const occupancy::LocalMap& map() const;
  /// Stamp of the newest sweep in the map; none before the first.
  std::optional<base::StampNs> newest_stamp_ns() const;
  /// The mapper's own odometry, if it has one.
  const odometry::LidarOdometry* odometry() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace voxnav::pipeline
