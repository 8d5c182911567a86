// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/registration.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "odometry/imu_buffer.hpp"

namespace voxnav::odometry {
namespace {

using geometry::Pose;
using geometry::Vec3;

constexpr int kCoarsePoints = 800;
constexpr double kCoarseStep = 1e-2;
constexpr double kFineStep = 5e-4;
/// A last step longer than this means that the pose has not settled.
constexpr double kSettledStep = 2e-2;

/// One linearisation of all matches.
struct Linear {
  Matrix6 H = Matrix6::Zero();
  Vector6 b = Vector6::Zero();
  double inlier_sq_sum = 0.0;
  int num_judged = 0;  // points with a surface near by, and points with nothing near by at all
  int num_matched = 0;
  int num_inliers = 0;
};

/// Adds the residual n . (p - anchor) of a point p that lies at `lever` from the body.
void add_plane(const Vec3& n, const Vec3& lever, double residual, double kernel_sq, Linear* sum,
               std::vector<Contribution>* contributions) {
  const double shrink = kernel_sq / (kernel_sq + residual * residual);
  const double weight = shrink * shrink;
  Vector6 J;
  J << n, lever.cross(n);
  sum->H.noalias() += weight * J * J.transpose();
  sum->b.noalias() -= weight * residual * J;
  contributions->push_back({n.cast<float>(), lever.cast<float>()});
}

/// Two unit vectors at right angles to a line and to each other.
void across(const Vec3& axis, Vec3* u, Vec3* v) {
  *u = axis.unitOrthogonal();
  *v = axis.cross(*u);
}

class Registration {
 public:
  Registration(const std::vector<Vec3f>& points, const PosePrior& prior, const LidarOdometryConfig& config,
               std::uint32_t scan, PointMap* map)
      : points_(points), prior_(prior), config_(config), scan_(scan), map_(map) {
    result_.T_O_B = prior.T_O_B;
  }

  RegistrationResult run() {
    const int size = static_cast<int>(points_.size());
    const double gate = std::max(3.0 * prior_.sigma_m, config_.min_threshold_m);
    iterate(std::max(1, size / kCoarsePoints), gate, kCoarseStep, config_.max_iterations / 2);
    iterate(std::max(1, (size + config_.max_source_points - 1) / config_.max_source_points), gate, kFineStep,
            config_.max_iterations - config_.max_iterations / 2);
    return result_;
  }

 private:
  void iterate(int stride, double gate_m, double stop_step, int max_iterations) {
    for (int i = 0; i < max_iterations; ++i) {
      const Linear linear = linearise(stride, gate_m);
      note(linear);
      if (linear.num_matched < config_.min_matched_points / 4) return;
      const Vector6 step = solve(linear);
      if (!step.allFinite()) return;
      apply(step);
      ++result_.iterations;
      result_.has_converged = step.norm() < kSettledStep;
      if (step.norm() < stop_step) return;
    }
  }

  Linear linearise(int stride, double gate_m) {
    Linear sum;
    contributions_.clear();
    const Eigen::Isometry3f T = result_.T_O_B.cast<float>();
    const Vec3f origin = T.translation();
    // The kernel narrows with the gate, which is never narrower than the noise allows.
    const double kernel = gate_m / 3.0;
    result_.num_points = 0;
    for (std::size_t i = 0; i < points_.size(); i += static_cast<std::size_t>(stride)) {
      ++result_.num_points;
      const Vec3f p = T * points_[i];
      MapPoint* near = map_->nearest(p, gate_m);
      if (!near) {
        ++sum.num_judged;
        continue;
      }
      map_->update_shape(near, prior_.sensor_up_O, scan_);
      if (near->shape != Shape::kUnknown) add_match(*near, p, origin, kernel * kernel, &sum);
    }
    return sum;
  }

  void add_match(const MapPoint& near, const Vec3f& p, const Vec3f& origin, double kernel_sq, Linear* sum) {
    const Vec3 lever = (p - origin).cast<double>();
    const Vec3 offset = (p - near.anchor).cast<double>();
    const Vec3 direction = near.direction.cast<double>();
    double distance = direction.dot(offset);
    if (near.shape == Shape::kPlane) {
      add_plane(direction, lever, distance, kernel_sq, sum, &contributions_);
    } else {
      Vec3 u, v;
      across(direction, &u, &v);
      add_plane(u, lever, u.dot(offset), kernel_sq, sum, &contributions_);
      add_plane(v, lever, v.dot(offset), kernel_sq, sum, &contributions_);
      distance = std::hypot(u.dot(offset), v.dot(offset));
    }
    ++sum->num_judged;
    ++sum->num_matched;
    if (std::abs(distance) > config_.inlier_distance_m) return;
    ++sum->num_inliers;
    sum->inlier_sq_sum += distance * distance;
  }

  void note(const Linear& linear) {
    result_.num_matched = linear.num_matched;
    result_.num_inliers = linear.num_inliers;
    result_.inlier_ratio = linear.num_judged > 0 ? static_cast<double>(linear.num_inliers) / linear.num_judged : 0.0;
    result_.residual_m = linear.num_inliers > 0 ? std::sqrt(linear.inlier_sq_sum / linear.num_inliers) : 0.0;
    result_.information = linear.H;
    if (linear.num_matched < config_.min_matched_points / 4) return;
    result_.localizability = analyse_localizability(contributions_, config_.weak_translation, config_.weak_rotation);
  }

  /// The step that fits the matches and the prior best, with weak directions held at the prediction.
  Vector6 solve(const Linear& linear) const {
    const double noise_var = config_.measurement_noise_m * config_.measurement_noise_m;
    Vector6 to_prior;
    to_prior << prior_.T_O_B.translation() - result_.T_O_B.translation(),
        log_so3(Eigen::Quaterniond(prior_.T_O_B.linear() * result_.T_O_B.linear().transpose()));
    Matrix6 H = linear.H / noise_var + prior_.information;
    Vector6 b = linear.b / noise_var + prior_.information * to_prior;
    const double hold = 1e4 * H.diagonal().maxCoeff();
    for (const Vec3& v : result_.localizability.weak_translations) {
      H.topLeftCorner<3, 3>() += hold * v * v.transpose();
      b.head<3>() += hold * v * v.dot(to_prior.head<3>());
    }
    for (const Vec3& v : result_.localizability.weak_rotations) {
      H.bottomRightCorner<3, 3>() += hold * v * v.transpose();
      b.tail<3>() += hold * v * v.dot(to_prior.tail<3>());
    }
    return H.ldlt().solve(b);
  }

  void apply(const Vector6& step) {
    result_.T_O_B.translation() += step.head<3>();
    const Eigen::Quaterniond rotated = exp_so3(step.tail<3>()) * Eigen::Quaterniond(result_.T_O_B.linear());
    result_.T_O_B.linear() = rotated.normalized().toRotationMatrix();
  }

  const std::vector<Vec3f>& points_;
  const PosePrior& prior_;
  const LidarOdometryConfig& config_;
  std::uint32_t scan_;
  PointMap* map_;
  RegistrationResult result_;
  std::vector<Contribution> contributions_;  // of the last linearisation
};

}  // namespace

RegistrationResult register_scan(const std::vector<geometry::Vec3f>& points_B, const PosePrior& prior,
                                 const LidarOdometryConfig& config, std::uint32_t scan, PointMap* map) {
  return Registration(points_B, prior, config, scan, map).run();
}

}  // namespace voxnav::odometry
