// SPDX-License-Identifier: BSD-3-Clause
#include <pluginlib/class_list_macros.hpp>
#include <thread>

#include "clock_follower.hpp"
#include "commands.hpp"
#include "frames.hpp"
#include "outputs.hpp"
#include "pacer.hpp"
#include "voxnav/Progress.h"
#include "voxnav_ros/conversions.hpp"
#include "voxnav_ros/messages.hpp"
#include "voxnav_ros/nodelet_base.hpp"
#include "voxnav_simulation/scene.hpp"
#include "voxnav_simulation/service_times.hpp"
#include "voxnav_simulation/uav.hpp"
#include "voxnav_simulation/uav_simulator_config.hpp"

namespace voxnav_ros {

using voxnav_simulation::Uav;

/// The nodelet that stands in for the MRS nodes and owns /clock, or follows that of another UAV's simulator. A thread
/// of its own advances the vehicle on the wall clock, so nothing here may wait for simulated time. Commands arrive on
/// the manager's threads and are answered also while time stands still.
class UavSimulatorNodelet : public NodeletBase {
 public:
  UavSimulatorNodelet() : NodeletBase("UavSimulator") {}
  ~UavSimulatorNodelet() override {
    if (pacer_) pacer_->stop();
    if (leader_) leader_->stop();
    is_running_ = false;
    if (thread_.joinable()) thread_.join();
  }

 private:
  void initialize() override {
    load();
    ros::NodeHandle& nh = getMTNodeHandle();
    ros::NodeHandle& private_nh = getMTPrivateNodeHandle();
    frames_ = std::make_unique<UavFrames>(config_.uav_name, config_.estimator, switches_config_,
                                          voxnav::geometry::Vec3(config_.utm_east_m, config_.utm_north_m, 0.0));
    switches_ = std::make_unique<voxnav_simulation::EstimatorSwitches>(switches_config_, seed());
    pacer_ = std::make_unique<Pacer>(config_);
    make_uav();
    service_times_ = std::make_unique<voxnav_simulation::ServiceTimes>(services_, seed());
    outputs_ = std::make_unique<UavOutputs>(nh, private_nh, outputs_config_, *frames_, scene_);
    const UavCommands::Shared shared{&mutex_, uav_.get(), &constraint_set_, service_times_.get()};
    commands_ =
        std::make_unique<UavCommands>(nh, shared, *frames_, commands_config_, [this] { return take_off_refusal(); });
  }

  void start() override {
    progress_ = getMTPrivateNodeHandle().subscribe("progress_in", 1000, &UavSimulatorNodelet::on_progress, this,
                                                   ros::TransportHints().tcpNoDelay());
    if (config_.follows_clock) {
      leader_ = std::make_unique<ClockFollower>(getMTNodeHandle(), getMTPrivateNodeHandle(), config_.uav_name);
    }
    thread_ = std::thread([this] { run(); });
  }

  void load() {
    ParamLoader& params = parameters();
    params.section("node", &config_);
    params.section("uav", &setup_.uav);
    params.section("drift", &setup_.drift);
    params.section("imu", &setup_.imu);
    params.section("constraints", &commands_config_.constraints);
    params.section("generator", &commands_config_.generator);
    params.section("safety_area", &commands_config_.safety_area);
    params.section("tracking", &setup_.faults.tracking);
    params.section("wind", &setup_.faults.wind);
    params.section("state_noise", &setup_.faults.state_noise);
    params.section("refusals", &setup_.faults.refusals);
    params.section("avoidance", &setup_.faults.avoidance);
    params.section("bumper", &setup_.faults.bumper);
    params.section("resets", &setup_.faults.resets);
    params.section("switches", &switches_config_);
    params.section("services", &services_);
    params.section("losses", &outputs_config_.losses);
    params.finish();
    commands_config_.node = config_;
    constraint_set_ = commands_config_.constraints.initial;
    setup_.limits = limits_of(commands_config_.constraints, constraint_set_);
  }

  void make_uav() {
    voxnav_simulation::SensedWorld sensed_world;
    if (!config_.world_yaml.empty()) {
      scene_ = voxnav_simulation::shared_scene(config_.world_yaml, static_cast<std::uint64_t>(config_.seed));
      sensed_world = voxnav_simulation::sensed_world_of(scene_);
    }
    uav_ = std::make_unique<Uav>(setup_, seed(), sensed_world);
    uav_->set_stamp_ns(voxnav::base::from_seconds(config_.start_time_s));
  }

