// SPDX-License-Identifier: BSD-3-Clause
#include <nav_msgs/Odometry.h>
#include <sensor_msgs/PointCloud2.h>
#include <tf2_ros/static_transform_broadcaster.h>

#include <optional>
#include <pluginlib/class_list_macros.hpp>

#include "voxnav/MoveVehicle.h"
#include "voxnav/Progress.h"
#include "voxnav_ros/cloud_conversions.hpp"
#include "voxnav_ros/conversions.hpp"
#include "voxnav_ros/messages.hpp"
#include "voxnav_ros/nodelet_base.hpp"
#include "voxnav_simulation/cloud_encoder.hpp"
#include "voxnav_simulation/lidar_simulator_config.hpp"
#include "voxnav_simulation/losses.hpp"
#include "voxnav_simulation/sweep_scheduler.hpp"
#include "world_markers.hpp"

namespace voxnav_ros {
namespace {

using voxnav_simulation::DriverLayout;

constexpr double kLogPeriod_s = 5.0;
// True poses that may wait while a turn is computed; they come at 250 Hz.
constexpr int kTruthQueue = 1000;
constexpr std::uint64_t kLossStream = 0x6c6f737300;
// Nothing is lost for so long after the first turn, so that all nodes have reported for themselves before.
constexpr voxnav::base::StampNs kLossFree_ns = 10'000'000'000;

sensor_msgs::PointCloud2Ptr to_msg(voxnav_simulation::EncodedCloud&& cloud, const std_msgs::Header& header) {
  auto msg = boost::make_shared<sensor_msgs::PointCloud2>();
  msg->header = header;
  set_layout({cloud.height, cloud.width, cloud.point_step, 0, false, cloud.fields}, msg.get());
  msg->is_dense = cloud.is_dense;
  msg->data = std::move(cloud.data);
  return msg;
}

}  // namespace

/// The nodelet that takes true poses and publishes clouds of the simulated world. True poses arrive on one topic, one
/// message at a time, so only the scene is shared between callbacks, and the scene is thread-safe.
class LidarSimulatorNodelet : public NodeletBase {
 public:
  LidarSimulatorNodelet() : NodeletBase("LidarSimulator") {}

 private:
  void initialize() override {
    voxnav_simulation::LidarConfig lidar;
    ParamLoader& params = parameters();
    params.section("lidar", &lidar);
    params.section("node", &config_);
    params.finish();
    if (config_.world_yaml.empty()) throw voxnav::base::ConfigError({"node/world_yaml must name a world file"});
    const auto seed = static_cast<std::uint64_t>(config_.seed);
    scene_ = voxnav_simulation::shared_scene(config_.world_yaml, seed);
    model_ = std::make_unique<voxnav_simulation::LidarModel>(lidar, seed);
    scheduler_ = std::make_unique<voxnav_simulation::SweepScheduler>(*model_, config_.layout == DriverLayout::kGazebo);
    ros::NodeHandle& nh = getPrivateNodeHandle();
    cloud_ = nh.advertise<sensor_msgs::PointCloud2>("cloud_out", 5);
    markers_ = nh.advertise<visualization_msgs::MarkerArray>("world_markers_out", 1, true);
    movers_ = nh.advertise<visualization_msgs::MarkerArray>("movers_out", 5);
    publish_mount(lidar.T_B_L());
    if (!config_.waiting_nodes.empty() || !config_.acting_nodes.empty())
      progress_ = nh.advertise<msg::Progress>("progress_out", 50);
    move_vehicle_ = nh.advertiseService("move_vehicle", &LidarSimulatorNodelet::on_move_vehicle, this);
    report_world();
  }

  void start() override {
    for (const std::string& name : config_.other_uavs) {
      const boost::function<void(const nav_msgs::OdometryConstPtr&)> take = [this, name](const auto& msg) {
        scene_->visitors().note(name, to_ns(msg->header.stamp), from_msg(msg->pose.pose.position));
      };
      others_.push_back(getMTPrivateNodeHandle().subscribe<nav_msgs::Odometry>(
          "/" + name + "/uav_simulator/ground_truth", kTruthQueue, take, ros::VoidConstPtr(),
          ros::TransportHints().tcpNoDelay()));
    }
    truth_ = getPrivateNodeHandle().subscribe("ground_truth_in", kTruthQueue, &LidarSimulatorNodelet::on_truth, this,
                                              ros::TransportHints().tcpNoDelay());
  }

  void publish_mount(const voxnav::geometry::Pose& T_B_L) {
    geometry_msgs::TransformStamped mount;
    mount.header.stamp = ros::Time::now();
    mount.header.frame_id = config_.body_frame_id;
    mount.child_frame_id = config_.sensor_frame_id;
    mount.transform = to_transform_msg(T_B_L);
    static_tf_.sendTransform(mount);
  }

  void report_world() {
    const auto& world = scene_->world();
    NODELET_INFO_STREAM("[" << node() << "]: " << config_.world_yaml << ", seed " << config_.seed << ": "
                            << world.counts().num_trees << " trees, " << world.mesh().triangles.size() << " triangles");
    diagnostics().set_counter("world_trees", world.counts().num_trees);
    diagnostics().set_counter("world_triangles", static_cast<double>(world.mesh().triangles.size()));
  }

