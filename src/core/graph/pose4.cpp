// SPDX-License-Identifier: BSD-3-Clause
#include "graph/pose4.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <stdexcept>
#include <string>

namespace voxnav::graph {
namespace {

constexpr double kMinVerticalCosine = 0.9986;  // of a tilt of 3 degrees

Eigen::Matrix3d rotation(double yaw_rad) { return Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()).matrix(); }

template <class Matrix>
void check_symmetric(const Matrix& matrix, const char* what) {
  const double scale = matrix.cwiseAbs().maxCoeff();
  if (!matrix.allFinite() || (matrix - matrix.transpose()).cwiseAbs().maxCoeff() > 1e-6 * scale + 1e-12) {
    throw std::invalid_argument(std::string(what) + " must be finite and symmetric");
  }
}

}  // namespace

Pose4 to_pose4(const geometry::Pose& T_A_B, const char* what) {
  if (!geometry::is_valid(T_A_B)) throw std::invalid_argument(std::string(what) + " must be a finite rigid transform");
  if (T_A_B.linear()(2, 2) < kMinVerticalCosine) {
    throw std::invalid_argument(std::string(what) + " must be gravity-aligned (roll = pitch = 0)");
  }
  Pose4 out;
  out << T_A_B.translation(), geometry::yaw_of(T_A_B);
  return out;
}

geometry::Pose to_pose(const Pose4& T_A_B) { return geometry::from_position_yaw(T_A_B.head<3>(), T_A_B[3]); }

Pose4 relative(const Pose4& T_W_A, const Pose4& T_W_B) {
  Pose4 out;
  out << rotation(T_W_A[3]).transpose() * (T_W_B.head<3>() - T_W_A.head<3>()),
      geometry::wrap_angle(T_W_B[3] - T_W_A[3]);
  return out;
}

Pose4 compose(const Pose4& T_A_B, const Pose4& T_B_C) {
  Pose4 out;
  out << T_A_B.head<3>() + rotation(T_A_B[3]) * T_B_C.head<3>(), geometry::wrap_angle(T_A_B[3] + T_B_C[3]);
  return out;
}

Matrix4 whitening_of(const Matrix4& information, const char* what) {
  check_symmetric(information, what);
  const Matrix4 symmetric = 0.5 * (information + information.transpose());
  const Eigen::LLT<Matrix4> cholesky(symmetric);
  if (cholesky.info() == Eigen::Success) return cholesky.matrixU();
  const Eigen::SelfAdjointEigenSolver<Matrix4> eigen(symmetric);
  if (eigen.eigenvalues()[0] < -1e-9 * symmetric.cwiseAbs().maxCoeff()) {
    throw std::invalid_argument(std::string(what) + " must not have negative eigenvalues");
  }
  return eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal() * eigen.eigenvectors().transpose();
}

Eigen::Matrix3d whitening_of_covariance(const Eigen::Matrix3d& covariance, const char* what) {
  check_symmetric(covariance, what);
  const Eigen::LLT<Eigen::Matrix3d> cholesky(0.5 * (covariance + covariance.transpose()));
  if (cholesky.info() != Eigen::Success) throw std::invalid_argument(std::string(what) + " must be positive definite");
  // covariance = L Lᵀ, so information = L⁻ᵀ L⁻¹ and the whitening matrix is L⁻¹.
  return cholesky.matrixL().solve(Eigen::Matrix3d::Identity());
}

}  // namespace voxnav::graph
