// SPDX-License-Identifier: BSD-3-Clause
/// The only source that sees PCL's registration, whose headers take long to compile.
#include "odometry/scan_matcher.hpp"

#include <pcl/kdtree/kdtree_flann.h>
#include <pcl/point_types.h>
#include <pcl/registration/gicp.h>
#include <pcl/registration/icp.h>

#include <cmath>

namespace voxnav::odometry {
namespace {

using PclCloud = pcl::PointCloud<pcl::PointXYZ>;

PclCloud::Ptr to_pcl(const std::vector<geometry::Vec3f>& points) {
  PclCloud::Ptr cloud(new PclCloud);
  cloud->reserve(points.size());
  for (const geometry::Vec3f& p : points) cloud->push_back(pcl::PointXYZ(p.x(), p.y(), p.z()));
  return cloud;
}

/// pcl::IterativeClosestPoint, or pcl::GeneralizedIterativeClosestPoint, from scan to scan.
/// Source: Besl and McKay, A method for registration of 3-D shapes, PAMI 1992; Segal et al., Generalized-ICP, RSS 2009.
template <class Registration>
class PclMatcher : public ScanMatcher {
 public:
  explicit PclMatcher(const LidarOdometryConfig& config) : inlier_distance_m_(config.inlier_distance_m) {
    registration_.setMaximumIterations(config.max_iterations);
    registration_.setMaxCorrespondenceDistance(config.max_correspondence_distance);
    registration_.setTransformationEpsilon(config.transformation_epsilon);
  }

  ScanMatch match(const std::vector<geometry::Vec3f>& source, const std::vector<geometry::Vec3f>& target,
                  const geometry::Pose& guess_T_target_source) override {
    const PclCloud::Ptr from = to_pcl(source), to = to_pcl(target);
    PclCloud moved;
    registration_.setInputSource(from);
    registration_.setInputTarget(to);
    registration_.align(moved, guess_T_target_source.matrix().cast<float>());
    ScanMatch out;
    out.has_converged = registration_.hasConverged();
    out.iterations = registration_.iterations();
    const Eigen::Matrix4d found = registration_.getFinalTransformation().template cast<double>();
    if (!found.allFinite()) out.has_converged = false;
    if (!out.has_converged) return out;
    // PCL multiplies in single precision, so that its rotation is one only nearly.
    out.T_target_source.linear() = Eigen::Quaterniond(found.topLeftCorner<3, 3>()).normalized().toRotationMatrix();
    out.T_target_source.translation() = found.topRightCorner<3, 1>();
    judge(moved, to, &out);
    return out;
  }

 private:
  struct Counted : Registration {
    int iterations() const { return this->nr_iterations_; }
  };

  void judge(const PclCloud& moved, const PclCloud::ConstPtr& target, ScanMatch* out) const {
    pcl::KdTreeFLANN<pcl::PointXYZ> tree;
    tree.setInputCloud(target);
    std::vector<int> index(1);
    std::vector<float> distance_sq(1);
    double sum = 0.0;
    for (const pcl::PointXYZ& p : moved) {
      if (tree.nearestKSearch(p, 1, index, distance_sq) < 1) continue;
      if (distance_sq[0] > inlier_distance_m_ * inlier_distance_m_) continue;
      sum += distance_sq[0];
      ++out->num_inliers;
    }
    if (out->num_inliers > 0) out->residual_m = std::sqrt(sum / out->num_inliers);
  }

  Counted registration_;
  double inlier_distance_m_;
};

}  // namespace
}  // namespace voxnav::odometry

/// Called by make_scan_matcher() once the library is loaded.
extern "C" voxnav::odometry::ScanMatcher* voxnav_make_scan_matcher(
    const voxnav::odometry::LidarOdometryConfig& config) {
  using Point = pcl::PointXYZ;
  if (config.registration == voxnav::odometry::RegistrationMethod::kGicp) {
    return new voxnav::odometry::PclMatcher<pcl::GeneralizedIterativeClosestPoint<Point, Point>>(config);
  }
  return new voxnav::odometry::PclMatcher<pcl::IterativeClosestPoint<Point, Point>>(config);
}
