// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/graph/submap_graph.hpp"

#include <cmath>
#include <ctime>
#include <set>
#include <stdexcept>

#include "graph/g2o.hpp"
#include "graph/graph_steps.hpp"

namespace voxnav::graph {
namespace {

constexpr double kReachKernels = 1.5;  // distance in kernel widths beyond which a point is an outlier in any case

double cpu_seconds() {
  timespec now;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

std::vector<geometry::Index3> blocks_of(const SurfaceSample& sample, double block_m) {
  std::set<geometry::Index3> blocks;
  for (const SamplePoint& point : sample.points) blocks.insert(geometry::index_of(point.position_S, block_m));
  return {blocks.begin(), blocks.end()};
}

void check_finite(const geometry::Vec3& point, const char* what) {
  if (!point.allFinite()) throw std::invalid_argument(std::string(what) + " must be finite");
}

}  // namespace

struct SubmapGraph::Impl {
  GraphState state;

  void check_id(int id) const {
    if (!state.nodes.count(id)) throw std::invalid_argument("unknown submap " + std::to_string(id));
  }
  /// Throws if a list of constraints is full: its bound is 20 for each submap that the graph may have.
  template <class T>
  void check_room(const std::vector<T>& constraints) const {
    if (constraints.size() >= 20u * static_cast<std::size_t>(state.config.max_submaps)) {
      throw std::length_error("too many constraints for max_submaps = " + std::to_string(state.config.max_submaps));
    }
  }
  void add_position(int id, const geometry::Vec3& p_S, const geometry::Vec3& p, const Eigen::Matrix3d& covariance,
                    bool is_in_map_frame) {
    check_id(id);
    check_room(state.positions);
    check_finite(p_S, "p_S");
    check_finite(p, is_in_map_frame ? "p_W" : "p_G");
    state.positions.push_back({id, {p_S, p, whitening_of_covariance(covariance, "covariance")}, is_in_map_frame});
  }
};

SubmapGraph::SubmapGraph(const SubmapGraphConfig& config) : impl_(std::make_unique<Impl>()) {
  impl_->state.config = base::checked(config);
  set_kind_enabled(ConstraintKind::kRegistration, config.is_registration_enabled);
}
SubmapGraph::~SubmapGraph() = default;
SubmapGraph::SubmapGraph(SubmapGraph&&) noexcept = default;
SubmapGraph& SubmapGraph::operator=(SubmapGraph&&) noexcept = default;

void SubmapGraph::add_submap(int id, const geometry::Pose& T_W_S,
                             std::shared_ptr<const geometry::DistanceField> field) {
  GraphState& state = impl_->state;
  if (state.nodes.count(id)) throw std::invalid_argument("submap " + std::to_string(id) + " is in the graph already");
  if (state.nodes.size() >= static_cast<std::size_t>(state.config.max_submaps)) {
    throw std::length_error("the graph is full: max_submaps = " + std::to_string(state.config.max_submaps));
  }
  const Pose4 pose = to_pose4(T_W_S, "T_W_S");
  Node node;
  if (field) {
    const SubmapGraphConfig& config = state.config;
    node.sample = draw_sample(std::move(field), config.sample_points, config.sample_cell_m);
    const double reach_m = config.coarse_kernel_voxels * kReachKernels * node.sample.field->resolution_m();
    node.coarse = coarsen(node.sample, config.coarse_points, 2.0 * node.sample.field->resolution_m(), reach_m);
  }
  if (node.sample.field && state.config.is_place_recognition_enabled) {
    node.place = describe_place(node.sample.field->surface_points());
    state.places.add(id, node.place);
    state.unrecognised.push_back(id);
  }
  node.blocks_S = blocks_of(node.sample, state.config.pair_block_m);
  state.nodes.emplace(id, std::move(node));
  state.estimate.poses.emplace(id, pose);
}

void SubmapGraph::add_relative_pose(int a, int b, const geometry::Pose& T_a_b, const Matrix4& information,
                                    ConstraintKind kind) {
  if (kind != ConstraintKind::kOdometry && kind != ConstraintKind::kLoop) {
    throw std::invalid_argument("kind must be odometry or loop");
  }
  impl_->check_id(a);
  impl_->check_id(b);
  impl_->check_room(impl_->state.relatives);
  if (a == b) throw std::invalid_argument("a relative pose needs two different submaps");
  const RelativePoseFactor factor{to_pose4(T_a_b, "T_a_b"), whitening_of(information, "information")};
  impl_->state.relatives.push_back({a, b, factor, kind, LoopState::kUntested, {}});
  if (kind != ConstraintKind::kOdometry || a > b) return;
  impl_->state.after[a] = {b, factor.T_a_b.head<3>()};
  impl_->state.before[b] = {a, factor.T_a_b.head<3>()};
}

void SubmapGraph::add_position(int id, const geometry::Vec3& p_S, const geometry::Vec3& p_W,
                               const Eigen::Matrix3d& covariance) {
  impl_->add_position(id, p_S, p_W, covariance, true);
}

void SubmapGraph::add_gnss_position(int id, const geometry::Vec3& p_S, const geometry::Vec3& p_G,
                                    const Eigen::Matrix3d& covariance) {
  impl_->add_position(id, p_S, p_G, covariance, false);
}

void SubmapGraph::add_height(int id, const geometry::Vec3& p_S, double height_m, double sigma_m) {
  impl_->check_id(id);
  impl_->check_room(impl_->state.heights);
  check_finite(p_S, "p_S");
  if (!std::isfinite(height_m)) throw std::invalid_argument("height_m must be finite");
  if (!(sigma_m > 0.0) || !std::isfinite(sigma_m)) throw std::invalid_argument("sigma_m must be positive");
  impl_->state.heights.push_back({id, {p_S.z(), height_m, sigma_m}});
}

void SubmapGraph::set_kind_enabled(ConstraintKind kind, bool is_enabled) {
  impl_->state.is_enabled[static_cast<int>(kind)] = is_enabled;
}

bool SubmapGraph::is_kind_enabled(ConstraintKind kind) const { return impl_->state.uses(kind); }

OptimizeReport SubmapGraph::optimize(bool is_full) {
  const double start_s = cpu_seconds();
  OptimizeReport report = optimise(&impl_->state, is_full);
  report.seconds = cpu_seconds() - start_s;
  return report;
}

std::map<int, geometry::Pose> SubmapGraph::poses() const {
  std::map<int, geometry::Pose> out;
  for (const auto& [id, pose] : impl_->state.estimate.poses) out.emplace(id, to_pose(pose));
  return out;
}

std::optional<geometry::Pose> SubmapGraph::gnss_datum() const {
  if (!impl_->state.has_datum) return std::nullopt;
  return to_pose(impl_->state.estimate.datum);
}

std::vector<ConstraintView> SubmapGraph::constraints() const {
  const GraphState& state = impl_->state;
  const std::map<int, Pose4>& poses = state.estimate.poses;
  std::vector<ConstraintView> out;
  for (const RelativeConstraint& c : state.relatives) {
    const double cost = c.factor.evaluate(poses.at(c.a), poses.at(c.b), nullptr, nullptr).squaredNorm();
    out.push_back({c.kind, c.a, c.b, cost, state.uses(c)});
  }
  for (const auto& [ids, pair] : state.pairs) {
    if (!pair.is_active) continue;
    const double cost = pair_cost(pair, seen_relative(state, poses, pair));
    out.push_back({ConstraintKind::kRegistration, pair.a, pair.b, cost, state.uses(ConstraintKind::kRegistration)});
  }
  for (const PositionConstraint& c : state.positions) {
    const Pose4 datum = c.is_in_map_frame ? Pose4::Zero() : state.estimate.datum;
    const double cost = c.factor.evaluate(poses.at(c.id), datum, nullptr, nullptr).squaredNorm();
    out.push_back({ConstraintKind::kGnss, c.id, c.id, cost, state.uses(ConstraintKind::kGnss)});
  }
  for (const HeightConstraint& c : state.heights) {
    const double cost = std::pow(c.factor.evaluate(poses.at(c.id)), 2);
    out.push_back({ConstraintKind::kHeight, c.id, c.id, cost, state.uses(ConstraintKind::kHeight)});
  }
  return out;
}

int SubmapGraph::num_submaps() const { return static_cast<int>(impl_->state.nodes.size()); }

std::string SubmapGraph::to_g2o() const {
  G2o file;
  file.vertices = impl_->state.estimate.poses;
  for (const RelativeConstraint& c : impl_->state.relatives) {
    file.edges.push_back({c.a, c.b, c.factor.T_a_b, c.factor.whitening.transpose() * c.factor.whitening});
  }
  return write_g2o(file);
}

SubmapGraph SubmapGraph::from_g2o(const std::string& text, const SubmapGraphConfig& config) {
  const G2o file = read_g2o(text);
  SubmapGraph graph(config);
  for (const auto& [id, pose] : file.vertices) graph.add_submap(id, to_pose(pose));
  for (const G2oEdge& edge : file.edges) {
    const bool is_odometry = std::abs(edge.a - edge.b) == 1;
    graph.add_relative_pose(edge.a, edge.b, to_pose(edge.T_a_b), edge.information,
                            is_odometry ? ConstraintKind::kOdometry : ConstraintKind::kLoop);
  }
  return graph;
}

}  // namespace voxnav::graph
