// SPDX-License-Identifier: BSD-3-Clause
#include "submap_integrator_nodelet.hpp"

#include <pluginlib/class_list_macros.hpp>

#include "voxnav_ros/cloud_conversions.hpp"
#include "voxnav_ros/conversions.hpp"
#include "voxnav_ros/messages.hpp"
#include "voxnav_ros/submap_conversions.hpp"

namespace voxnav_ros {
namespace {

constexpr double kLogPeriod_s = 5.0;
/// A reset holds for handovers that are this much older at most.
const ros::Duration kResetReach(60.0);

}  // namespace

void SubmapIntegratorNodelet::initialize() {
  ParamLoader& params = parameters();
  params.section("node", &config_);
  params.section("submap", &submap_config_);
  params.section("projective", &projective_config_);
  params.section("collection", &collection_config_);
  params.finish();
  map_frame_ = config_.map_frame;
  origins_.begin(config_.odometry_frame);
  make_assembler();
  map_ = std::make_unique<MergedMap>(collection_config_, config_.safety_distance_m);
  pictures_ = std::make_unique<SubmapPictures>(config_);
  worker_ = std::make_unique<Worker>(static_cast<std::size_t>(config_.max_queue));
  saver_ = std::make_unique<Worker>(1);
  advertise();
}

void SubmapIntegratorNodelet::make_assembler() {
  voxnav::pipeline::SubmapAssemblerConfig config;
  config.submap = submap_config_;
  if (config_.filling == SubmapFilling::kProjective) config.projective = projective_config_;
  config.projective_period_s = config_.projective_period_s;
  config.max_open_submaps = config_.max_open_handovers;
  assembler_ = std::make_unique<voxnav::pipeline::SubmapAssembler>(config);
}

void SubmapIntegratorNodelet::start() {
  ros::NodeHandle& nh = getMTPrivateNodeHandle();
  if (assembler_->is_projective()) {
    tf_ = std::make_unique<tf2_ros::Buffer>();
    tf_listener_ = std::make_unique<tf2_ros::TransformListener>(*tf_);
    points_ =
        nh.subscribe("points_in", 10, &SubmapIntegratorNodelet::on_points, this, ros::TransportHints().tcpNoDelay());
  }
  pictures_->advertise(&nh);
  octomap_.advertise(&nh);
  octomap_timer_ = nh.createSteadyTimer(ros::WallDuration(config_.octomap_period_s),
                                        &SubmapIntegratorNodelet::on_octomap_time, this);
  picture_timer_ = nh.createSteadyTimer(ros::WallDuration(config_.picture_period_s),
                                        &SubmapIntegratorNodelet::on_picture_time, this);
  snapshot_timer_ = nh.createSteadyTimer(ros::WallDuration(config_.snapshot_period_s),
                                         &SubmapIntegratorNodelet::on_snapshot_time, this);
  handover_ =
      nh.subscribe("handover_in", 20, &SubmapIntegratorNodelet::on_handover, this, ros::TransportHints().tcpNoDelay());
  origin_ = nh.subscribe("origin_in", 5, &SubmapIntegratorNodelet::on_origin, this, ros::TransportHints().tcpNoDelay());
  poses_ =
      nh.subscribe("submap_poses_in", 5, &SubmapIntegratorNodelet::on_poses, this, ros::TransportHints().tcpNoDelay());
}

void SubmapIntegratorNodelet::advertise() {
  ros::NodeHandle& nh = getMTPrivateNodeHandle();
  submap_ = nh.advertise<msg::FinishedSubmap>("submap_out", 20);
  obstacles_ = nh.advertise<msg::GridUpdate>("obstacles_out", 20);
  get_obstacles_ = nh.advertiseService("get_obstacles_in", &SubmapIntegratorNodelet::on_get_obstacles, this);
  get_submaps_ = nh.advertiseService("get_submaps_in", &SubmapIntegratorNodelet::on_get_submaps, this);
  save_ = nh.advertiseService("save_in", &SubmapIntegratorNodelet::on_save, this);
  load_ = nh.advertiseService("load_in", &SubmapIntegratorNodelet::on_load, this);
  merge_ = nh.advertiseService("merge_in", &SubmapIntegratorNodelet::on_merge, this);
  export_ = nh.advertiseService("export_in", &SubmapIntegratorNodelet::on_export, this);
  reset_ = nh.advertiseService("reset_in", &SubmapIntegratorNodelet::on_reset, this);
}

/// Queues a task for the worker. An exception of the task, and a full queue, are reported in the diagnostics.
void SubmapIntegratorNodelet::enqueue(const char* what, std::function<void()> task) {
  const std::string name = what;
  const bool is_taken = worker_->push([this, name, task = std::move(task)] {
    try {
      const std::lock_guard<std::mutex> lock(mutex_);
      task();
    } catch (const std::exception& error) {
      refuse(name, error.what());
    }
    diagnostics().set_counter("queue", static_cast<double>(worker_->size()));
  });
  if (!is_taken) refuse(name, "the worker is behind and its queue is full");
}

void SubmapIntegratorNodelet::refuse(const std::string& what, const std::string& reason) {
  diagnostics().add_dropped(what);
  diagnostics().set_level(msg::NodeDiagnostics::ERROR, what + " refused: " + reason);
  NODELET_ERROR_STREAM_THROTTLE(kLogPeriod_s, "[" << node() << "]: " << what << " refused: " << reason);
}

void SubmapIntegratorNodelet::on_handover(const msg::HandoverConstPtr& msg) {
  enqueue("handover", [this, msg] {
    if (was_reset_after(msg->header.stamp)) {
      diagnostics().add_dropped("handover before a reset");
    } else {
      take_handover(from_msg(*msg), msg->header.frame_id);
    }
    diagnostics().add_latency("handover", msg->header.stamp);
    publish_progress(msg->header.stamp);
  });
}

/// Returns true for handovers that the local mapper sent shortly before the map was cleared. Much older stamps are
/// those of a clock that was set back.
bool SubmapIntegratorNodelet::was_reset_after(const ros::Time& stamp) const {
  return reset_at_ && stamp <= *reset_at_ && *reset_at_ - stamp < kResetReach;
}

void SubmapIntegratorNodelet::take_handover(const voxnav::pipeline::Handover& handover, const std::string& frame) {
  const voxnav::geometry::Pose T_now_O = into_origin(frame);
  voxnav::pipeline::SubmapAssembler::Result result;
  if (handover.is_final) {
    const auto timer = diagnostics().time("finish");
    result = assembler_->add(handover);
  } else {
    result = assembler_->add(handover);
  }
  if (result.dropped) {
    diagnostics().add_dropped("early content");
    NODELET_WARN_STREAM_THROTTLE(kLogPeriod_s, "[" << node() << "]: " << *result.dropped);
  }
  if (!result.submap) return;
  result.submap->T_O_S = expressed(T_now_O, result.submap->T_O_S);
  add(std::move(*result.submap));
}

void SubmapIntegratorNodelet::add(submap::SubmapEntry entry) {
  entry.T_W_S = T_W_O_ * entry.T_O_S;
  entry.flight = flight_;
  // After a map was loaded, ids that begin again at a low number are shifted behind the ids of that map.
  if (!id_shift_) id_shift_ = entry.id >= first_id_ ? 0 : first_id_ - entry.id;
  entry.id += *id_shift_;
  const msg::FinishedSubmap msg = to_msg(entry, origins_.frame());
  announce_work(msg.header.stamp);
  submap_.publish(msg);
  newest_id_ = entry.id;
  const ros::Time stamp = to_ros(entry.end_ns);
  map_->collection().add(std::move(entry));
  refresh(stamp);
  if (!config_.autosave_dir.empty() && saver_->size() == 0) saver_->push([this] { autosave(); });
}

/// Updates everything after a change. Obstacles come first, because flights depend on them; pictures follow piece by
/// piece.
void SubmapIntegratorNodelet::refresh(const ros::Time& stamp) {
  last_stamp_ = std::max(last_stamp_, stamp);
  {
    const auto timer = diagnostics().time("obstacles");
    const std::vector<voxnav::geometry::Index3> changed = map_->update();
    if (!changed.empty()) octomap_.mark_changed();
    pictures_->mark(*map_, changed);
  }
  publish_obstacles(map_->take_changes());
  const submap::SubmapCollection& collection = map_->collection();
  diagnostics().set_counter("submaps", static_cast<double>(collection.size()));
  diagnostics().set_counter("submaps_dropped", static_cast<double>(collection.num_dropped()));
  diagnostics().set_counter("memory_mb", static_cast<double>(map_->memory_bytes()) * 1e-6);
  diagnostics().set_counter("obstacle_blocks", static_cast<double>(map_->obstacles().grid().blocks().size()));
  if (collection.num_dropped() > 0) {
    diagnostics().set_level(msg::NodeDiagnostics::WARN,
                            "the map is full: the oldest submaps are dropped (collection/max_*)");
  } else {
    diagnostics().set_level(msg::NodeDiagnostics::OK, "");
  }
}

std_msgs::Header SubmapIntegratorNodelet::header() const {
  std_msgs::Header out;
  out.frame_id = map_frame_;
  out.stamp = last_stamp_;
  return out;
}

msg::GridUpdate SubmapIntegratorNodelet::obstacle_msg(voxnav::containers::GridUpdate update,
                                                      std::uint32_t sequence) const {
  return to_msg(std::move(update), {map_frame_, to_ns(last_stamp_), sequence, collection_config_.resolution_m});
}

void SubmapIntegratorNodelet::publish_obstacles(voxnav::containers::GridUpdate update) {
  if (!update.is_snapshot && update.block_indices.empty() && update.removed_block_indices.empty()) return;
  obstacles_.publish(obstacle_msg(std::move(update), ++sequence_));
}

void SubmapIntegratorNodelet::on_snapshot_time(const ros::SteadyTimerEvent&) {
  enqueue("snapshot", [this] { publish_obstacles(map_->obstacles().snapshot()); });
}

/// Sends pictures only while no other work waits.
void SubmapIntegratorNodelet::on_picture_time(const ros::SteadyTimerEvent&) {
  if (worker_->size() > 0) return;
  enqueue("pictures", [this] {
    const double wall_ms = voxnav::base::wall_clock_ms();
    const double cpu_ms = voxnav::base::thread_cpu_ms();
    if (!pictures_->turn(*map_, header())) return;
    diagnostics().add_time("pictures", voxnav::base::wall_clock_ms() - wall_ms, voxnav::base::thread_cpu_ms() - cpu_ms);
  });
}

/// Sends OctoMaps only while no other work waits.
void SubmapIntegratorNodelet::on_octomap_time(const ros::SteadyTimerEvent&) {
  if (!octomap_.has_readers() || worker_->size() > 0) return;
  enqueue("octomap", [this] {
    const auto timer = diagnostics().time("octomap");
    std_msgs::Header now = header();
    now.stamp = ros::Time::now();
    octomap_.publish(*map_, now);
  });
}

void SubmapIntegratorNodelet::on_poses(const msg::SubmapPosesConstPtr& msg) {
  enqueue("submap poses", [this, msg] {
    take_poses(*msg);
    publish_progress(msg->header.stamp);
  });
}

void SubmapIntegratorNodelet::take_poses(const msg::SubmapPoses& msg) {
  if (msg.submap_ids.size() != msg.T_W_S.size()) throw std::invalid_argument("submap_ids and T_W_S differ in length");
  const auto T_W_O = from_msg(msg.T_W_O);
  if (!T_W_O) throw std::invalid_argument("T_W_O is not a valid pose");
  const std::vector<voxnav::geometry::Pose> poses = valid_poses(msg.T_W_S, "T_W_S");
  const std::vector<voxnav::geometry::Bend> bends = bends_of(msg);
  if (!msg.header.frame_id.empty()) map_frame_ = msg.header.frame_id;
  if (msg.odometry_frame.empty() || msg.odometry_frame == origins_.frame()) T_W_O_ = *T_W_O;
  for (std::size_t i = 0; i < poses.size(); ++i) map_->collection().set_pose(msg.submap_ids[i], poses[i], bends[i]);
  diagnostics().set_counter("graph_revision", msg.revision);
  refresh(msg.header.stamp);
}

void SubmapIntegratorNodelet::on_points(const sensor_msgs::PointCloud2ConstPtr& msg) {
  enqueue("cloud", [this, msg] { integrate(*msg); });
}

void SubmapIntegratorNodelet::integrate(const sensor_msgs::PointCloud2& msg) {
  const auto transform = tf_->lookupTransform(origins_.frame(), msg.header.frame_id, msg.header.stamp,
                                              ros::Duration(config_.tf_timeout_s));
  const auto T_O_L = from_msg(transform.transform);
  if (!T_O_L) throw std::invalid_argument("tf gave no valid pose");
  {
    const std::vector<voxnav::geometry::Vec3f> points_L = sweep_of(msg).points;
    const auto timer = diagnostics().time("integrate");
    assembler_->integrate(points_L, *T_O_L, to_ns(msg.header.stamp));
  }
  if (assembler_->is_due()) close_submap_of_clouds();
  diagnostics().add_latency("cloud", msg.header.stamp);
  publish_progress(msg.header.stamp);
}

void SubmapIntegratorNodelet::close_submap_of_clouds() {
  submap::SubmapEntry entry;
  {
    const auto timer = diagnostics().time("finish");
    entry = assembler_->close();
  }
  add(std::move(entry));
}

}  // namespace voxnav_ros

PLUGINLIB_EXPORT_CLASS(voxnav_ros::SubmapIntegratorNodelet, nodelet::Nodelet)