  std::uint64_t seed() const {
    return static_cast<std::uint64_t>(config_.seed) + static_cast<std::uint64_t>(config_.seed_offset);
  }

  void run() {
    const int steps = 200 / config_.clock_hz;
    voxnav::base::StampNs stamp_ns = uav_->stamp_ns();
    if (leader_) {
      const auto first_ns = leader_->first();
      if (!first_ns) return;
      stamp_ns = std::max(stamp_ns, *first_ns);
      const std::lock_guard<std::mutex> lock(mutex_);
      uav_->set_stamp_ns(stamp_ns);
    }
    while (is_running_ && ros::ok()) {
      const auto next_ns = stamp_ns + steps * voxnav_simulation::kStep_ns;
      // Nodes that start while time stands still wait for a clock, so the present time is sent again.
      if (leader_) leader_->wait(next_ns);
      pacer_->wait(next_ns, [&] { outputs_->publish_clock(stamp_ns); });
      if (!is_running_) return;
      {
        const auto timer = diagnostics().time("step");
        advance(steps);
      }
      stamp_ns = next_ns;
      if (leader_) leader_->report(stamp_ns);
      report();
    }
  }

  void advance(int steps) {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      for (int i = 0; i < steps; ++i) {
        uav_->step();
        if (uav_->is_flying_normally() && switches_->step(voxnav_simulation::kStep_s)) frames_->switch_to_other();
        outputs_->add_imu(uav_->imu());
      }
      outputs_->collect(uav_.get(), constraint_set_);
    }
    outputs_->publish();
  }

  void report() {
    diagnostics().set_counter("real_time_factor", pacer_->real_time_factor());
    diagnostics().set_counter("recent_real_time_factor", pacer_->recent_real_time_factor());
    for (const Pacer::Event& event : pacer_->take_events()) {
      if (event.is_problem) {
        ++num_left_behind_;
        NODELET_ERROR_STREAM("[" << node() << "]: " << event.text);
        diagnostics().set_level(msg::NodeDiagnostics::ERROR, event.text);
      } else {
        NODELET_WARN_STREAM("[" << node() << "]: " << event.text);
        diagnostics().set_level(msg::NodeDiagnostics::OK, "");
      }
    }
    diagnostics().set_counter("lockstep_left_behind", num_left_behind_);
  }

  /// Why the vehicle may not take off yet; empty when it may. In lock-step a flight begins when all nodes are there, so
  /// that it does not depend on how fast they start.
  std::string take_off_refusal() const {
    std::string names;
    for (const std::string& name : pacer_->unseen()) names += (names.empty() ? "" : ", ") + name;
    return names.empty() ? names : "lock-step: no progress yet from " + names;
  }

  void on_progress(const msg::ProgressConstPtr& msg) {
    msg->is_begun ? pacer_->begin(msg->node, to_ns(msg->stamp)) : pacer_->report(msg->node, to_ns(msg->stamp));
  }

  UavOutputs::Config outputs_config_;
  voxnav_simulation::UavSimulatorConfig& config_ = outputs_config_.node;
  voxnav_simulation::UavSetup setup_;
  UavCommands::Config commands_config_;
  voxnav_simulation::EstimatorSwitchesConfig switches_config_;
  voxnav_simulation::ServiceTimesConfig services_;

  std::shared_ptr<voxnav_simulation::Scene> scene_;
  std::mutex mutex_;  ///< guards uav_, constraint_set_ and service_times_
  std::unique_ptr<Uav> uav_;
  std::unique_ptr<voxnav_simulation::ServiceTimes> service_times_;
  voxnav_simulation::ConstraintSet constraint_set_;
  std::unique_ptr<UavFrames> frames_;
  std::unique_ptr<voxnav_simulation::EstimatorSwitches> switches_;
  std::unique_ptr<Pacer> pacer_;
  std::unique_ptr<ClockFollower> leader_;  ///< null if this simulator owns the clock
  std::unique_ptr<UavOutputs> outputs_;
  std::unique_ptr<UavCommands> commands_;
  ros::Subscriber progress_;
  int num_left_behind_ = 0;
  std::atomic<bool> is_running_{true};
  std::thread thread_;
};

}  // namespace voxnav_ros

PLUGINLIB_EXPORT_CLASS(voxnav_ros::UavSimulatorNodelet, nodelet::Nodelet)
