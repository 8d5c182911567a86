// SPDX-License-Identifier: BSD-3-Clause
#include <pluginlib/class_list_macros.hpp>

#include "body_learning.hpp"
#include "voxnav/cloud/cloud_filter.hpp"
#include "voxnav/cloud/open_beams.hpp"
#include "voxnav/cloud/pcl_filters.hpp"
#include "voxnav_ros/cloud_conversions.hpp"
#include "voxnav_ros/conversions.hpp"
#include "voxnav_ros/messages.hpp"
#include "voxnav_ros/nodelet_base.hpp"

namespace voxnav_ros {
namespace {

constexpr double kLogPeriod_s = 5.0;

std::string describe(const voxnav::cloud::FilterCounts& counts) {
  std::string out;
  for (const auto& [name, value] : counts.reasons()) {
    if (value > 0) out += (out.empty() ? "" : ", ") + std::to_string(value) + " " + name;
  }
  return out;
}

}  // namespace

/// The nodelet that takes raw clouds and publishes the returns of the surroundings. Messages on one topic arrive one at
/// a time, so no mutex is needed.
class CloudFilterNodelet : public NodeletBase {
 public:
  CloudFilterNodelet() : NodeletBase("CloudFilter") {}

 private:
  void initialize() override {
    voxnav::cloud::CloudFilterConfig config;
    voxnav::cloud::PclFiltersConfig pcl;
    voxnav::cloud::OpenBeamsConfig open_beams;
    voxnav::cloud::BodyMaskConfig body_mask;
    ParamLoader& params = parameters();
    params.section("filter", &config);
    params.section("pcl", &pcl);
    params.section("open_beams", &open_beams);
    params.section("body_mask", &body_mask);
    params.finish();
    if (open_beams.is_enabled) open_beams_ = std::make_unique<voxnav::cloud::OpenBeams>(open_beams);
    filter_ = std::make_unique<voxnav::cloud::CloudFilter>(config);
    pcl_filters_ = voxnav::cloud::make_pcl_filters(pcl);
    ros::NodeHandle& nh = getPrivateNodeHandle();
    points_ = nh.advertise<sensor_msgs::PointCloud2>("points_out", 5);
    rejected_ = nh.advertise<sensor_msgs::PointCloud2>("rejected_out", 5);
    far_ = nh.advertise<sensor_msgs::PointCloud2>("far_out", 5);
    body_learning_ = std::make_unique<BodyLearning>(nh, body_mask);
    topic_ = nh.resolveName("cloud_in");
  }

  void start() override {
    body_learning_->start(getPrivateNodeHandle());
    cloud_ = getPrivateNodeHandle().subscribe("cloud_in", 5, &CloudFilterNodelet::on_cloud, this,
                                              ros::TransportHints().tcpNoDelay());
  }

  void on_cloud(const sensor_msgs::PointCloud2ConstPtr& msg) {
    note_time(msg->header.stamp);
    try {
      if (msg->header.frame_id.empty()) throw std::invalid_argument("frame_id is empty");
      const voxnav::cloud::RawCloudView view = view_of(*msg);
      {
        const auto timer = diagnostics().time("filter");
        filter_->apply(view, &result_);
      }
      apply_pcl_filters();
      if (auto mask = body_learning_->add(view)) take(std::move(*mask));
      publish(*msg, view);
      report();
    } catch (const std::exception& error) {
      refuse(error.what());
    }
    diagnostics().add_latency("filter", msg->header.stamp);
    publish_progress(msg->header.stamp);
  }

  /// Open beams do not pass them: they are found in the raw cloud, and a point that is dropped here opens none.
  void apply_pcl_filters() {
    for (const auto& filter : pcl_filters_) {
      const std::string stage = std::string("pcl ") + voxnav::base::word_of(filter->kind());
      const auto timer = diagnostics().time(stage);
      filter->apply(&result_);
    }
  }

  void take(voxnav::cloud::BodyMask mask) {
    diagnostics().set_counter("body_mask_directions", static_cast<double>(mask.num_covered()));
    NODELET_INFO_STREAM("[" << node() << "]: body mask learnt: " << mask.num_covered() << " directions, up to "
                            << mask.farthest_m() << " m");
    filter_->set_body_mask(std::move(mask));
  }

