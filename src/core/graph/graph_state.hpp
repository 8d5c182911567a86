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

/// The data of a SubmapGraph. Only sources of this floor include this header; graph_steps.hpp declares the steps of a
/// solve that work on it.
namespace voxnav::graph {

struct Node {
  SurfaceSample sample;                    ///< its field is null if the submap is not registered to others
  SurfaceSample coarse;                    ///< the same surfaces with a field that reaches farther and resolves less
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
  bool is_recognised = false;  ///< a recognised loop: place recognition found it, and a second one confirmed it
};

/// A candidate of place recognition: two submaps look like the same place, and their surfaces fit. It enters the graph
/// as a loop closure once a second candidate nearby agrees with it.
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
  bool is_active = false;  ///< the two overlap enough; others are kept, so that they are not tested again at each solve
  Pose4 considered_at = Pose4::Zero();  ///< relative pose in the graph when points were last chosen
  Pose4 registered_at = Pose4::Zero();  ///< seen_relative() pose to which registration then moved the pair
  PairOverlap overlap;
  PairModel model;
  RelativePoseFactor factor;
  double information = 0.0;
  bool is_bent_anew = false;  ///< the Sway of one of the two has changed since the model was made
};

/// The submap that odometry joins to another one, before or after it.
struct Neighbour {
  int id;
  Eigen::Vector3d step;  ///< odometry from the earlier of the two to the later, in the frame of the earlier
};

/// The variables of a solve.
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
  std::map<int, Neighbour> before;  ///< for each submap the one before it, from which odometry leads to it
  std::map<int, Neighbour> after;   ///< for each submap the one after it, to which odometry leads on
  PlaceIndex places;
  std::vector<int> unrecognised;  ///< submaps whose places have not been compared with the others yet
  std::vector<RecognisedLoop> recognised;
  std::map<std::pair<int, int>, RegistrationPair> pairs;  ///< sorted, so that sums do not depend on how they were found
  Estimate estimate;
  bool has_datum = false;
  double datum_spread_m = 0.0;  ///< horizontal spread of the positions from which the datum was started
  bool is_enabled[kNumConstraintKinds] = {true, true, true, true, true};

  bool uses(ConstraintKind kind) const { return is_enabled[static_cast<int>(kind)]; }
  bool uses(const RelativeConstraint& c) const {
    return uses(c.kind) && (c.kind != ConstraintKind::kLoop || c.state == LoopState::kAccepted);
  }
  double voxel_m(const RegistrationPair& pair) const;
  double kernel_m(const RegistrationPair& pair, double voxels) const { return voxels * voxel_m(pair); }
};

}  // namespace voxnav::graph
