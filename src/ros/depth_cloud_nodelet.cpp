// SPDX-License-Identifier: BSD-3-Clause
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Image.h>

#include <algorithm>
#include <boost/make_shared.hpp>
#include <optional>
#include <pluginlib/class_list_macros.hpp>

#include "voxnav/cloud/depth_cloud.hpp"
#include "voxnav_ros/cloud_conversions.hpp"
#include "voxnav_ros/messages.hpp"
#include "voxnav_ros/nodelet_base.hpp"

namespace voxnav_ros {
namespace {

constexpr double kLogPeriod_s = 5.0;

voxnav::cloud::CameraInfo from_msg(const sensor_msgs::CameraInfo& msg) {
  voxnav::cloud::CameraInfo out;
  out.width = msg.width;
  out.height = msg.height;
  std::copy(msg.K.begin(), msg.K.end(), out.K.begin());
  std::copy(msg.P.begin(), msg.P.end(), out.P.begin());
  out.binning_x = msg.binning_x;
  out.binning_y = msg.binning_y;
  out.roi_x = msg.roi.x_offset;
  out.roi_y = msg.roi.y_offset;
  out.roi_width = msg.roi.width;
  out.roi_height = msg.roi.height;
  return out;
}

voxnav::cloud::DepthImage view_of(const sensor_msgs::Image& msg) {
  return {msg.encoding, msg.width, msg.height, msg.step, msg.is_bigendian != 0, msg.data.data(), msg.data.size()};
}

}  // namespace

/// The nodelet that takes rectified depth images and publishes them as clouds, for a CloudFilter of their own. Messages
/// arrive one at a time, so no mutex is needed.
class DepthCloudNodelet : public NodeletBase {
 public:
  DepthCloudNodelet() : NodeletBase("DepthCloud") {}

 private:
  void initialize() override {
    voxnav::cloud::DepthCloudConfig config;
    ParamLoader& params = parameters();
    params.section("depth", &config);
    params.finish();
    depth_cloud_ = std::make_unique<voxnav::cloud::DepthCloud>(config);
    ros::NodeHandle& nh = getPrivateNodeHandle();
    cloud_ = nh.advertise<sensor_msgs::PointCloud2>("cloud_out", 5);
    image_topic_ = nh.resolveName("image_in");
    info_topic_ = nh.resolveName("camera_info_in");
    for (const char* counter : {"images", "images_refused", "camera_infos_refused"})
      diagnostics().set_counter(counter, 0);
  }

  void start() override {
    ros::NodeHandle& nh = getPrivateNodeHandle();
    const auto hints = ros::TransportHints().tcpNoDelay();
    info_ = nh.subscribe("camera_info_in", 5, &DepthCloudNodelet::on_info, this, hints);
    image_ = nh.subscribe("image_in", 5, &DepthCloudNodelet::on_image, this, hints);
  }

  /// The camera stays what it was until another usable description of it comes.
  void on_info(const sensor_msgs::CameraInfoConstPtr& msg) {
    try {
      camera_ = voxnav::cloud::camera_of(from_msg(*msg));
    } catch (const std::invalid_argument& error) {
      diagnostics().set_counter("camera_infos_refused", static_cast<double>(++num_infos_refused_));
      info_problem_ = error.what();
      complain("message on " + info_topic_ + " refused: " + info_problem_);
    }
  }

  void on_image(const sensor_msgs::ImageConstPtr& msg) {
    try {
      if (msg->header.frame_id.empty()) throw std::invalid_argument("its frame_id is empty");
      if (!camera_) {
        throw std::invalid_argument("there is no camera for it: " +
                                    (info_problem_.empty() ? "nothing came on " + info_topic_ : info_problem_));
      }
      const auto timer = diagnostics().time("convert");
      cloud_.publish(cloud_of(*msg));
      diagnostics().set_counter("images", static_cast<double>(++num_images_));
      diagnostics().set_level(msg::NodeDiagnostics::OK, "");
    } catch (const std::invalid_argument& error) {
      diagnostics().add_dropped("convert");
      diagnostics().set_counter("images_refused", static_cast<double>(++num_images_refused_));
      complain("image on " + image_topic_ + " refused: " + error.what());
    }
    diagnostics().add_latency("convert", msg->header.stamp);
    publish_progress(msg->header.stamp);
  }

  sensor_msgs::PointCloud2Ptr cloud_of(const sensor_msgs::Image& image) {
    auto msg = boost::make_shared<sensor_msgs::PointCloud2>();
    depth_cloud_->convert(view_of(image), *camera_, &msg->data);
    set_layout(depth_cloud_->layout(*camera_), msg.get());
    msg->header = image.header;
    msg->is_dense = 0;
    return msg;
  }

  void complain(const std::string& text) {
    diagnostics().set_level(msg::NodeDiagnostics::ERROR, text);
    NODELET_ERROR_STREAM_THROTTLE(kLogPeriod_s, "[" << node() << "]: " << text);
  }

  std::unique_ptr<voxnav::cloud::DepthCloud> depth_cloud_;
  std::optional<voxnav::cloud::CameraModel> camera_;  // of the newest message that tells one
  std::string info_problem_;                          // of the last message that does not
  std::uint64_t num_images_ = 0, num_images_refused_ = 0, num_infos_refused_ = 0;
  std::string image_topic_, info_topic_;
  ros::Publisher cloud_;
  ros::Subscriber image_, info_;
};

}  // namespace voxnav_ros

PLUGINLIB_EXPORT_CLASS(voxnav_ros::DepthCloudNodelet, nodelet::Nodelet)
