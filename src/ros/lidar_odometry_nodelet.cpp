// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_odometry_nodelet.hpp"

#include <pluginlib/class_list_macros.hpp>

#include "lidar_odometry_messages.hpp"
#include "voxnav_ros/cloud_conversions.hpp"
#include "voxnav_ros/conversions.hpp"
#include "voxnav_ros/messages.hpp"

namespace voxnav_ros {
namespace {

namespace odometry = voxnav::odometry;
constexpr double kLogPeriod_s = 5.0;
/// Time after the first cloud for which a frame that is not level waits for an IMU.
constexpr double kLevelWait_s = 3.0;
/// Number of IMU samples kept until the mount of the LiDAR is known: enough to find the direction of gravity.
constexpr std::size_t kMaxEarlySamples = 1000;
constexpr double kWaitCheck_s = 0.005;

}  // namespace

void LidarOdometryNodelet::initialize() {
  ros::NodeHandle& nh = getPrivateNodeHandle();
  ParamLoader& params = parameters();
  params.section("odometry", &odometry_config_);
  params.section("node", &config_);
  params.finish();
  voxnav::base::checked(odometry_config_);
  gate_ = std::make_unique<odometry::ImuGate>(
      odometry::ImuGate::Limits{odometry_config_.use_imu, config_.imu_timeout_s, config_.imu_wait_s});
  tf_buffer_ = std::make_unique<tf2_ros::Buffer>();
  tf_listener_ = std::make_unique<tf2_ros::TransformListener>(*tf_buffer_);
  odom_ = nh.advertise<nav_msgs::Odometry>("odom_out", 10);
  quality_ = nh.advertise<msg::OdometryQuality>("quality_out", 10);
  reset_ = nh.advertiseService("reset", &LidarOdometryNodelet::on_reset, this);
  reset_odom_ = nh.advertiseService("reset_odom", &LidarOdometryNodelet::on_reset_odom, this);
  points_topic_ = nh.resolveName("points_in");
  imu_topic_ = nh.resolveName("imu_in");
}

void LidarOdometryNodelet::start() {
  ros::NodeHandle& nh = getPrivateNodeHandle();
  wait_timer_ = nh.createSteadyTimer(ros::WallDuration(kWaitCheck_s), &LidarOdometryNodelet::on_wait, this);
  imu_ = nh.subscribe("imu_in", 1000, &LidarOdometryNodelet::on_imu, this, ros::TransportHints().tcpNoDelay());
  points_ = nh.subscribe("points_in", 5, &LidarOdometryNodelet::on_points, this, ros::TransportHints().tcpNoDelay());
}

std::optional<voxnav::geometry::Pose> LidarOdometryNodelet::mounting(const std::string& frame_id) {
  const std::string frame = frame_name(frame_id);
  std::string why = "frame_id is empty";
  try {
    if (!frame.empty()) {
      const std::string body = frame_name(config_.body_frame);
      const auto transform = tf_buffer_->lookupTransform(body, frame, ros::Time(0)).transform;
      if (auto pose = from_msg(transform)) return pose;
      why = "the transform is not finite";
    }
  } catch (const tf2::TransformException& error) {
    why = error.what();
  }
  complain("no transform from '" + frame + "' to '" + config_.body_frame + "': " + why);
  return std::nullopt;
}

void LidarOdometryNodelet::on_imu(const sensor_msgs::ImuConstPtr& msg) {
  clock().reach(msg->header.stamp);
  unmounted_imu_.push_back(msg);
  take_unmounted();
  process_ready();
}

/// Uses the samples whose mounting was unknown when they came, as soon as it is known.
void LidarOdometryNodelet::take_unmounted() {
  if (unmounted_imu_.empty()) return;
  if (!R_B_I_) {
    if (const auto T_B_I = mounting(unmounted_imu_.back()->header.frame_id)) R_B_I_ = T_B_I->linear();
  }
  if (!R_B_I_) {
    if (unmounted_imu_.size() > kMaxEarlySamples) unmounted_imu_.pop_front();
    return;
  }
  for (const sensor_msgs::ImuConstPtr& sample : unmounted_imu_) add_imu(*sample);
  unmounted_imu_.clear();
}

void LidarOdometryNodelet::add_imu(const sensor_msgs::Imu& msg) {
  const auto& w = msg.angular_velocity;
  const auto& a = msg.linear_acceleration;
  const odometry::ImuSample sample{to_ns(msg.header.stamp), *R_B_I_ * voxnav::geometry::Vec3(w.x, w.y, w.z),
                                   *R_B_I_ * voxnav::geometry::Vec3(a.x, a.y, a.z)};
  if (estimator_) {
    if (estimator_->add_imu(sample)) gate_->note_imu(sample.stamp_ns);
  } else {
    early_imu_.push_back(sample);
    if (early_imu_.size() > kMaxEarlySamples) early_imu_.pop_front();
  }
}

void LidarOdometryNodelet::on_points(const sensor_msgs::PointCloud2ConstPtr& msg) {
  clock().reach(msg->header.stamp);
  try {
    if (!estimator_ && !make_estimator(msg->header.frame_id))
      return drop(msg->header.stamp, "the LiDAR's mounting is unknown");
    if (msg->header.frame_id != lidar_frame_) {
      return drop(msg->header.stamp, "cloud on " + points_topic_ + " is in frame '" + msg->header.frame_id +
                                         "', the ones before were in '" + lidar_frame_ + "'");
    }
    voxnav::cloud::Sweep sweep = sweep_of(*msg);
    // A sweep is waited for from its end, which has passed when its cloud is here: counted from its stamp, the samples
    // of its second half would come too late in a simulation whose time is that of its messages.
    clock().reach(to_ros(sweep.start_ns + voxnav::base::StampNs{sweep.duration_ns}));
    gate_->add(std::move(sweep), clock().now_s());
  } catch (const std::exception& error) {
    return drop(msg->header.stamp, "cloud on " + points_topic_ + " refused: " + error.what());
  }
  process_ready();
}

bool LidarOdometryNodelet::make_estimator(const std::string& lidar_frame) {
  const auto T_B_L = mounting(lidar_frame);
  if (!T_B_L) return false;
  take_unmounted();  // the first cloud is not to begin without the samples before it
  lidar_frame_ = lidar_frame;
  estimator_ = std::make_unique<odometry::LidarOdometry>(odometry_config_, *T_B_L);
  for (const odometry::ImuSample& sample : early_imu_) {
    if (estimator_->add_imu(sample)) gate_->note_imu(sample.stamp_ns);
  }
  early_imu_.clear();
  return true;
}

void LidarOdometryNodelet::on_wait(const ros::SteadyTimerEvent&) { process_ready(); }

void LidarOdometryNodelet::process_ready() {
  while (const auto sweep = gate_->next(clock().now_s())) process(*sweep);
}

void LidarOdometryNodelet::process(const voxnav::cloud::Sweep& sweep) {
  const ros::Time stamp = to_ros(sweep.stamp_ns);
  odometry::OdometryResult result;
  {
    const auto timer = diagnostics().time("odometry");
    result = estimator_->add_sweep(sweep);
    // Who flies by the frame must not see it turn.
    if (result.is_new && !has_published_ && estimator_->level()) result = estimator_->last();
  }
  diagnostics().add_latency("odometry", stamp);
  publish(result);
  report(result);
  publish_progress(stamp);
}

/// Whether an IMU may still turn the frame upright. In the first seconds nothing is flown by it yet.
bool LidarOdometryNodelet::awaits_level(voxnav::base::StampNs stamp_ns) {
  if (!first_stamp_ns_) first_stamp_ns_ = stamp_ns;
  if (estimator_->is_level() || !odometry_config_.use_imu || has_published_) return false;
  const bool is_early = voxnav::base::to_seconds(stamp_ns - *first_stamp_ns_) < kLevelWait_s;
  return is_early && imu_.getNumPublishers() > 0;
}

void LidarOdometryNodelet::publish(const odometry::OdometryResult& result) {
  if (!result.is_new) return;
  std_msgs::Header header;
  header.stamp = to_ros(result.stamp_ns);
  header.frame_id = config_.odometry_frame;
  quality_.publish(quality_msg(result, header));
  // Before the first map there is no pose to publish, and before the frame is level nobody is to fly by it.
  if (estimator_->num_map_voxels() == 0 || awaits_level(result.stamp_ns)) return;
  has_published_ = true;
  odom_.publish(odometry_msg(result, header, config_.body_frame, odometry_config_));
  if (!config_.publish_tf) return;
  geometry_msgs::TransformStamped tf;
  tf.header.stamp = header.stamp;
  tf.header.frame_id = config_.body_frame;
  tf.child_frame_id = config_.odometry_frame;
  tf.transform = to_transform_msg(result.T_O_B.inverse());
  tf_broadcaster_.sendTransform(tf);
}

void LidarOdometryNodelet::report(const odometry::OdometryResult& result) {
  const odometry::OdometryCounters& c = estimator_->counters();
  const voxnav::base::StampCounts& stamps = estimator_->imu_stamps();
  const std::pair<const char*, std::uint64_t> counters[] = {{"clouds", c.clouds},
                                                            {"clouds_refused", c.clouds_refused},
                                                            {"coasted", c.coasted},
                                                            {"map_restarts", c.map_restarts},
                                                            {"time_jumps_back", c.clock_jumps},
                                                            {"points_refused", c.points_refused},
                                                            {"imu_refused", c.imu_refused},
                                                            {"imu_clock_jumps", c.imu_clock_jumps},
                                                            {"scans_without_imu", c.scans_without_imu},
                                                            {"imu_stamps_repeated", stamps.repeated},
                                                            {"imu_stamps_stray", stamps.stray},
                                                            {"imu_clock_stuck", stamps.stuck_clocks}};
  for (const auto& [name, value] : counters) diagnostics().set_counter(name, static_cast<double>(value));
  diagnostics().set_counter("map_voxels", static_cast<double>(estimator_->num_map_voxels()));
  if (!result.is_new || result.quality.state == odometry::OdometryState::kCoasting) {
    complain(result.quality.reason);
  } else {
    diagnostics().set_level(msg::NodeDiagnostics::OK, "");
  }
}

void LidarOdometryNodelet::drop(const ros::Time& stamp, const std::string& reason) {
  diagnostics().add_dropped("odometry");
  complain(reason);
  publish_progress(stamp);
}

void LidarOdometryNodelet::complain(const std::string& text) {
  diagnostics().set_level(msg::NodeDiagnostics::WARN, text);
  NODELET_WARN_STREAM_THROTTLE(kLogPeriod_s, "[" << node() << "]: " << text);
}

bool LidarOdometryNodelet::on_reset(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
  gate_->clear();
  if (estimator_) estimator_->reset();
  first_stamp_ns_.reset();
  has_published_ = false;
  response.success = true;
  response.message = "odometry starts anew with the next cloud";
  NODELET_INFO_STREAM("[" << node() << "]: " << response.message);
  return true;
}

bool LidarOdometryNodelet::on_reset_odom(std_srvs::Empty::Request&, std_srvs::Empty::Response&) {
  std_srvs::Trigger::Request request;
  std_srvs::Trigger::Response response;
  return on_reset(request, response);
}

}  // namespace voxnav_ros

PLUGINLIB_EXPORT_CLASS(voxnav_ros::LidarOdometryNodelet, nodelet::Nodelet)
