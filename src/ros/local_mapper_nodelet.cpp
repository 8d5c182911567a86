// SPDX-License-Identifier: BSD-3-Clause
#include <mrs_msgs/String.h>
#include <mrs_msgs/UavState.h>
#include <std_srvs/Trigger.h>

#include <algorithm>
#include <deque>
#include <pluginlib/class_list_macros.hpp>

#include "local_map_messages.hpp"
#include "local_mapper_config.hpp"
#include "pending_scans.hpp"
#include "voxnav/GetGrid.h"
#include "voxnav/OdometryQuality.h"
#include "voxnav/pipeline/load_control.hpp"
#include "voxnav_ros/cloud_conversions.hpp"
#include "voxnav_ros/conversions.hpp"
#include "voxnav_ros/grid_conversions.hpp"
#include "voxnav_ros/nodelet_base.hpp"

namespace voxnav_ros {
namespace {

namespace occupancy = voxnav::occupancy;
namespace pipeline = voxnav::pipeline;

constexpr double kLogPeriod_s = 5.0;
constexpr double kRetryPeriod_s = 0.005;
/// Longer than the period of diagnostics, so that the next good scan does not hide a warning.
constexpr double kWarningHold_s = 2.0;

/// Due when `period_s` has passed since the last time, or when time went back.
bool is_due(const ros::Time& now, double period_s, ros::Time* last) {
  if (now >= *last && !last->isZero() && (now - *last).toSec() < period_s) return false;
  *last = now;
  return true;
}

}  // namespace

/// Filtered clouds in, local map out. All callbacks run in the nodelet's single-threaded queue, so no mutex is needed.
class LocalMapperNodelet : public NodeletBase {
 public:
  LocalMapperNodelet() : NodeletBase("LocalMapper") {}
  ~LocalMapperNodelet() override {
    if (map_ && ros::ok()) hand_over(scheduler_->finish(map_.get(), "shutdown"));
  }

