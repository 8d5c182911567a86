// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav_ros/diagnostics.hpp"

#include "voxnav_ros/messages.hpp"

namespace voxnav_ros {
namespace {

using voxnav::base::StageStatistics;

msg::StageSummary to_msg(const std::string& name, const StageStatistics& stage) {
  msg::StageSummary out;
  out.name = name;
  out.count = stage.wall.count();
  out.dropped = stage.dropped;
  out.mean_ms = stage.wall.mean_ms();
  out.p99_ms = stage.wall.quantile_ms(0.99);
  out.max_ms = stage.wall.max_ms();
  out.cpu_ms = stage.cpu.mean_ms();
  out.latency_mean_ms = stage.latency.mean_ms();
  out.latency_p99_ms = stage.latency.quantile_ms(0.99);
  return out;
}

}  // namespace

Diagnostics::Scope::Scope(Diagnostics* owner, std::string stage)
    : owner_(owner),
      stage_(std::move(stage)),
      wall_start_ms_(voxnav::base::wall_clock_ms()),
      cpu_start_ms_(voxnav::base::thread_cpu_ms()) {}

Diagnostics::Scope::~Scope() {
  owner_->add_time(stage_, voxnav::base::wall_clock_ms() - wall_start_ms_,
                   voxnav::base::thread_cpu_ms() - cpu_start_ms_);
}

Diagnostics::Diagnostics(const std::string& node, ros::NodeHandle& private_nh) : node_(node) {
  publisher_ = private_nh.advertise<msg::NodeDiagnostics>("diagnostics_out", 2, true);
  timer_ = private_nh.createSteadyTimer(ros::WallDuration(1.0), &Diagnostics::publish, this, false, false);
}

void Diagnostics::add_time(const std::string& stage, double wall_ms, double cpu_ms) {
  const std::lock_guard<std::mutex> lock(mutex_);
  stages_[stage].wall.add(wall_ms);
  stages_[stage].cpu.add(cpu_ms);
}

void Diagnostics::add_latency(const std::string& stage, const ros::Time& data_stamp) {
  const double latency_ms = (ros::Time::now() - data_stamp).toSec() * 1e3;
  const std::lock_guard<std::mutex> lock(mutex_);
  stages_[stage].latency.add(latency_ms);
}

void Diagnostics::add_dropped(const std::string& stage, std::uint64_t count) {
  const std::lock_guard<std::mutex> lock(mutex_);
  stages_[stage].dropped += count;
}

void Diagnostics::set_counter(const std::string& name, double value) {
  const std::lock_guard<std::mutex> lock(mutex_);
  counters_[name] = value;
}

void Diagnostics::set_level(std::uint8_t level, const std::string& message) {
  const std::lock_guard<std::mutex> lock(mutex_);
  level_ = level;
  message_ = level == msg::NodeDiagnostics::OK ? std::string() : message;
}

void Diagnostics::publish(const ros::SteadyTimerEvent&) {
  msg::NodeDiagnostics out;
  const voxnav::base::ProcessUsage usage = voxnav::base::process_usage();
  out.rss_bytes = usage.rss_bytes;
  out.cpu_s = usage.cpu_s;
  out.header.stamp = ros::Time::now();
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    out.node = node_;
    out.level = level_;
    out.message = message_;
    for (const auto& [name, stage] : stages_) out.stages.push_back(to_msg(name, stage));
    for (const auto& [name, value] : counters_) {
      out.counter_names.push_back(name);
      out.counter_values.push_back(value);
    }
  }
  publisher_.publish(out);
}

}  // namespace voxnav_ros
