// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "pipeline/sweep_stamps.hpp"
#include "voxnav/base/time.hpp"

namespace voxnav::pipeline {

/// The time of a map that several sensors tell, and the sensor whose sweeps mark it out. Not thread-safe; O(sensors).
class MapClock {
 public:
  explicit MapClock(std::size_t num_sensors) : sensors_(num_sensors) {}

  enum class Verdict : std::uint8_t {
    kFollows,
    kBehindOthers,  ///< the sweep is far behind those of other sensors, whose time is believed
    kJumpedBack,    ///< time was set back, and goes on from this sweep
  };
  /// Adds a sweep that is about to be mapped. Time is set back at once if only this sensor told it. If others did,
  /// that is believed after a second of this sensor's sweeps in which none of the others came.
  Verdict add(std::size_t sensor, base::StampNs start_ns);
  /// The newest stamp; nothing before the first.
  const std::optional<base::StampNs>& newest_ns() const { return newest_ns_; }
  /// Whether a sweep that was added is of the first sensor that is not silent. What goes by the period of scans, such
  /// as the poses of a submap and the control of the load, follows the sweeps of one sensor.
  bool leads(std::size_t sensor, base::StampNs start_ns);

 private:
  struct Sensor {
    bool is_on_clock = false;                      ///< it told the present time
    std::optional<base::StampNs> behind_since_ns;  ///< first of its sweeps in a row that was far behind the others
  };
  bool is_jump(std::size_t sensor, base::StampNs start_ns);

  std::vector<Sensor> sensors_;
  std::optional<base::StampNs> newest_ns_;
  std::optional<std::size_t> leader_;
  base::StampNs leader_ns_ = 0;  ///< last sweep of the leader
};

}  // namespace voxnav::pipeline
