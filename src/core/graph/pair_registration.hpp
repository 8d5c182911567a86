// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "graph/factors.hpp"
#include "graph/surface_sample.hpp"

/// Registration of two submaps: the surface points of each against the distance field of the other, as a function of
/// their relative pose T_A_B alone. Both submaps are frozen, so the sums over the points can be kept as one quadratic
/// model per pair and need renewal only when the pair moves; a graph of thousands of pairs stays cheap.
/// Source: Reijgwart et al., Voxgraph, RA-L 2020, section IV-C; differs: fixed sample, robust kernel, normalised by
/// weight, lost overlap costs, information from the Hessian.
namespace voxnav::graph {

/// The points of each submap that lay in the observed part of the other when the pair was formed. They stay the same
/// while costs of the pair are compared: a point that loses its match then costs as much as an outlier, so moving apart
/// never lowers the cost.
struct PairOverlap {
  std::vector<std::uint32_t> of_a;
  std::vector<std::uint32_t> of_b;
  double phase_a = 0.5;  ///< mean time at which A saw what the two share, as a share of A's time
  double phase_b = 0.5;  ///< mean time at which B saw it, as a share of B's time
  double ratio = 0.0;    ///< larger of the two shares of a sample that lie inside the other submap
};

PairOverlap find_overlap(const SurfaceSample& a, const SurfaceSample& b, const Pose4& T_A_B, int max_points);

/// Weighted means over the points of a pair: robust cost and its Gauss-Newton model around T_A_B,
/// cost(δ) ≈ cost + 2 gradientᵀ δ + δᵀ hessian δ, δ added to (x, y, z, yaw) of T_A_B.
struct PairModel {
  Pose4 T_A_B = Pose4::Zero();
  double cost_m2 = 0.0;
  Pose4 gradient = Pose4::Zero();
  Matrix4 hessian = Matrix4::Zero();
  double matched_ratio = 0.0;                          ///< share of the weight that still lies in observed space
  Eigen::Vector2d center_A = Eigen::Vector2d::Zero();  ///< mean of the matched points, frame A
  double radius_m = 1.0;                               ///< horizontal rms distance from center_A
};

/// Returns only the cost of evaluate_pair(). The sum stops as soon as it reaches `enough_m2`; the result is then some
/// cost of at least that much.
double cost_up_to(const SurfaceSample& a, const SurfaceSample& b, const PairOverlap& overlap, const Pose4& T_A_B,
                  double kernel_m, double enough_m2);

/// Computes cost and model of a pair at T_A_B with a Geman-McClure kernel of width `kernel_m`: residuals far beyond it
/// cost kernel_m² and have no gradient. O(points); deterministic.
/// Source of the kernel: Geman and McClure, Statistical methods for tomographic image reconstruction, Bulletin of the
/// International Statistical Institute 1987.
PairModel evaluate_pair(const SurfaceSample& a, const SurfaceSample& b, const PairOverlap& overlap, const Pose4& T_A_B,
                        double kernel_m);

/// The pair as a factor on its relative pose: minimum of the model, and its Hessian times `information` as weight.
/// Directions that the surfaces hardly determine (mean squared slope below `noise_floor`, yaw taken at the radius of
/// the points) are left free: flat ground determines z and neither x, y nor yaw. The minimum is searched within
/// `max_step_m`.
RelativePoseFactor to_factor(const PairModel& model, double information, double noise_floor, double max_step_m);

/// Registers the pair alone by descent from T_A_B, with kernels from coarse to fine and a bounded number of steps.
/// @return model at the end, with the last kernel
PairModel refine_pair(const SurfaceSample& a, const SurfaceSample& b, const PairOverlap& overlap, const Pose4& T_A_B,
                      const std::vector<double>& kernels_m, double noise_floor);

struct PairSearch {
  double range_m;        ///< half width of the window in x and y
  double range_rad;      ///< half width in yaw
  double step_m;         ///< spacing of the grid
  int max_points;        ///< points used in each direction
  double min_advantage;  ///< best cost must be below this share of the best cost elsewhere
};

/// Correlative search over x, y and yaw around T_A_B for the alignment that plain descent cannot reach.
/// @return nothing if no alignment stands out (a wrong alignment is worse than none)
/// Source: Olson, Real-time correlative scan matching, ICRA 2009.
std::optional<Pose4> search_pair(const SurfaceSample& a, const SurfaceSample& b, const Pose4& T_A_B,
                                 const PairSearch& search);

}  // namespace voxnav::graph
