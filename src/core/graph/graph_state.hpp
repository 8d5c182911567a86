// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>
#include <vector>

#include "graph/factors.hpp"
#include "graph/pair_registration.hpp"
#include "graph/place.hpp"
#include "voxnav/geometry/voxel.hpp"
#include "voxnav/graph/submap_graph.hpp"

/// What the parts of the optimiser share. Private to the floor.
namespace voxnav::graph {

struct Node {
  SurfaceSample sample;                    ///< field is null when the submap is not registered
  SurfaceSample coarse;                    ///< the same surfaces as the first steps of registration see them
  std::vector<geometry::Index3> blocks_S;  ///< cells of pair_block_m that hold sample points
  Place place;
};

enum class LoopState { kUntested, kAccepted, kRejected };

struct RelativeConstraint {
  int a;
  int b;
  RelativePoseFactor factor;
  ConstraintKind kind;
  LoopState state = LoopState::kUntested;
  std::string reason;
  bool is_recognised = false;  ///< found by place recognition and confirmed by a second one, not given from outside
};

/// Two submaps that look like the same place and register there.
struct RecognisedLoop {
  int a;
  int b;
  RelativePoseFactor factor;
  bool is_confirmed = false;
};

struct PositionConstraint {
  int id;
  PositionFactor factor;
  bool is_in_map_frame;
};

struct HeightConstraint {
  int id;
  HeightFactor factor;
};

struct RegistrationPair {
  int a;
  int b;
  bool is_active = false;  ///< enough overlap; inactive ones are kept so that they are not tested again and again
  Pose4 considered_at = Pose4::Zero();  ///< relative pose in the graph when points were last chosen
  Pose4 registered_at = Pose4::Zero();  ///< where registration then put it, seen_relative()
  PairOverlap overlap;
  PairModel model;
  RelativePoseFactor factor;
  double information = 0.0;
  bool is_bent_anew = false;  ///< the sway of a submap has changed since the model was made
};

/// Odometry to the submap before or after.
struct Neighbour {
  int id;
  Eigen::Vector3d step;  ///< from the earlier to the later, frame of the earlier
};

/// What a solve changes.
struct Estimate {
  std::map<int, Pose4> poses;
  Pose4 datum = Pose4::Zero();
};

struct GraphState {
  SubmapGraphConfig config;
  std::map<int, Node> nodes;
  std::vector<RelativeConstraint> relatives;
  std::vector<PositionConstraint> positions;
  std::vector<HeightConstraint> heights;
  std::map<int, Neighbour> before;  ///< of each submap that odometry leads to
  std::map<int, Neighbour> after;   ///< of each that it leads on from
  PlaceIndex places;
  std::vector<int> unrecognised;  ///< submaps whose place was not looked for yet
  std::vector<RecognisedLoop> recognised;
  std::map<std::pair<int, int>, RegistrationPair> pairs;  ///< ordered: sums do not depend on how they were found
  Estimate estimate;
  bool has_datum = false;
  double datum_spread_m = 0.0;  ///< of the positions the datum was started from
  bool is_enabled[kNumConstraintKinds] = {true, true, true, true, true};

  bool uses(ConstraintKind kind) const { return is_enabled[static_cast<int>(kind)]; }
  bool uses(const RelativeConstraint& c) const {
    return uses(c.kind) && (c.kind != ConstraintKind::kLoop || c.state == LoopState::kAccepted);
  }
  double voxel_m(const RegistrationPair& pair) const;
  double kernel_m(const RegistrationPair& pair, double voxels) const { return voxels * voxel_m(pair); }
};

inline Pose4 relative_of(const std::map<int, Pose4>& poses, int a, int b) { return relative(poses.at(a), poses.at(b)); }

/// Where a submap lay at a time: its own id and no share where the neighbour of that side is not there yet.
struct SeenFrom {
  int id;
  int neighbour;
  SeenAt at;
  Pose4 pose(const std::map<int, Pose4>& poses) const {
    return at.evaluate(poses.at(id), poses.at(neighbour), nullptr, nullptr);
  }
};
SeenFrom seen_from(const GraphState& state, int id, double phase);

/// Relative pose of a pair at the times when the two saw what they share.
Pose4 seen_relative(const GraphState& state, const std::map<int, Pose4>& poses, const RegistrationPair& pair);

/// Submaps (a < b) that share cells of the spatial index at the given poses, most shared cells first for each b.
/// O(cells) expected. Cells crowded by more than 128 submaps keep the newest.
struct CandidatePair {
  int a;
  int b;
  int shared;
};
std::vector<CandidatePair> overlapping_submaps(const GraphState& state, const std::map<int, Pose4>& poses);

/// Registers a pair by descent from T_A_B alone; inactive where the two share too little there.
RegistrationPair register_at(const GraphState& state, int a, int b, const Pose4& T_A_B);
/// Share of a submap that the pair explains, 0 to 1: overlap, less what does not fit in it.
double support_of(const GraphState& state, const RegistrationPair& pair);

/// Looks for the places of submaps that are new among all others, wherever the graph has them, and adds loop closures
/// for those that register and that a second such loop nearby confirms. @return how many were added
int recognise_places(GraphState* state, OptimizeReport* report);

/// Finds, chooses points for and registers the pairs that are new or have moved.
void update_pairs(GraphState* state, bool is_full, OptimizeReport* report);

/// Renews the models of pairs that have moved since theirs were made.
void linearise_pairs(GraphState* state, const std::map<int, Pose4>& poses, OptimizeReport* report);

/// How submaps drifted while they were made, from where their neighbours lie.
void update_sways(GraphState* state, const std::map<int, Pose4>& poses);

/// Cost of one pair at its present relative pose, from its model.
double pair_cost(const RegistrationPair& pair, const Pose4& T_A_B);

/// Sum of squared whitened residuals per kind, robust where the solver is.
std::vector<KindReport> costs_of(const GraphState& state, const Estimate& estimate);

/// Ceres on the factors as they stand (registered pairs as quadratic models).
struct SolveSummary {
  bool is_converged = false;
  bool is_usable = false;
};
/// @param pair_loss_width  Cauchy width in sigmas for the registered pairs; 0 for none
SolveSummary solve_factors(const GraphState& state, double pair_loss_width, Estimate* estimate);

/// Accepts or rejects loop closures, solving in between, whenever there are new ones (or `is_full`).
void judge_loops(GraphState* state, bool is_full, Estimate* estimate);

/// Datum of the GNSS frame in closed form, so that the solver starts near.
void initialise_datum(GraphState* state);

OptimizeReport optimise(GraphState* state, bool is_full);

}  // namespace voxnav::graph
