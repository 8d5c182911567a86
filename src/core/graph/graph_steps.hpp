// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <vector>

#include "graph/graph_state.hpp"

/// The steps of a solve, in the order in which optimise() takes them; each has a source file of its own.
namespace voxnav::graph {

inline Pose4 relative_of(const std::map<int, Pose4>& poses, int a, int b) { return relative(poses.at(a), poses.at(b)); }

/// The pose of a submap at one time of the flight, see SeenAt. If the neighbour on that side does not exist yet, the
/// submap is its own neighbour with a share of zero.
struct SeenFrom {
  int id;
  int neighbour;
  SeenAt at;
  Pose4 pose(const std::map<int, Pose4>& poses) const {
    return at.evaluate(poses.at(id), poses.at(neighbour), nullptr, nullptr);
  }
};
SeenFrom seen_from(const GraphState& state, int id, double phase);

/// Returns the relative pose of the two submaps of a pair at the times when they saw what they share.
Pose4 seen_relative(const GraphState& state, const std::map<int, Pose4>& poses, const RegistrationPair& pair);

/// Finds pairs of submaps (a < b) that share cells of the spatial index at the given poses, for each b those with most
/// shared cells first. In a cell that more than 128 submaps share only the newest ones count. O(cells) expected.
struct CandidatePair {
  int a;
  int b;
  int shared;
};
std::vector<CandidatePair> overlapping_submaps(const GraphState& state, const std::map<int, Pose4>& poses);

/// Returns how far the points of a pair move between two relative poses, with yaw taken at the radius of its points.
double motion_m(const Pose4& from, const Pose4& to, double radius_m);
/// Sets the model of a pair and the factor that follows from it.
void set_model(const GraphState& state, const PairModel& model, RegistrationPair* pair);

/// Registers one pair, starting at its relative pose T_A_B in the graph. The result of the coarse fields, which reach
/// farther, is taken only if it explains clearly more of both submaps.
void register_pair(const GraphState& state, const Pose4& T_A_B, RegistrationPair* pair, OptimizeReport* report);
/// Registers a pair by descent from T_A_B only. The pair is inactive if the two share too little there.
RegistrationPair register_at(const GraphState& state, int a, int b, const Pose4& T_A_B);
/// Returns the support of a pair, 0 to 1: the share of the submaps that overlaps, less the part of it that does not
/// fit.
double support_of(const GraphState& state, const RegistrationPair& pair);

/// Searches the places of new submaps among those of all others, however far away these are in the graph. A loop
/// closure is added if the surfaces fit and a second such loop nearby confirms it.
/// @return number of loop closures added
int recognise_places(GraphState* state, OptimizeReport* report);

/// Finds the pairs that are new or have moved, chooses points for them and registers each alone, without the rest of
/// the graph.
void update_pairs(GraphState* state, bool is_full, OptimizeReport* report);

/// Updates the models of the pairs whose relative pose has changed since their models were made.
void linearise_pairs(GraphState* state, const std::map<int, Pose4>& poses, OptimizeReport* report);

/// Estimates from the poses of its neighbours how each submap drifted while it was made, and sets its Sway.
void update_sways(GraphState* state, const std::map<int, Pose4>& poses);

/// Returns the cost of one pair at a relative pose according to its model.
double pair_cost(const RegistrationPair& pair, const Pose4& T_A_B);

/// Computes the sum of squared whitened residuals of each kind, with the robust losses of the solver.
std::vector<KindReport> costs_of(const GraphState& state, const Estimate& estimate);

/// The result of Ceres for a solve.
struct SolveSummary {
  bool is_converged = false;
  bool is_usable = false;
};
/// Solves for all poses with the factors as they stand; registered pairs take part as quadratic models.
/// @param pair_loss_width  width of the Cauchy loss of registered pairs, in standard deviations; 0 = least squares
SolveSummary solve_factors(const GraphState& state, double pair_loss_width, Estimate* estimate);

/// Decides which loop closures are accepted, solving in between, when there are new ones or `is_full` asks for it.
void judge_loops(GraphState* state, bool is_full, Estimate* estimate);

/// Finds the datum of the GNSS frame in closed form, so that the solver starts near it.
void initialise_datum(GraphState* state);

OptimizeReport optimise(GraphState* state, bool is_full);

}  // namespace voxnav::graph
