// SPDX-License-Identifier: BSD-3-Clause
#include "local_mapper_nodelet.hpp"

#include <algorithm>
#include <pluginlib/class_list_macros.hpp>

#include "local_map_messages.hpp"
#include "moving_markers.hpp"
#include "voxnav_ros/conversions.hpp"
#include "voxnav_ros/messages.hpp"

namespace voxnav_ros {
namespace {

/// The number of times within tf_timeout_s that scans which wait for their pose are checked.
constexpr int kChecksPerTimeout = 4;

/// Returns true if `period_s` has passed since the last time, or if time went back.
bool is_due(const ros::Time& now, double period_s, ros::Time* last) {
  if (now >= *last && !last->isZero() && (now - *last).toSec() < period_s) return false;
  *last = now;
  return true;
}

}  // namespace

LocalMapperNodelet::~LocalMapperNodelet() {
  if (mapper_ && ros::ok()) hand_over(mapper_->finish("shutdown"));
}

void LocalMapperNodelet::initialize() {
  pipeline::MapperConfig mapper;
  ParamLoader& params = parameters();
  params.section("mapper", &mapper);
  params.section("map", &mapper.map);
  params.section("moving", &mapper.moving);
  params.section("submap", &mapper.submap);
  params.section("load", &mapper.load);
  params.section("node", &config_);
  mapper.sensors.assign(config_.sensors.size(), pipeline::SensorConfig());
  for (std::size_t i = 0; i < config_.sensors.size(); ++i) params.section(config_.sensors[i], &mapper.sensors[i]);
  for (const std::string& name : config_.idle_sensors) {
    pipeline::SensorConfig unused;
    params.section(name, &unused);
  }
  params.finish();
  limits_ = mapper.sensors;
  uses_odometry_ = config_.pose_source == MapperPoses::kOdometry;
  follows_estimator_ = config_.odometry_frame.empty();
  frame_ = frame_name(config_.odometry_frame);
  tf_ = std::make_unique<TfLocator>(frame_, frame_name(config_.body_frame));
  const pipeline::SweepLocator* locator = tf_.get();
  if (uses_odometry_) locator = &poses_;
  poses_.set_max_gap(voxnav::base::from_seconds(mapper.max_pose_gap_s));
  mapper_ = std::make_unique<pipeline::Mapper>(mapper, voxnav::geometry::Pose::Identity(), locator);
  advertise();
}

void LocalMapperNodelet::advertise() {
  ros::NodeHandle& nh = getPrivateNodeHandle();
  for (std::size_t i = 0; i < config_.sensors.size(); ++i) {
    const std::string& name = config_.sensors[i];
    sensors_.emplace_back();
    sensors_.back().name = name;
    sensors_.back().progress_part = i == 0 ? "" : name;
    sensors_.back().topic = nh.resolveName(points_in(i, name));
  }
  origin_ = nh.advertise<msg::OdometryOrigin>("origin_out", 5, true);
  if (!follows_estimator_) announce_origin(ros::Time(), "", std::nullopt);
  updates_ = nh.advertise<msg::GridUpdate>("map_out", 20);
  handovers_ = nh.advertise<msg::Handover>("handover_out", 20);
  occupied_ = nh.advertise<sensor_msgs::PointCloud2>("occupied_out", 1, true);
  moving_ = nh.advertise<visualization_msgs::MarkerArray>("moving_markers_out", 2);
  octomap_ = nh.advertise<octomap_msgs::Octomap>("octomap_out", 1, true);
  octomap_binary_ = nh.advertise<octomap_msgs::Octomap>("octomap_binary_out", 1, true);
  services_ = {nh.advertiseService("get_map_in", &LocalMapperNodelet::on_get_map, this),
               nh.advertiseService("save_in", &LocalMapperNodelet::on_save, this),
               nh.advertiseService("load_in", &LocalMapperNodelet::on_load, this),
               nh.advertiseService("reset_in", &LocalMapperNodelet::on_reset, this),
               nh.advertiseService("close_submap_in", &LocalMapperNodelet::on_close_submap, this)};
}

void LocalMapperNodelet::start() {
  ros::NodeHandle& nh = getPrivateNodeHandle();
  const auto hints = ros::TransportHints().tcpNoDelay();
  quality_ = nh.subscribe("odometry_quality_in", 5, &LocalMapperNodelet::on_quality, this, hints);
  others_ = nh.subscribe("others_in", 2, &LocalMapperNodelet::on_others, this, hints);
  uav_state_ = nh.subscribe("uav_state_in", 5, &LocalMapperNodelet::on_uav_state, this, hints);
  if (uses_odometry_) odometry_ = nh.subscribe("odometry_in", 100, &LocalMapperNodelet::on_odometry, this, hints);
  for (std::size_t i = 0; i < sensors_.size(); ++i) {
    const std::string name = points_in(i, sensors_[i].name);
    const auto callback = [this, i](const sensor_msgs::PointCloud2ConstPtr& msg) { on_points(i, msg); };
    sensors_[i].points = nh.subscribe<sensor_msgs::PointCloud2>(name, 5, callback, nullptr, hints);
  }
  tf_->start(nh, [this] { process(); });
  overdue_ = nh.createSteadyTimer(ros::WallDuration(config_.tf_timeout_s / kChecksPerTimeout),
                                  [this](const ros::SteadyTimerEvent&) {
                                    mapper_->drop_overdue(clock().now_s(), config_.tf_timeout_s);
                                    process();
                                    watch_silence();
                                  });
}

void LocalMapperNodelet::on_points(std::size_t sensor, const sensor_msgs::PointCloud2ConstPtr& msg) {
  clock().reach(msg->header.stamp);
  sensors_[sensor].heard_s = clock().now_s();
  try {
    voxnav::cloud::Sweep sweep = sweep_of(*msg);
    sweep.sensor = sensor;
    mapper_->add_sweep(std::move(sweep), std::nullopt, clock().now_s());
    warn_of_missing_beams(sensors_[sensor], limits_[sensor], *msg);
  } catch (const std::exception& error) {
    drop(&sensors_[sensor], msg->header.stamp, error.what());
  }
  if (uses_odometry_) find_mount(sensor, frame_name(msg->header.frame_id));
  process();
}

void LocalMapperNodelet::on_odometry(const nav_msgs::OdometryConstPtr& msg) {
  clock().reach(msg->header.stamp);
  const auto T_O_B = from_msg(msg->pose.pose);
  if (frame_name(msg->header.frame_id) != frame_ || frame_name(msg->child_frame_id) != frame_name(config_.body_frame)) {
    warn("odometry from '" + msg->header.frame_id + "' to '" + msg->child_frame_id + "' is refused, it must be from '" +
         frame_ + "' to '" + config_.body_frame + "'");
  } else if (!T_O_B || !poses_.add(to_ns(msg->header.stamp), *T_O_B)) {
    diagnostics().set_counter("poses_refused", static_cast<double>(++num_poses_refused_));
  }
  process();
}

/// Takes the mount of a sensor from tf, once tf knows it.
void LocalMapperNodelet::find_mount(std::size_t sensor, const std::string& sensor_frame) {
  if (sensors_[sensor].mounted_frame == sensor_frame) return;
  const auto T_B_L = tf_->mount(sensor_frame);
  if (!T_B_L) return;
  poses_.set_mount(*T_B_L, sensor);
  sensors_[sensor].mounted_frame = sensor_frame;
}

void LocalMapperNodelet::process() {
  while (mapper_->has_next()) map_next();
}

void LocalMapperNodelet::map_next() {
  const double start_s = clock().now_s();
  pipeline::MapperStep step;
  {
    const auto timer = diagnostics().time("insert");
    step = mapper_->next();
  }
  const ros::Time stamp = to_ros(step.stamp_ns);
  hand_over(step.handovers);
  if (step.map_cleared) report_clear(*step.map_cleared);
  if (step.fate != pipeline::SweepFate::kMapped) return leave_out(step);
  MapperSensor& sensor = sensors_[step.sensor];
  ++sensor.num_mapped;
  report(sensor);
  report(step.statistics);
  diagnostics().add_latency("insert", stamp);
  publish_map(step);
  {
    const auto timer = diagnostics().time("handover");
    hand_over(mapper_->close_due());
  }
  if (step.leads) publish_pictures(stamp);
  watch_load(clock().now_s() - start_s, step);
  publish_progress(stamp, sensor.progress_part);
}

void LocalMapperNodelet::leave_out(const pipeline::MapperStep& step) {
  MapperSensor& sensor = sensors_[step.sensor];
  if (step.fate == pipeline::SweepFate::kSurplus) {
    ++sensor.num_surplus;
    report(sensor);
    return publish_progress(to_ros(step.stamp_ns), sensor.progress_part);
  }
  num_late_ += step.fate == pipeline::SweepFate::kLate ? 1 : 0;
  sensor.num_late += step.fate == pipeline::SweepFate::kLate ? 1 : 0;
  drop(&sensor, to_ros(step.stamp_ns), step.reason);
}

std_msgs::Header LocalMapperNodelet::header(const ros::Time& stamp) const {
  std_msgs::Header out;
  out.frame_id = frame_;
  out.stamp = stamp;
  return out;
}

GridUpdateHeader LocalMapperNodelet::update_header(const ros::Time& stamp) const {
  return {frame_, to_ns(stamp), sequence_, mapper_->map().config().resolution_m};
}

/// The first message is a snapshot. Afterwards listeners follow the changes, and request a snapshot if they missed
/// some.
bool LocalMapperNodelet::is_snapshot_due(const ros::Time& stamp) {
  if (config_.snapshot_period_s <= 0.0 && !last_snapshot_.isZero()) return false;
  return is_due(stamp, config_.snapshot_period_s, &last_snapshot_);
}

/// The stamps of maps rise, although scans of several sensors overtake each other.
void LocalMapperNodelet::publish_map(const pipeline::MapperStep& step) {
  const auto timer = diagnostics().time("publish");
  const ros::Time stamp = to_ros(step.stamp_ns);
  map_stamp_ = step.map_cleared ? stamp : std::max(map_stamp_, stamp);
  voxnav::containers::GridUpdate update = mapper_->map().take_changes();
  if (is_snapshot_due(map_stamp_)) update = mapper_->map().snapshot();
  ++sequence_;
  updates_.publish(update_msg(std::move(update), map_stamp_));
  if (moving_.getNumSubscribers() > 0) moving_.publish(moving_markers(mapper_->moving().things(), header(map_stamp_)));
}

msg::GridUpdate LocalMapperNodelet::update_msg(voxnav::containers::GridUpdate update, const ros::Time& stamp) const {
  msg::GridUpdate out = to_msg(std::move(update), update_header(stamp));
  add_sightings(mapper_->map().new_hits(), mapper_->moving().things(), &out);
  return out;
}

void LocalMapperNodelet::publish_pictures(const ros::Time& stamp) {
  if (is_due(stamp, config_.occupied_period_s, &last_occupied_)) {
    const std::vector<float> points = mapper_->map().occupied_points();
    occupied_.publish(xyz_cloud_of(voxnav::geometry::view_of_rows(points), header(stamp)));
  }
  if (octomap_.getNumSubscribers() + octomap_binary_.getNumSubscribers() == 0) return;
  if (!is_due(stamp, config_.octomap_period_s, &last_octomap_)) return;
  publish_octomap(octomap_, false, stamp);
  publish_octomap(octomap_binary_, true, stamp);
}

void LocalMapperNodelet::publish_octomap(const ros::Publisher& publisher, bool is_binary, const ros::Time& stamp) {
  if (publisher.getNumSubscribers() == 0) return;
  const auto timer = diagnostics().time("octomap");
  try {
    publisher.publish(octomap_of(mapper_->map(), is_binary, header(stamp)));
  } catch (const std::length_error& error) {
    warn(std::string("no OctoMap is published: ") + error.what());
  }
}

void LocalMapperNodelet::hand_over(const std::vector<pipeline::Handover>& handovers) {
  for (const pipeline::Handover& handover : handovers) {
    const msg::Handover msg = to_msg(handover, frame_);
    announce_work(msg.header.stamp);
    handovers_.publish(msg);
    NODELET_INFO_STREAM("[" << node() << "]: submap " << handover.submap_id
                            << (handover.is_final ? " closed: " : " early: ") << handover.reason << ", "
                            << handover.content.num_occupied() << " occupied voxels");
  }
}

void LocalMapperNodelet::on_quality(const msg::OdometryQualityConstPtr& msg) {
  if (msg->state == msg::OdometryQuality::COASTING) mapper_->request_close("odometry");
}

}  // namespace voxnav_ros

PLUGINLIB_EXPORT_CLASS(voxnav_ros::LocalMapperNodelet, nodelet::Nodelet)
