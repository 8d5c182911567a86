// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <vector>

#include "voxnav/odometry/lidar_odometry.hpp"

namespace voxnav::odometry {

/// In the order of Matrix6.
using Vector6 = Eigen::Matrix<double, 6, 1>;

/// One variance for the three axes of the translation and one for those of the rotation.
inline Matrix6 diagonal(double translation_var, double rotation_var) {
  Vector6 d;
  d << geometry::Vec3::Constant(translation_var), geometry::Vec3::Constant(rotation_var);
  return d.asDiagonal();
}

/// The part of one residual that shows in which directions it holds the pose.
struct Contribution {
  geometry::Vec3f normal;  ///< derivative of the residual by translation
  geometry::Vec3f lever;   ///< from the body to the point [m]; lever x normal is the derivative by rotation
};

/// Which motions a set of matches determines.
struct Localizability {
  /// Share of the matches' information (each match counts as one) in each direction of translation, then of rotation,
  /// each smallest first; 1/3 = evenly spread. For a rotation it is the share of what the same points would tell if
  /// they all moved at right angles to their surfaces, so that neither the size of the scene nor the shape of its
  /// cross-section matters.
  std::array<double, 6> eigenvalues{};
  std::vector<geometry::Vec3> weak_translations;  ///< unit vectors, frame O
  std::vector<geometry::Vec3> weak_rotations;     ///< unit axes, frame O

  bool is_degenerate() const { return !weak_translations.empty() || !weak_rotations.empty(); }
};

/// Finds the motions that matches do not determine. Translation and rotation are tested apart, each with the other
/// marginalised out by its Schur complement, because their units and their coupling would hide weak directions in the
/// joint matrix. In each direction found only those matches count that clearly point along it, because the noise of
/// many normals adds up to information that does not exist.
/// @param contributions  of all matches, not empty. They carry no robust weights: these are lowest where a wrong
///                       prediction disagrees with the few surfaces that hold a direction, and would confirm the error
/// @param weak_translation, weak_rotation  eigenvalues below which a direction counts as weak
/// Source: Zhang et al. 2016, "On degeneracy of optimization-based state estimation problems", section IV (eigenvalue
/// test); Tuna et al. 2024, X-ICP, section IV (strong contributions only).
Localizability analyse_localizability(const std::vector<Contribution>& contributions, double weak_translation,
                                      double weak_rotation);

/// Projects the weak directions out of an information matrix.
Matrix6 without_weak_directions(const Matrix6& information, const Localizability& localizability);

}  // namespace voxnav::odometry
