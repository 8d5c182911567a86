// SPDX-License-Identifier: BSD-3-Clause
#include "pacer.hpp"

#include <thread>
#include <utility>

namespace voxnav_ros {
namespace {

constexpr auto kIdlePeriod = std::chrono::milliseconds(100);
constexpr double kMaxCatchUp_s = 0.2;  ///< delay in wall time that is caught up with; more is lost for good

double seconds(std::chrono::steady_clock::duration d) { return std::chrono::duration<double>(d).count(); }

}  // namespace

Pacer::Pacer(const voxnav_simulation::UavSimulatorConfig& config)
    : speed_factor_(config.speed_factor),
      timeout_s_(config.lockstep_timeout_s),
      lock_step_({config.lockstep_nodes, voxnav::base::from_seconds(config.lockstep_lag_s),
                  voxnav::base::from_seconds(config.lockstep_period_s), config.lockstep_leader}) {}

void Pacer::wait(voxnav::base::StampNs stamp_ns, const std::function<void()>& on_idle) {
  const double sim_s = voxnav::base::to_seconds(stamp_ns);
  if (!has_started_) {
    has_started_ = true;
    last_sim_s_ = start_sim_s_ = recent_sim_s_ = sim_s;
    next_wall_ = start_wall_ = recent_wall_ = Clock::now();
  }
  wait_for_nodes(stamp_ns, on_idle);
  wait_for_wall(sim_s);
  measure(sim_s);
}

void Pacer::wait_for_nodes(voxnav::base::StampNs stamp_ns, const std::function<void()>& on_idle) {
  std::unique_lock<std::mutex> lock(mutex_);
  const Clock::time_point since = Clock::now();
  while (!is_stopped_) {
    const std::vector<std::string> missing = lock_step_.missing(stamp_ns);
    if (missing.empty()) return;
    // A leader that has not spoken yet is still starting, and may take as long as it needs.
    if (!lock_step_.is_waiting_for_leader() && seconds(Clock::now() - since) > timeout_s_) {
      for (const std::string& node : missing) {
        lock_step_.leave_behind(node);
        events_.push_back({true, "lock-step: no progress from " + node + " at simulated time " +
                                     std::to_string(voxnav::base::to_seconds(stamp_ns)) + " s within " +
                                     std::to_string(timeout_s_) + " s of wall time; going on without it"});
      }
      return;
    }
    if (progress_.wait_for(lock, kIdlePeriod) == std::cv_status::timeout) {
      lock.unlock();
      on_idle();
      lock.lock();
    }
  }
}

void Pacer::wait_for_wall(double sim_s) {
  const double elapsed_s = sim_s - last_sim_s_;
  last_sim_s_ = sim_s;
  // A node that has not reported yet does not hold time back, so time runs no faster than real until all have.
  double factor = speed_factor_;
  if (factor <= 0 && !unseen().empty()) factor = 1.0;
  const Clock::time_point now = Clock::now();
  if (factor <= 0) {
    next_wall_ = now;
    return;
  }
  next_wall_ += std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(elapsed_s / factor));
  if (seconds(now - next_wall_) > kMaxCatchUp_s) next_wall_ = now;
  if (next_wall_ > now) std::this_thread::sleep_until(next_wall_);
}

void Pacer::measure(double sim_s) {
  const Clock::time_point now = Clock::now();
  const double wall_s = seconds(now - start_wall_);
  if (wall_s > 0.1) real_time_factor_ = (sim_s - start_sim_s_) / wall_s;
  const double recent_s = seconds(now - recent_wall_);
  if (recent_s < 1.0) return;
  recent_factor_ = (sim_s - recent_sim_s_) / recent_s;
  recent_wall_ = now;
  recent_sim_s_ = sim_s;
}

void Pacer::report(const std::string& node, voxnav::base::StampNs stamp_ns) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (lock_step_.report(node, stamp_ns)) events_.push_back({false, "lock-step: " + node + " is back"});
  }
  progress_.notify_all();
}

void Pacer::begin(const std::string& node, voxnav::base::StampNs stamp_ns) {
  const std::lock_guard<std::mutex> lock(mutex_);
  lock_step_.begin(node, stamp_ns);
}

void Pacer::stop() {
  is_stopped_ = true;
  progress_.notify_all();
}

std::vector<std::string> Pacer::unseen() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return lock_step_.unseen();
}

std::vector<Pacer::Event> Pacer::take_events() {
  const std::lock_guard<std::mutex> lock(mutex_);
  return std::exchange(events_, {});
}

}  // namespace voxnav_ros
