// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "voxnav/containers/moving_thing.hpp"
#include "voxnav/occupancy/moving_things.hpp"
#include "voxnav/odometry/lidar_odometry.hpp"
#include "voxnav/pipeline/mapper_config.hpp"
#include "voxnav/pipeline/sweep_locator.hpp"

namespace voxnav::pipeline {

enum class SweepFate : std::uint8_t {
  kMapped,
  kNoPose,   ///< no pose came, or none can come any more
  kCrowded,  ///< too many sweeps waited for their pose
  kLate,     ///< newer sweeps are in the map already
  kSurplus,  ///< it came sooner than the rate that the configuration allows the sensor
};

constexpr auto words_of(SweepFate) { return std::array{"mapped", "no_pose", "crowded", "late", "surplus"}; }

/// The result of Mapper::next() for one sweep.
struct MapperStep {
  SweepFate fate = SweepFate::kMapped;
  std::string reason;          ///< if the sweep was not mapped: why, as a sentence
  base::StampNs stamp_ns = 0;  ///< stamp of the sweep's message
  std::size_t sensor = 0;      ///< number of the sensor of the sweep
  /// If mapped: whether the sweep is of the first sensor that delivers, whose sweeps set the pace of all that is done
  /// once per scan: poses of submaps, control of the load.
  bool leads = false;
  std::optional<std::string> map_cleared;             ///< if the map was cleared before the sweep: why, as a sentence
  geometry::Pose T_O_B = geometry::Pose::Identity();  ///< if mapped: pose halfway through the sweep
  occupancy::InsertStatistics statistics;             ///< if mapped: counts of the insertion
  std::vector<Handover> handovers;                    ///< handovers of a submap that closed before the map was cleared
};

/// The mapping pipeline, which nodes and the offline runner share: filtered sweeps go in, the local map and handovers
/// come out. Sweeps of one or several sensors wait until their poses are known, those of each sensor in order, and no
/// sensor for another; then they are thinned out if there is too little time, deskewed, and inserted into the local
/// map, whose content is handed over when a submap closes. Results depend on what is added and in which order, and on
/// nothing else: the core reads no clock. Not thread-safe.
class Mapper {
 public:
  /// @param T_B_L    pose of the first sensor on the body, for poses of the body that are added with add_pose()
  /// @param locator  source of poses instead of these; must outlive the mapper
  /// @throws base::ConfigError
  explicit Mapper(const MapperConfig& config, const geometry::Pose& T_B_L = geometry::Pose::Identity(),
                  const SweepLocator* locator = nullptr);
  ~Mapper();

  /// Sets the pose on the body of a sensor, without which its sweeps have no poses. @throws std::invalid_argument if
  /// the configuration has no such sensor
  void set_mount(std::size_t sensor, const geometry::Pose& T_B_L);
  /// Announces IMU samples: sweeps wait, up to 80 of them, until these have shown the direction of gravity. The map is
  /// then level from its beginning, even if the first samples come later than the first sweeps.
  void expect_imu();
  /// Adds a sample for the mapper's own LiDAR odometry.
  void add_imu(const odometry::ImuSample& sample);
  /// @return false for a pose that is refused: late, alone on another clock, or not rigid
  bool add_pose(base::StampNs stamp_ns, const geometry::Pose& T_O_B);
  /// Adds a sweep, which waits until its poses are known. The mapper's own odometry follows those of the first sensor.
  /// @param poses  poses of the sweep, if they are known already
  /// @param now_s  time of any clock, see drop_overdue()
  /// @throws std::invalid_argument if the configuration has no such sensor
  void add_sweep(cloud::Sweep sweep, const std::optional<SweepPoses>& poses = std::nullopt, double now_s = 0.0);
  /// Sets where the bodies of other UAVs are, frame O, with the radius of the ball in which each body is. They are not
  /// mapped in sweeps up to a second after this was known (OtherUav::seen_ns).
  /// @throws std::invalid_argument if one has no places, or a number that is not finite or negative
  void set_others(std::vector<containers::OtherUav> others);
  /// Marks sweeps that have waited too long for their poses by the time `now_s`; next() drops them.
  void drop_overdue(double now_s, double timeout_s);
  /// Ends the input. next() then processes sweeps that wait for IMU samples without these, and drops sweeps that wait
  /// for poses.
  void end_input();

  bool is_waiting_for_imu() const;
  /// Returns true if next() can be called.
  bool has_next();
  /// Maps the oldest sweep that is ready, or drops it with a reason. @throws std::logic_error unless has_next()
  MapperStep next();
  /// Returns the handovers that are due after the sweep that next() mapped, oldest first.
  std::vector<Handover> close_due();
  /// Closes the open submap now, if there is one. @param reason see Handover
  std::vector<Handover> finish(const std::string& reason);
  /// Requests that the next close_due() closes the open submap, because the poses are in doubt. A submap that is too
  /// young is not closed.
  void request_close(const std::string& reason);
  /// Closes the open submap and forgets the map.
  std::vector<Handover> clear(const std::string& reason);

  /// Reports the duration of the work on all sweeps since the last one that led, and the time since then, to load
  /// control.
  void add_load(double work_s, double period_s);
  int decimation() const;

  occupancy::LocalMap& map();
  const occupancy::LocalMap& map() const;
  /// What moves in the map, as of the newest sweep.
  const occupancy::MovingThings& moving() const;
  /// The stamp of the newest sweep in the map; nothing before the first.
  std::optional<base::StampNs> newest_stamp_ns() const;
  /// Returns what is wrong with the IMU samples and the frame of the mapper's own odometry, in sentences for people.
  std::vector<std::string> odometry_problems() const;
  /// The mapper's own odometry, if it has one.
  const odometry::LidarOdometry* odometry() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace voxnav::pipeline
