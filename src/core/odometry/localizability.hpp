// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <vector>

#include "voxnav/geometry/pose.hpp"

namespace voxnav::odometry {

/// Order everywhere: translation x y z, then rotation x y z, both in the axes of frame O.
using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

/// One residual, as far as it shows in which directions the scan is held.
struct Contribution {
  geometry::Vec3f normal;  ///< derivative by translation
  geometry::Vec3f lever;   ///< from the body to the point [m]; lever x normal is the derivative by rotation
};

/// Which motions a set of matches determines.
struct Localizability {
  /// Share of the matches' information (each match counts as one), translation, then rotation, each smallest first; 1/3
  /// = evenly spread. For a rotation the share of what points could tell that move at right angles to their surface, so
  /// that neither the size of the scene nor the shape of its cross-section counts.
  std::array<double, 6> eigenvalues{};
  std::vector<geometry::Vec3> weak_translations;  ///< unit vectors, frame O
  std::vector<geometry::Vec3> weak_rotations;     ///< unit axes, frame O

  bool is_degenerate() const { return !weak_translations.empty() || !weak_rotations.empty(); }
};

/// @param contributions  of all matches, not empty. Robust weights stay out of it: they are lowest just where a wrong
///                       prediction disagrees with the few surfaces that hold a direction, and would confirm it
/// Translation and rotation are tested apart, each with the other marginalised out by its Schur complement:
/// in the joint matrix their units and their coupling hide weak directions. Of each direction so found only what
/// clearly points along it counts, since the noise of many normals adds up to information that is not there.
/// Source: Zhang et al. 2016, "On degeneracy of optimization-based state estimation problems", section IV (eigenvalue
/// test); Tuna et al. 2024, X-ICP, section IV (strong contributions only).
Localizability analyse_localizability(const std::vector<Contribution>& contributions, double weak_translation,
                                      double weak_rotation);

/// Removes from an information matrix what it says about weak directions.
Matrix6 without_weak_directions(const Matrix6& information, const Localizability& localizability);

}  // namespace voxnav::odometry
