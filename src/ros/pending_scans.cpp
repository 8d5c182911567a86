// SPDX-License-Identifier: BSD-3-Clause
#include "pending_scans.hpp"

#include <algorithm>
#include <utility>

#include "voxnav_ros/cloud_conversions.hpp"
#include "voxnav_ros/conversions.hpp"

namespace voxnav_ros {
namespace {

using voxnav::cloud::FieldAccess;
using voxnav::cloud::read_float;

/// Sweeps are shorter than this; larger offsets are broken clocks.
constexpr std::uint32_t kMaxDuration_ns = 1000000000;

std::uint32_t read_time(const std::uint8_t* point, const FieldAccess& field) {
  return static_cast<std::uint32_t>(std::clamp(voxnav::cloud::read_number(point, field), 0.0, double{kMaxDuration_ns}));
}

}  // namespace

ScanPoints read_points(const sensor_msgs::PointCloud2& msg) {
  if (msg.header.frame_id.empty()) throw std::invalid_argument("frame_id is empty");
  const voxnav::cloud::RawCloudView view = view_of(msg);
  const auto& access = view.access();
  // Only the filter's own times are used; it has turned those of all drivers into them.
  const bool has_times = access.time && access.time_unit == voxnav::cloud::TimeUnit::kNanosecondsAfterStamp;
  ScanPoints out;
  out.xyz.reserve(3 * view.num_points());
  out.time_offsets_ns.reserve(view.num_points());
  for (std::uint32_t row = 0; row < view.height(); ++row) {
    const std::uint8_t* point = view.row(row);
    for (std::uint32_t i = 0; i < view.width(); ++i, point += view.point_step()) {
      for (const FieldAccess* field : {&access.x, &access.y, &access.z}) out.xyz.push_back(read_float(point, *field));
      out.time_offsets_ns.push_back(has_times ? read_time(point, *access.time) : 0);
      out.duration_ns = std::max(out.duration_ns, out.time_offsets_ns.back());
    }
  }
  return out;
}

PendingScans::PendingScans(std::string odometry_frame, std::string body_frame, double timeout_s, int max_scans,
                           bool use_times)
    : odometry_frame_(std::move(odometry_frame)),
      body_frame_(std::move(body_frame)),
      timeout_s_(timeout_s),
      max_scans_(static_cast<std::size_t>(max_scans)),
      use_times_(use_times),
      listener_(std::make_unique<tf2_ros::TransformListener>(buffer_)) {}

sensor_msgs::PointCloud2ConstPtr PendingScans::add(const sensor_msgs::PointCloud2ConstPtr& msg) {
  Waiting waiting{msg, read_points(*msg), std::chrono::steady_clock::now()};
  if (!use_times_) waiting.points.duration_ns = 0;
  pending_.push_back(std::move(waiting));
  if (pending_.size() <= max_scans_) return nullptr;
  const auto dropped = pending_.front().msg;
  pending_.pop_front();
  return dropped;
}

std::optional<PendingScans::Oldest> PendingScans::oldest() const {
  if (pending_.empty()) return std::nullopt;
  return Oldest{pending_.front().msg->header.stamp, waited_s(pending_.front())};
}

double PendingScans::waited_s(const Waiting& waiting) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - waiting.since).count();
}

PendingScans::Next PendingScans::next() {
  Next out;
  if (pending_.empty()) return out;
  Waiting& oldest = pending_.front();
  std::string problem;
  if (auto scan = locate(oldest, &problem)) {
    out.scan = std::move(scan);
    out.scan->points = std::move(oldest.points);
  } else {
    if (waited_s(oldest) < timeout_s_) return out;
    out.dropped = oldest.msg;
    out.reason = "no pose within " + std::to_string(timeout_s_) + " s: " + problem;
  }
  pending_.pop_front();
  return out;
}

std::optional<LocatedScan> PendingScans::locate(const Waiting& waiting, std::string* problem) const {
  const std::string& sensor = waiting.msg->header.frame_id;
  const ros::Time start = waiting.msg->header.stamp;
  const std::uint32_t duration_ns = waiting.points.duration_ns;
  const auto T_O_L_start = lookup(sensor, start, problem);
  const auto T_O_L_end = lookup(sensor, to_ros(to_ns(start) + duration_ns), problem);
  const auto T_O_B = lookup(body_frame_, to_ros(to_ns(start) + duration_ns / 2), problem);
  if (!T_O_L_start || !T_O_L_end || !T_O_B) return std::nullopt;
  LocatedScan out;
  out.msg = waiting.msg;
  out.motion = {*T_O_L_start, *T_O_L_end, duration_ns};
  out.T_O_B = *T_O_B;
  return out;
}

std::optional<voxnav::geometry::Pose> PendingScans::lookup(const std::string& frame, const ros::Time& stamp,
                                                           std::string* problem) const {
  try {
    const auto found = buffer_.lookupTransform(odometry_frame_, frame, stamp);
    const auto pose = from_msg(found.transform);
    if (!pose) *problem = "tf from " + frame + " to " + odometry_frame_ + " is not a rigid transform";
    return pose;
  } catch (const tf2::TransformException& error) {
    *problem = error.what();
    return std::nullopt;
  }
}

}  // namespace voxnav_ros