 private:
  void initialize() override {
    occupancy::LocalMapConfig map;
    pipeline::SubmapSchedulerConfig submap;
    pipeline::LoadControlConfig load;
    ParamLoader params(getPrivateNodeHandle());
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

  void advertise() {
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

  void start() override {
    ros::NodeHandle& nh = getPrivateNodeHandle();
    const auto hints = ros::TransportHints().tcpNoDelay();
    quality_ = nh.subscribe("odometry_quality_in", 5, &LocalMapperNodelet::on_quality, this, hints);
    uav_state_ = nh.subscribe("uav_state_in", 5, &LocalMapperNodelet::on_uav_state, this, hints);
    if (map_->config().no_return_range_m >= map_->config().resolution_m) {
      open_beams_ =
          nh.subscribe("open_beams_in", config_.max_pending_scans, &LocalMapperNodelet::on_open_beams, this, hints);
    }
    points_ = nh.subscribe("points_in", config_.max_pending_scans, &LocalMapperNodelet::on_points, this, hints);
    retry_ =
        nh.createSteadyTimer(ros::WallDuration(kRetryPeriod_s), [this](const ros::SteadyTimerEvent&) { process(); });
  }

  void on_points(const sensor_msgs::PointCloud2ConstPtr& msg) {
    if (msg->header.stamp < newest_stamp_) time_jumped_back(msg->header.stamp);
    newest_stamp_ = msg->header.stamp;
    try {
      if (const auto dropped = scans_->add(msg))
        drop(dropped->header.stamp, "more scans wait for tf than max_pending_scans");
    } catch (const std::exception& error) {
      drop(msg->header.stamp, error.what());
    }
    process();
  }

  /// Those of scans that were dropped age out.
  void on_open_beams(const sensor_msgs::PointCloud2ConstPtr& msg) {
    open_beams_of_.push_back(msg);
    if (open_beams_of_.size() > static_cast<std::size_t>(config_.max_pending_scans) + 1) open_beams_of_.pop_front();
    process();
  }

  /// They come on a connection of their own, sooner or later than the points.
  bool is_waiting_for_open_beams() const {
    const auto oldest = scans_->oldest();
    if (!oldest || oldest->age_s > config_.tf_timeout_s || open_beams_.getNumPublishers() == 0) return false;
    return std::none_of(open_beams_of_.begin(), open_beams_of_.end(),
                        [&](const auto& msg) { return msg->header.stamp >= oldest->stamp; });
  }

  std::vector<float> open_beams_at(const ros::Time& stamp) const {
    for (const auto& msg : open_beams_of_) {
      if (msg->header.stamp == stamp) return read_points(*msg).xyz;
    }
    return {};
  }

  void process() {
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

  void insert(LocatedScan* scan) {
    const ros::Time& stamp = scan->msg->header.stamp;
    const ros::SteadyTime start = ros::SteadyTime::now();
    watch_jump(scan->T_O_B);
    thin_out(&scan->points);
    {
      const auto timer = diagnostics().time("insert");
      ScanPoints& points = scan->points;
      pipeline::deskew(points.xyz.data(), points.time_offsets_ns.data(), points.xyz.size() / 3, 3, scan->motion);
      const std::vector<float> open = open_beams_at(stamp);
      report(map_->insert(points.xyz.data(), points.xyz.size() / 3, 3, open.data(), open.size() / 3,
                          pipeline::middle_of(scan->motion)));
      if (config_.vehicle_radius_m > 0.0) map_->mark_free(scan->T_O_B.translation(), config_.vehicle_radius_m);
    }
    diagnostics().add_latency("insert", stamp);
    publish_map(stamp);
    {
      const auto timer = diagnostics().time("handover");
      hand_over(scheduler_->add_scan(map_.get(), to_ns(stamp), scan->T_O_B));
    }
    publish_pictures(stamp);
    watch_load((ros::SteadyTime::now() - start).toSec(), stamp);
    publish_progress(stamp);
  }

  /// First scans get coarser, and only then are some dropped (max_pending_scans); both are reported.
  void thin_out(ScanPoints* points) {
    if (load_->decimation() == 1) return;
    load_->thin_out(3, &points->xyz);
    load_->thin_out(1, &points->time_offsets_ns);
  }

  /// In lock-step time waits for the map: nothing is late, and flights must not depend on the machine.
  void watch_load(double work_s, const ros::Time& stamp) {
    if (!config_.lockstep_consumers.empty()) return;
    if (!last_inserted_.isZero()) load_->add(work_s, (stamp - last_inserted_).toSec());
    last_inserted_ = stamp;
    diagnostics().set_counter("decimation", load_->decimation());
    if (load_->decimation() > 1) {
      warn("overloaded: every " + std::to_string(load_->decimation()) + "th point of a scan is used");
    }
  }

  void report(const occupancy::InsertStatistics& s) {
    diagnostics().set_counter("points_not_finite", static_cast<double>(num_not_finite_ += s.rejected_not_finite));
    diagnostics().set_counter("points_too_near", static_cast<double>(num_too_near_ += s.rejected_too_near));
    diagnostics().set_counter("points_far", static_cast<double>(num_far_ += s.far));
    diagnostics().set_counter("cells_hit", static_cast<double>(s.cells_hit));
    diagnostics().set_counter("cells_missed", static_cast<double>(s.cells_missed));
    diagnostics().set_counter("cells_freed", static_cast<double>(s.cells_freed));
    diagnostics().set_counter("blocks_evicted_dropped", static_cast<double>(map_->num_evicted_dropped()));
    diagnostics().set_counter("map_mb", static_cast<double>(map_->memory_bytes()) * 1e-6);
    if (ros::SteadyTime::now() > warned_ + ros::WallDuration(kWarningHold_s)) {
      diagnostics().set_level(voxnav::NodeDiagnostics::OK, "");
    }
  }

  std_msgs::Header header(const ros::Time& stamp) const {
    std_msgs::Header out;
    out.frame_id = config_.odometry_frame;
    out.stamp = stamp;
    return out;
  }

  GridUpdateHeader update_header(const ros::Time& stamp) const {
    return {config_.odometry_frame, to_ns(stamp), sequence_, map_->config().resolution_m};
  }

  void publish_map(const ros::Time& stamp) {
    const auto timer = diagnostics().time("publish");
    voxnav::containers::GridUpdate update = map_->take_changes();
    if (is_due(stamp, config_.snapshot_period_s, &last_snapshot_)) update = map_->snapshot();
    ++sequence_;
    updates_.publish(to_msg(std::move(update), update_header(stamp)));
  }

  void publish_pictures(const ros::Time& stamp) {
    if (is_due(stamp, config_.occupied_period_s, &last_occupied_)) {
      const std::vector<float> points = map_->occupied_points();
      occupied_.publish(xyz_cloud_of(points.data(), points.size() / 3, header(stamp)));
    }
    if (octomap_.getNumSubscribers() == 0 || !is_due(stamp, config_.octomap_period_s, &last_octomap_)) return;
    const auto timer = diagnostics().time("octomap");
    octomap_.publish(octomap_of(*map_, config_.is_octomap_binary, header(stamp)));
  }

  void hand_over(const std::vector<pipeline::Handover>& handovers) {
    for (const pipeline::Handover& handover : handovers) {
      const voxnav::Handover msg = to_msg(handover, config_.odometry_frame);
      announce_work(config_.lockstep_consumers, msg.header.stamp);
      handovers_.publish(msg);
      NODELET_INFO_STREAM("[" << node() << "]: submap " << handover.submap_id
                              << (handover.is_final ? " closed: " : " early: ") << handover.reason << ", "
                              << handover.content.num_occupied() << " occupied voxels");
    }
  }

  /// Hands everything over before it is forgotten.
  void restart(const std::string& reason, const std::string& text) {
    hand_over(scheduler_->finish(map_.get(), reason));
    map_->clear();
    last_body_.reset();
    diagnostics().set_counter("map_clears", static_cast<double>(++num_clears_));
    warn("map cleared: " + text);
  }

  void time_jumped_back(const ros::Time& stamp) {
    scans_->clear();
    restart("odometry",
            "time jumped back from " + std::to_string(newest_stamp_.toSec()) + " to " + std::to_string(stamp.toSec()));
  }

  void watch_jump(const voxnav::geometry::Pose& T_O_B) {
    const voxnav::geometry::Vec3 now = T_O_B.translation();
    if (last_body_ && (now - *last_body_).norm() > config_.max_jump_m) {
      restart("odometry", "the pose jumped by " + std::to_string((now - *last_body_).norm()) + " m");
    }
    last_body_ = now;
  }

  void drop(const ros::Time& stamp, const std::string& reason) {
    diagnostics().add_dropped("insert");
    warn("scan dropped: " + reason);
    publish_progress(stamp);
  }

  void warn(const std::string& text) {
    warned_ = ros::SteadyTime::now();
    diagnostics().set_level(voxnav::NodeDiagnostics::WARN, text);
    NODELET_WARN_STREAM_THROTTLE(kLogPeriod_s, "[" << node() << "]: " << text);
  }

  void on_quality(const voxnav::OdometryQualityConstPtr& msg) {
    if (msg->state == voxnav::OdometryQuality::COASTING) scheduler_->request_close("odometry");
  }

  void on_uav_state(const mrs_msgs::UavStateConstPtr& msg) {
    if (estimator_iteration_ && *estimator_iteration_ != msg->estimator_iteration)
      scheduler_->request_close("estimator");
    estimator_iteration_ = msg->estimator_iteration;
  }

  bool on_get_map(voxnav::GetGrid::Request&, voxnav::GetGrid::Response& response) {
    response.success = true;
    response.grid = to_msg(map_->snapshot(), update_header(newest_stamp_));
    return true;
  }

  bool on_save(mrs_msgs::String::Request& request, mrs_msgs::String::Response& response) {
    return answer(&response, "saved to " + request.value, [&] { map_->save(request.value); });
  }

  bool on_load(mrs_msgs::String::Request& request, mrs_msgs::String::Response& response) {
    return answer(&response, "loaded from " + request.value, [&] {
      occupancy::LocalMap loaded = occupancy::LocalMap::load(request.value);
      if (loaded.config().resolution_m != map_->config().resolution_m) {
        throw std::invalid_argument("its resolution is not that of this map");
      }
      restart("shutdown", "replaced by " + request.value);
      *map_ = std::move(loaded);
      last_snapshot_ = ros::Time();
    });
  }

  bool on_reset(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
    return answer(&response, "cleared", [&] { restart("shutdown", "by service"); });
  }

  bool on_close_submap(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
    return answer(&response, "closed", [&] {
      const auto handovers = scheduler_->finish(map_.get(), "shutdown");
      if (handovers.empty()) throw std::runtime_error("no submap is open");
      hand_over(handovers);
    });
  }

  /// Refusals are answers with a reason, not failed calls.
  template <class Response, class Action>
  bool answer(Response* response, const std::string& done, Action action) {
    try {
      action();
      response->success = true;
      response->message = done;
    } catch (const std::exception& error) {
      response->success = false;
      response->message = error.what();
    }
    return true;
  }

  LocalMapperConfig config_;
  std::unique_ptr<occupancy::LocalMap> map_;
  std::unique_ptr<pipeline::SubmapScheduler> scheduler_;
  std::unique_ptr<pipeline::LoadControl> load_;
  std::unique_ptr<PendingScans> scans_;
  std::optional<voxnav::geometry::Vec3> last_body_;
  std::optional<std::uint32_t> estimator_iteration_;
  std::uint32_t sequence_ = 0;
  std::uint64_t num_not_finite_ = 0, num_too_near_ = 0, num_far_ = 0, num_clears_ = 0;
  ros::SteadyTime warned_;
  ros::Time last_inserted_, newest_stamp_, last_snapshot_, last_occupied_, last_octomap_;
  ros::Publisher updates_, handovers_, occupied_, octomap_;
  std::vector<ros::ServiceServer> services_;
  ros::Subscriber points_, open_beams_, quality_, uav_state_;
  std::deque<sensor_msgs::PointCloud2ConstPtr> open_beams_of_;
  ros::SteadyTimer retry_;
};

}  // namespace voxnav_ros

PLUGINLIB_EXPORT_CLASS(voxnav_ros::LocalMapperNodelet, nodelet::Nodelet)
