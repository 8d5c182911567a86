// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <string>
#include <vector>

#include "voxnav_simulation/lock_step.hpp"
#include "voxnav_simulation/uav_simulator_config.hpp"

namespace voxnav_ros {

/// Decides, on the wall clock, when simulated time may go on: at the speed factor, and in lock-step not before the
/// listed nodes have caught up. Only the thread that advances time may block here; reports come from any thread.
class Pacer {
 public:
  explicit Pacer(const voxnav_simulation::UavSimulatorConfig& config);

  /// Waits until time may reach `stamp_ns`. `on_idle` is called ten times a second while nodes are waited for.
  void wait(voxnav::base::StampNs stamp_ns, const std::function<void()>& on_idle);
  void report(const std::string& node, voxnav::base::StampNs stamp_ns);
  /// A node was sent something of this stamp, and will report when it is done with it.
  void begin(const std::string& node, voxnav::base::StampNs stamp_ns);
  void stop();

  std::vector<std::string> unseen() const;
  struct Event {
    bool is_problem;
    std::string text;
  };
  /// Which nodes were left behind since the last call, and which came back.
  std::vector<Event> take_events();
  /// Simulated time over wall time, since the start and over the last second or so.
  double real_time_factor() const { return real_time_factor_; }
  double recent_real_time_factor() const { return recent_factor_; }

 private:
  using Clock = std::chrono::steady_clock;
  void wait_for_nodes(voxnav::base::StampNs stamp_ns, const std::function<void()>& on_idle);
  void wait_for_wall(double sim_s);
  void measure(double sim_s);

  double speed_factor_;
  double timeout_s_;
  mutable std::mutex mutex_;
  std::condition_variable progress_;
  voxnav_simulation::LockStep lock_step_;
  std::vector<Event> events_;
  std::atomic<bool> is_stopped_{false};

  bool has_started_ = false;
  double last_sim_s_ = 0;
  Clock::time_point next_wall_;
  double start_sim_s_ = 0, recent_sim_s_ = 0;
  Clock::time_point start_wall_, recent_wall_;
  std::atomic<double> real_time_factor_{0}, recent_factor_{0};
};

}  // namespace voxnav_ros
