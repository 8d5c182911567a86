// SPDX-License-Identifier: BSD-3-Clause
#include "local_mapper_nodelet.hpp"

#include <algorithm>
#include <pluginlib/class_list_macros.hpp>

#include "local_map_messages.hpp"
#include "voxnav_ros/conversions.hpp"

namespace voxnav_ros {
namespace {

constexpr double kRetryPeriod_s = 0.005;

/// Due when `period_s` has passed since the last time, or when time went back.
bool is_due(const ros::Time& now, double period_s, ros::Time* last) {
  if (now >= *last && !last->isZero() && (now - *last).toSec() < period_s) return false;
  *last = now;
  return true;
}

}  // namespace

LocalMapperNodelet::~LocalMapperNodelet() {
  if (map_ && ros::ok()) hand_over(scheduler_->finish(map_.get(), "shutdown"));
}

void LocalMapperNodelet::initialize() {
  occupancy::LocalMapConfig map;
  pipeline::SubmapSchedulerConfig submap;
  pipeline::LoadControlConfig load;
  ParamLoader& params = parameters();
  params.section("map", &map);
  params.section("submap", &submap);
  params.section("load", &load);
  params.section("node", &config_);
  params.finish();
  map_ = std::make_unique<occupancy::LocalMap>(map);
  load_ = std::make_unique<pipeline::LoadControl>(load);
  scheduler_ = std::make_unique<pipeline::SubmapScheduler>(submap, std::nullopt);
  scans_ = std::make_unique<PendingScans>(config_.odometry_frame, config_.body_frame, config_.tf_timeout_s,
                                          config_.max_pending_scans, config_.use_deskew);
  advertise();
}

void LocalMapperNodelet::advertise() {
  ros::NodeHandle& nh = getPrivateNodeHandle();
  updates_ = nh.advertise<voxnav::GridUpdate>("map_out", 20);
  handovers_ = nh.advertise<voxnav::Handover>("handover_out", 20);
  occupied_ = nh.advertise<sensor_msgs::PointCloud2>("occupied_out", 1, true);
  octomap_ = nh.advertise<octomap_msgs::Octomap>("octomap_out", 1, true);
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
  uav_state_ = nh.subscribe("uav_state_in", 5, &LocalMapperNodelet::on_uav_state, this, hints);
  if (map_->config().no_return_range_m >= map_->config().resolution_m) {
    open_beams_ =
        nh.subscribe("open_beams_in", config_.max_pending_scans, &LocalMapperNodelet::on_open_beams, this, hints);
  }
  points_ = nh.subscribe("points_in", config_.max_pending_scans, &LocalMapperNodelet::on_points, this, hints);
  retry_ = nh.createSteadyTimer(ros::WallDuration(kRetryPeriod_s), [this](const ros::SteadyTimerEvent&) { process(); });
}

void LocalMapperNodelet::on_points(const sensor_msgs::PointCloud2ConstPtr& msg) {
  try {
    if (const auto dropped = scans_->add(msg))
      drop(dropped->header.stamp, "more scans wait for tf than max_pending_scans");
  } catch (const std::exception& error) {
    drop(msg->header.stamp, error.what());
  }
  process();
}

/// Those of scans that were dropped age out.
void LocalMapperNodelet::on_open_beams(const sensor_msgs::PointCloud2ConstPtr& msg) {
  open_beams_of_.push_back(msg);
  if (open_beams_of_.size() > static_cast<std::size_t>(config_.max_pending_scans) + 1) open_beams_of_.pop_front();
  process();
}

/// They come on a connection of their own, sooner or later than the points.
bool LocalMapperNodelet::is_waiting_for_open_beams() const {
  const auto oldest = scans_->oldest();
  if (!oldest || oldest->age_s > config_.tf_timeout_s || open_beams_.getNumPublishers() == 0) return false;
  return std::none_of(open_beams_of_.begin(), open_beams_of_.end(),
                      [&](const auto& msg) { return msg->header.stamp >= oldest->stamp; });
}

std::vector<float> LocalMapperNodelet::open_beams_at(const ros::Time& stamp) const {
  for (const auto& msg : open_beams_of_) {
    if (msg->header.stamp == stamp) return read_points(*msg).xyz;
  }
  return {};
}

void LocalMapperNodelet::process() {
  while (!is_waiting_for_open_beams()) {
    PendingScans::Next next = scans_->next();
    if (next.dropped) {
      drop(next.dropped->header.stamp, next.reason);
    } else if (next.scan) {
      insert(&*next.scan);
    } else {
      return;
    }
  }
}

void LocalMapperNodelet::insert(LocatedScan* scan) {
  const ros::Time& stamp = scan->msg->header.stamp;
  const double start_s = clock().now_s();
  if (!watch_clock(stamp)) return;
  watch_jump(scan->T_O_B);
  thin_out(&scan->points);
  {
    const auto timer = diagnostics().time("insert");
    ScanPoints& points = scan->points;
    pipeline::deskew(voxnav::geometry::view_of_rows(&points.xyz), points.time_offsets_ns, scan->motion);
    const std::vector<float> open = open_beams_at(stamp);
    report(map_->insert(voxnav::geometry::view_of_rows(points.xyz), pipeline::middle_of(scan->motion),
                        voxnav::geometry::view_of_rows(open)));
    if (config_.vehicle_radius_m > 0.0) map_->mark_free(scan->T_O_B.translation(), config_.vehicle_radius_m);
  }
  diagnostics().add_latency("insert", stamp);
  publish_map(stamp);
  {
    const auto timer = diagnostics().time("handover");
    hand_over(scheduler_->add_scan(map_.get(), to_ns(stamp), scan->T_O_B));
  }
  publish_pictures(stamp);
  watch_load(clock().now_s() - start_s, stamp);
  publish_progress(stamp);
}

/// First scans get coarser, and only then are some dropped (max_pending_scans); both are reported.
void LocalMapperNodelet::thin_out(ScanPoints* points) {
  if (load_->decimation() == 1) return;
  load_->thin_out(3, &points->xyz);
  load_->thin_out(1, &points->time_offsets_ns);
}

std_msgs::Header LocalMapperNodelet::header(const ros::Time& stamp) const {
  std_msgs::Header out;
  out.frame_id = config_.odometry_frame;
  out.stamp = stamp;
  return out;
}

GridUpdateHeader LocalMapperNodelet::update_header(const ros::Time& stamp) const {
  return {config_.odometry_frame, to_ns(stamp), sequence_, map_->config().resolution_m};
}

/// The first message is one; after that listeners follow the changes, and ask for one when they have missed some.
bool LocalMapperNodelet::is_snapshot_due(const ros::Time& stamp) {
  if (config_.snapshot_period_s <= 0.0 && !last_snapshot_.isZero()) return false;
  return is_due(stamp, config_.snapshot_period_s, &last_snapshot_);
}

void LocalMapperNodelet::publish_map(const ros::Time& stamp) {
  const auto timer = diagnostics().time("publish");
  voxnav::containers::GridUpdate update = map_->take_changes();
  if (is_snapshot_due(stamp)) update = map_->snapshot();
  ++sequence_;
  updates_.publish(to_msg(std::move(update), update_header(stamp)));
}

void LocalMapperNodelet::publish_pictures(const ros::Time& stamp) {
  if (is_due(stamp, config_.occupied_period_s, &last_occupied_)) {
    const std::vector<float> points = map_->occupied_points();
    occupied_.publish(xyz_cloud_of(voxnav::geometry::view_of_rows(points), header(stamp)));
  }
  if (octomap_.getNumSubscribers() == 0 || !is_due(stamp, config_.octomap_period_s, &last_octomap_)) return;
  const auto timer = diagnostics().time("octomap");
  octomap_.publish(octomap_of(*map_, config_.is_octomap_binary, header(stamp)));
}

void LocalMapperNodelet::hand_over(const std::vector<pipeline::Handover>& handovers) {
  for (const pipeline::Handover& handover : handovers) {
    const voxnav::Handover msg = to_msg(handover, config_.odometry_frame);
    announce_work(msg.header.stamp);
    handovers_.publish(msg);
    NODELET_INFO_STREAM("[" << node() << "]: submap " << handover.submap_id
                            << (handover.is_final ? " closed: " : " early: ") << handover.reason << ", "
                            << handover.content.num_occupied() << " occupied voxels");
  }
}

void LocalMapperNodelet::on_quality(const voxnav::OdometryQualityConstPtr& msg) {
  if (msg->state == voxnav::OdometryQuality::COASTING) scheduler_->request_close("odometry");
}

void LocalMapperNodelet::on_uav_state(const mrs_msgs::UavStateConstPtr& msg) {
  if (estimator_iteration_ && *estimator_iteration_ != msg->estimator_iteration) scheduler_->request_close("estimator");
  estimator_iteration_ = msg->estimator_iteration;
}

}  // namespace voxnav_ros

PLUGINLIB_EXPORT_CLASS(voxnav_ros::LocalMapperNodelet, nodelet::Nodelet)
