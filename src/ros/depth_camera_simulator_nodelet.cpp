// SPDX-License-Identifier: BSD-3-Clause
#include <nav_msgs/Odometry.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Image.h>
#include <tf2_ros/static_transform_broadcaster.h>

#include <boost/make_shared.hpp>
#include <cmath>
#include <cstring>
#include <pluginlib/class_list_macros.hpp>

#include "voxnav_ros/conversions.hpp"
#include "voxnav_ros/messages.hpp"
#include "voxnav_ros/nodelet_base.hpp"
#include "voxnav_simulation/depth_camera.hpp"
#include "voxnav_simulation/depth_camera_simulator_config.hpp"
#include "voxnav_simulation/sweep_scheduler.hpp"

namespace voxnav_ros {
namespace {

using voxnav::cloud::DepthEncoding;
using voxnav_simulation::DepthPixels;

// True poses that may wait while an image is computed; they come at 250 Hz.
constexpr int kTruthQueue = 1000;
constexpr float kMillimetresPerMetre = 1000.0F;

template <class Number, class Convert>
std::vector<std::uint8_t> bytes_of(const DepthPixels& pixels, Convert convert) {
  std::vector<Number> numbers;
  numbers.reserve(pixels.size());
  for (const float depth_m : pixels) numbers.push_back(convert(depth_m));
  std::vector<std::uint8_t> out(numbers.size() * sizeof(Number));
  std::memcpy(out.data(), numbers.data(), out.size());
  return out;
}

sensor_msgs::ImagePtr to_msg(const DepthPixels& pixels, const voxnav::cloud::CameraModel& camera,
                             DepthEncoding encoding, const std_msgs::Header& header) {
  auto msg = boost::make_shared<sensor_msgs::Image>();
  msg->header = header;
  msg->width = camera.width;
  msg->height = camera.height;
  msg->encoding = voxnav::base::word_of(encoding);
  if (encoding == DepthEncoding::kMetres) {
    msg->data = bytes_of<float>(pixels, [](float m) { return m > 0.0F ? m : std::nanf(""); });
  } else {
    msg->data = bytes_of<std::uint16_t>(
        pixels, [](float m) { return static_cast<std::uint16_t>(std::lround(kMillimetresPerMetre * m)); });
  }
  msg->step = static_cast<std::uint32_t>(msg->data.size() / msg->height);
  return msg;
}

sensor_msgs::CameraInfo info_of(const voxnav::cloud::CameraModel& camera, const std_msgs::Header& header) {
  sensor_msgs::CameraInfo msg;
  msg.header = header;
  msg.width = camera.width;
  msg.height = camera.height;
  msg.distortion_model = "plumb_bob";
  msg.D.assign(5, 0.0);
  msg.K = {camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1};
  msg.R = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  msg.P = {camera.fx, 0, camera.cx, 0, 0, camera.fy, camera.cy, 0, 0, 0, 1, 0};
  return msg;
}

}  // namespace

/// The nodelet that takes true poses and publishes depth images of the simulated world. True poses arrive on one topic,
/// one message at a time, so no mutex is needed.
class DepthCameraSimulatorNodelet : public NodeletBase {
 public:
  DepthCameraSimulatorNodelet() : NodeletBase("DepthCameraSimulator") {}

 private:
  void initialize() override {
    voxnav_simulation::DepthCameraConfig camera;
    ParamLoader& params = parameters();
    params.section("camera", &camera);
    params.section("node", &config_);
    params.finish();
    if (config_.world_yaml.empty()) throw voxnav::base::ConfigError({"node/world_yaml must name a world file"});
    const auto seed = static_cast<std::uint64_t>(config_.seed);
    scene_ = voxnav_simulation::shared_scene(config_.world_yaml, seed);
    model_ = std::make_unique<voxnav_simulation::DepthCameraModel>(camera, seed);
    scheduler_ = std::make_unique<voxnav_simulation::SweepScheduler>(voxnav::base::from_seconds(1.0 / camera.rate_hz),
                                                                     camera.T_B_C());
    ros::NodeHandle& nh = getPrivateNodeHandle();
    image_ = nh.advertise<sensor_msgs::Image>("image_out", 5);
    info_ = nh.advertise<sensor_msgs::CameraInfo>("camera_info_out", 5);
    publish_mount(camera.T_B_C());
  }

  void start() override {
    truth_ = getPrivateNodeHandle().subscribe("ground_truth_in", kTruthQueue, &DepthCameraSimulatorNodelet::on_truth,
                                              this, ros::TransportHints().tcpNoDelay());
  }

  void publish_mount(const voxnav::geometry::Pose& T_B_C) {
    geometry_msgs::TransformStamped mount;
    mount.header.stamp = ros::Time::now();
    mount.header.frame_id = config_.body_frame_id;
    mount.child_frame_id = config_.camera_frame_id;
    mount.transform = to_transform_msg(T_B_C);
    static_tf_.sendTransform(mount);
  }

  void on_truth(const nav_msgs::OdometryConstPtr& msg) {
    const auto pose = from_msg(msg->pose.pose);
    if (!pose) {
      diagnostics().set_counter("truth_refused", static_cast<double>(++num_refused_));
      diagnostics().set_level(msg::NodeDiagnostics::ERROR, "a true pose was refused: not finite, or no rotation");
      return;
    }
    scheduler_->add_truth({to_ns(msg->header.stamp), *pose});
    while (const auto instant = scheduler_->next()) measure(*instant);
  }

  void measure(const voxnav_simulation::SimulatedSweep& instant) {
    std_msgs::Header header;
    header.stamp = to_ros(instant.start_ns);
    header.frame_id = config_.camera_frame_id;
    const voxnav::cloud::CameraModel camera = model_->config().camera();
    {
      const auto timer = diagnostics().time("image");
      info_.publish(info_of(camera, header));
      image_.publish(
          to_msg(model_->image(*scene_, instant.T_W_L.front(), instant.index), camera, config_.encoding, header));
    }
    diagnostics().add_latency("image", header.stamp);
    diagnostics().set_level(msg::NodeDiagnostics::OK, "");
    publish_progress(header.stamp);
  }

  voxnav_simulation::DepthCameraSimulatorConfig config_;
  std::shared_ptr<voxnav_simulation::Scene> scene_;
  std::unique_ptr<voxnav_simulation::DepthCameraModel> model_;
  std::unique_ptr<voxnav_simulation::SweepScheduler> scheduler_;
  std::uint64_t num_refused_ = 0;
  tf2_ros::StaticTransformBroadcaster static_tf_;
  ros::Publisher image_, info_;
  ros::Subscriber truth_;
};

}  // namespace voxnav_ros

PLUGINLIB_EXPORT_CLASS(voxnav_ros::DepthCameraSimulatorNodelet, nodelet::Nodelet)