  void on_truth(const nav_msgs::OdometryConstPtr& msg) {
    const auto pose = from_msg(msg->pose.pose);
    if (!pose) {
      refuse_truth();
      return;
    }
    show_world(msg->header.frame_id);
    scheduler_->add_truth({to_ns(msg->header.stamp), *pose});
    while (const auto sweep = scheduler_->next()) {
      is_lost(*sweep) ? lose(*sweep) : measure(*sweep);
      show_movers(*sweep);
      publish_progress(to_ros(sweep->start_ns));
    }
  }

  bool is_lost(const voxnav_simulation::SimulatedSweep& sweep) {
    if (!first_ns_) first_ns_ = sweep.start_ns;
    if (sweep.start_ns < *first_ns_ + kLossFree_ns) return false;
    return voxnav_simulation::is_lost(config_.loss_ratio, static_cast<std::uint64_t>(config_.seed), kLossStream,
                                      sweep.start_ns);
  }

  /// A cloud that never arrives is nothing to wait for.
  void lose(const voxnav_simulation::SimulatedSweep& sweep) {
    diagnostics().set_counter("clouds_lost", static_cast<double>(++num_lost_));
    for (const std::string& node : config_.waiting_nodes) publish_progress_of(node, sweep.start_ns, false);
    for (const std::string& node : config_.acting_nodes) publish_progress_of(node, sweep.start_ns, true);
  }

  void publish_progress_of(const std::string& node, voxnav::base::StampNs stamp_ns, bool is_begun) {
    msg::Progress progress;
    progress.node = node;
    progress.stamp = to_ros(stamp_ns);
    progress.is_begun = is_begun;
    progress_.publish(progress);
  }

  void measure(const voxnav_simulation::SimulatedSweep& sweep) {
    std_msgs::Header header;
    header.stamp = to_ros(sweep.start_ns);
    header.frame_id = config_.sensor_frame_id;
    {
      const auto timer = diagnostics().time("scan");
      cloud_.publish(to_msg(encode(model_->scan(*scene_, sweep.T_W_L, sweep.index), config_.layout), header));
    }
    diagnostics().add_latency("scan", header.stamp);
    const auto& counts = scheduler_->counts();
    diagnostics().set_counter("truth_gaps", static_cast<double>(counts.truth_gaps));
    diagnostics().set_counter("time_jumps_back", static_cast<double>(counts.time_jumps));
    diagnostics().set_level(msg::NodeDiagnostics::OK, "");
  }

  void refuse_truth() {
    diagnostics().set_counter("truth_refused", static_cast<double>(++num_refused_));
    const std::string text = "a true pose was refused: not finite, or its quaternion is no rotation";
    diagnostics().set_level(msg::NodeDiagnostics::ERROR, text);
    NODELET_ERROR_STREAM_THROTTLE(kLogPeriod_s, "[" << node() << "]: " << text);
  }

  /// Sends the markers of the world once it is known which frame the world is in, and again when that name changes.
  void show_world(const std::string& frame_id) {
    const std::lock_guard<std::mutex> lock(marker_mutex_);
    if (frame_id == world_frame_id_ || frame_id.empty()) return;
    world_frame_id_ = frame_id;
    publish_markers();
  }

  void show_movers(const voxnav_simulation::SimulatedSweep& sweep) {
    if (scene_->world().movers().empty() || movers_.getNumSubscribers() == 0) return;
    const std::lock_guard<std::mutex> lock(marker_mutex_);
    movers_.publish(mover_markers(*scene_, world_frame_id_, sweep.start_ns));
  }

  void publish_markers() {
    if (config_.max_marker_triangles == 0) return;
    markers_.publish(world_markers(*scene_, world_frame_id_, static_cast<std::size_t>(config_.max_marker_triangles)));
  }

  bool on_move_vehicle(voxnav::MoveVehicle::Request& request, voxnav::MoveVehicle::Response& response) {
    response.success = scene_->move_vehicle(request.x, request.y, request.heading_rad);
    if (response.success) {
      response.message = "moved";
      const std::lock_guard<std::mutex> lock(marker_mutex_);
      if (!world_frame_id_.empty()) publish_markers();
    } else {
      response.message = scene_->vehicle_pose() ? "there is no ground at that place" : "this world has no vehicle";
    }
    return true;
  }

  voxnav_simulation::LidarSimulatorConfig config_;
  std::shared_ptr<voxnav_simulation::Scene> scene_;
  std::unique_ptr<voxnav_simulation::LidarModel> model_;
  std::unique_ptr<voxnav_simulation::SweepScheduler> scheduler_;
  std::uint64_t num_refused_ = 0, num_lost_ = 0;
  std::optional<voxnav::base::StampNs> first_ns_;  ///< of the first turn
  std::mutex marker_mutex_;                        ///< guards world_frame_id_ and the order of marker messages
  std::string world_frame_id_;
  tf2_ros::StaticTransformBroadcaster static_tf_;
  ros::Publisher cloud_, markers_, movers_, progress_;
  ros::ServiceServer move_vehicle_;
  ros::Subscriber truth_;
  std::vector<ros::Subscriber> others_;  ///< true poses of other UAVs
};

}  // namespace voxnav_ros

PLUGINLIB_EXPORT_CLASS(voxnav_ros::LidarSimulatorNodelet, nodelet::Nodelet)