  void publish(const sensor_msgs::PointCloud2& msg, const voxnav::cloud::RawCloudView& view) {
    std_msgs::Header header = msg.header;
    header.stamp = to_ros(to_ns(msg.header.stamp) + result_.sweep_start_ns);
    if (open_beams_) {
      const auto timer = diagnostics().time("open beams");
      const auto& directions = open_beams_->find(view);
      diagnostics().set_counter("open_beams", static_cast<double>(directions.size()));
      points_.publish(to_msg(result_.points, directions, header));
    } else {
      points_.publish(to_msg(result_.points, header));
    }
    if (rejected_.getNumSubscribers() > 0) rejected_.publish(to_msg(result_.ghosts, header));
    if (far_.getNumSubscribers() > 0) far_.publish(to_msg(result_.far, header));
  }

  void report() {
    total_ += result_.counts;
    num_bad_times_ += result_.num_bad_times;
    for (const auto& [name, value] : total_.reasons()) {
      diagnostics().set_counter(std::string("points_") + name, static_cast<double>(value));
    }
    diagnostics().set_counter("point_times_refused", static_cast<double>(num_bad_times_));
    const std::string untimed = report_times();
    diagnostics().set_counter("ghost_filter_suspended", result_.is_ghost_filter_suspended ? 1.0 : 0.0);
    diagnostics().set_counter("outlier_filter_suspended", result_.is_outlier_filter_suspended ? 1.0 : 0.0);
    if (result_.counts.total > 0 && result_.counts.kept == 0) {
      warn("no point of a cloud on " + topic_ + " was kept: " + describe(result_.counts));
    } else if (!untimed.empty()) {
      warn("point times on " + topic_ + ": " + untimed);
    } else if (result_.is_ghost_filter_suspended) {
      warn("no return on " + topic_ + " has any intensity: the ghost filter is suspended");
    } else if (result_.is_outlier_filter_suspended) {
      warn("most returns on " + topic_ + " have no neighbours in the image: rain and dust are not removed");
    } else {
      diagnostics().set_level(msg::NodeDiagnostics::OK, "");
    }
  }

  /// @return why the times of this cloud were not used; empty when they were, or when it has none
  std::string report_times() {
    const voxnav::cloud::TimesReport& times = filter_->point_times();
    if (times.state != times_state_)
      NODELET_INFO_STREAM("[" << node() << "]: point times on " << topic_ << ": " << times.how);
    times_state_ = times.state;
    diagnostics().set_counter("clouds_untimed", static_cast<double>(times.num_clouds_untimed));
    const bool is_untimed = times.num_clouds_untimed > num_untimed_;
    num_untimed_ = times.num_clouds_untimed;
    return is_untimed ? problem_of(times) : std::string();
  }

  void refuse(const std::string& reason) {
    ++num_refused_;
    diagnostics().add_dropped("filter");
    diagnostics().set_counter("clouds_refused", static_cast<double>(num_refused_));
    const std::string text = "cloud on " + topic_ + " refused: " + reason;
    diagnostics().set_level(msg::NodeDiagnostics::ERROR, text);
    NODELET_ERROR_STREAM_THROTTLE(kLogPeriod_s, "[" << node() << "]: " << text);
  }

  void warn(const std::string& text) {
    diagnostics().set_level(msg::NodeDiagnostics::WARN, text);
    NODELET_WARN_STREAM_THROTTLE(kLogPeriod_s, "[" << node() << "]: " << text);
  }

  void note_time(const ros::Time& stamp) {
    if (stamp < last_stamp_) {
      ++num_time_jumps_;
      NODELET_WARN_STREAM_THROTTLE(kLogPeriod_s, "[" << node() << "]: time on " << topic_ << " jumped back from "
                                                     << last_stamp_ << " to " << stamp);
    }
    last_stamp_ = stamp;
    diagnostics().set_counter("time_jumps_back", static_cast<double>(num_time_jumps_));
  }

  std::unique_ptr<voxnav::cloud::CloudFilter> filter_;
  std::vector<std::unique_ptr<voxnav::cloud::PclFilter>> pcl_filters_;
  std::unique_ptr<voxnav::cloud::OpenBeams> open_beams_;  // null unless open beams are searched
  std::unique_ptr<BodyLearning> body_learning_;
  voxnav::cloud::FilterResult result_;
  voxnav::cloud::FilterCounts total_;
  std::uint64_t num_bad_times_ = 0, num_untimed_ = 0, num_refused_ = 0, num_time_jumps_ = 0;
  voxnav::cloud::TimesState times_state_ = voxnav::cloud::TimesState::kNoField;
  ros::Time last_stamp_;
  std::string topic_;
  ros::Publisher points_, rejected_, far_;
  ros::Subscriber cloud_;
};

}  // namespace voxnav_ros

PLUGINLIB_EXPORT_CLASS(voxnav_ros::CloudFilterNodelet, nodelet::Nodelet)
