// SPDX-License-Identifier: BSD-3-Clause
#include <memory>

#include "arrays.hpp"
#include "bind_config.hpp"
#include "configs/optimizer_config.hpp"
#include "floors.hpp"
#include "voxnav/geometry/distance_field.hpp"
#include "voxnav/graph/correct_trajectory.hpp"
#include "voxnav/graph/submap_graph.hpp"

namespace voxnav::bindings {
namespace {

using geometry::DistanceField;
using graph::ConstraintKind;
using graph::SubmapGraph;

ConstraintKind kind_from(const std::string& word) { return from_word<ConstraintKind>(word, "kind"); }

Eigen::Matrix4d matrix4_of(const py::array& array, const char* name) {
  return Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(data_of<double>(array, name, {4, 4}));
}

Eigen::Matrix3d matrix3_of(const py::array& array, const char* name) {
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(data_of<double>(array, name, {3, 3}));
}

template <class Pick>
py::dict per_kind(const graph::OptimizeReport& report, const Pick& pick) {
  py::dict out;
  for (const ConstraintKind kind : base::all_values<ConstraintKind>()) {
    out[to_member(kind)] = pick(report.kinds[static_cast<int>(kind)]);
  }
  return out;
}

void bind_report(py::module_& m) {
  using Report = graph::OptimizeReport;
  using Kind = graph::KindReport;
  py::class_<Report>(m, "OptimizeReport",
                     "Report of a SubmapGraph.optimize(). Costs are sums of squared residuals in sigmas.")
      .def_property_readonly(
          "costs_before", [](const Report& r) { return per_kind(r, [](const Kind& k) { return k.cost_before; }); },
          "dict: ConstraintKind -> cost of the input.")
      .def_property_readonly(
          "costs", [](const Report& r) { return per_kind(r, [](const Kind& k) { return k.cost_after; }); },
          "dict: ConstraintKind -> cost of the result.")
      .def_property_readonly(
          "num_constraints",
          [](const Report& r) { return per_kind(r, [](const Kind& k) { return k.num_constraints; }); },
          "dict: ConstraintKind -> constraints that took part.")
      .def_readonly("cost_before", &Report::cost_before)
      .def_readonly("cost_after", &Report::cost_after)
      .def_readonly("is_converged", &Report::is_converged)
      .def_readonly("is_input_kept", &Report::is_input_kept, "No better poses were found, or none were needed.")
      .def_readonly("iterations", &Report::iterations)
      .def_readonly("num_submaps", &Report::num_submaps)
      .def_readonly("pairs", &Report::num_pairs, "Overlapping pairs in the graph.")
      .def_readonly("num_new_pairs", &Report::num_new_pairs,
                    "Pairs that were registered alone (without the rest of the graph) in this solve.")
      .def_readonly("num_pair_evaluations", &Report::num_pair_evaluations, "Evaluations of the model of a pair.")
      .def_readonly("num_searches", &Report::num_searches, "Pairs that were registered by a grid search, too.")
      .def_readonly("num_recognised", &Report::num_recognised, "Loop closures that place recognition added.")
      .def_readonly("seconds", &Report::seconds, "CPU time of the calling thread.")
      .def_property_readonly(
          "rejected_loops",
          [](const Report& r) {
            py::list out;
            for (const graph::RejectedLoop& loop : r.rejected_loops)
              out.append(py::make_tuple(loop.a, loop.b, loop.reason));
            return out;
          },
          "List of (a, b, reason) of the loop closures that disagree with the rest of the graph.");
}

void add_relative_pose(SubmapGraph& g, int a, int b, const py::array& T_a_b, const py::array& information,
                       const std::string& kind) {
  g.add_relative_pose(a, b, pose_of(T_a_b, "T_a_b"), matrix4_of(information, "information"), kind_from(kind));
}

py::dict poses(const SubmapGraph& g) {
  py::dict out;
  for (const auto& [id, pose] : g.poses()) out[py::int_(id)] = pose_array(pose);
  return out;
}

py::list constraints(const SubmapGraph& g) {
  py::list out;
  for (const graph::ConstraintView& c : g.constraints()) {
    out.append(py::make_tuple(to_member(c.kind), c.a, c.b, c.cost, c.is_used));
  }
  return out;
}

void bind_constraints(py::class_<SubmapGraph>& cls) {
  cls.def(
      "add_relative_pose", &add_relative_pose, py::arg("a"), py::arg("b"), py::arg("T_a_b"), py::arg("information"),
      py::arg("kind") = "odometry",
      "Adds a measured pose of submap b in submap a.\n\n"
      "T_a_b: (4, 4) float64, gravity-aligned; information: (4, 4) float64 of (x, y, z, yaw) in the axes of a;\n"
      "kind: ConstraintKind.ODOMETRY, which is trusted, or ConstraintKind.LOOP, which is rejected when it disagrees\n"
      "with the rest, or the word of either.\n"
      "Raises ValueError for unknown ids and unusable matrices.");
  cls.def(
      "add_position",
      [](SubmapGraph& g, int id, const py::object& p_S, const py::object& p_W, const py::array& covariance) {
        g.add_position(id, vec3_of(p_S, "p_S"), vec3_of(p_W, "p_W"), matrix3_of(covariance, "covariance"));
      },
      py::arg("id"), py::arg("p_S"), py::arg("p_W"), py::arg("covariance"),
      "Adds a measurement that the point p_S of a submap lies at p_W in the map frame (three numbers each, metres).\n\n"
      "covariance: (3, 3) float64 in m^2. A robust loss limits what an outlier can do.");
  cls.def(
      "add_gnss_position",
      [](SubmapGraph& g, int id, const py::object& p_S, const py::object& p_G, const py::array& covariance) {
        g.add_gnss_position(id, vec3_of(p_S, "p_S"), vec3_of(p_G, "p_G"), matrix3_of(covariance, "covariance"));
      },
      py::arg("id"), py::arg("p_S"), py::arg("p_G"), py::arg("covariance"),
      "Adds a measurement that the point p_S of a submap lies at p_G in a frame whose position and heading in the map\n"
      "are unknown. They are estimated with the poses, see gnss_datum. covariance: (3, 3) float64 in m^2.");
  cls.def(
      "add_height",
      [](SubmapGraph& g, int id, const py::object& p_S, double height_m, double sigma_m) {
        g.add_height(id, vec3_of(p_S, "p_S"), height_m, sigma_m);
      },
      py::arg("id"), py::arg("p_S"), py::arg("height_m"), py::arg("sigma_m"),
      "Adds a measurement that the point p_S of a submap is height_m high in the map frame. Its loss is robust.");
  cls.def(
      "set_kind_enabled",
      [](SubmapGraph& g, const std::string& kind, bool is_enabled) { g.set_kind_enabled(kind_from(kind), is_enabled); },
      py::arg("kind"), py::arg("is_enabled"), "Switches all constraints of a kind on or off.");
}

void bind_submap_graph(py::module_& m) {
  py::class_<SubmapGraph> cls(
      m, "SubmapGraph",
      "Pose graph of submaps with four degrees of freedom each (x, y, z, yaw). The submap with the\n"
      "smallest id stays where it is. Not thread-safe.");
  cls.def(py::init<const graph::SubmapGraphConfig&>(), py::arg("config") = graph::SubmapGraphConfig());
  cls.def(
      "add_submap",
      [](SubmapGraph& g, int id, const py::array& T_W_S, const std::shared_ptr<DistanceField>& submap) {
        g.add_submap(id, pose_of(T_W_S, "T_W_S"), submap);
      },
      py::arg("id"), py::arg("T_W_S"), py::arg("submap") = py::none(),
      "Adds a submap at the pose T_W_S, (4, 4) float64, that odometry gives it.\n\n"
      "submap: a DistanceField by which it is registered to others, or None. Raises ValueError for an id that is in "
      "the\n"
      "graph already and for a pose that is not gravity-aligned.");
  bind_constraints(cls);
  cls.def("optimize", &SubmapGraph::optimize, py::arg("full") = false, py::call_guard<py::gil_scoped_release>(),
          "Moves the submaps to where the constraints fit best, and never to where they fit worse than before.\n\n"
          "full: whether every pair is registered anew, with ten times the work allowed. Returns an OptimizeReport.");
  cls.def("poses", &poses, "dict: id -> T_W_S, (4, 4) float64.");
  cls.def(
      "constraints", &constraints,
      "List of (ConstraintKind, a, b, squared residual in sigmas, is_used); a = b for constraints of a single submap.");
  cls.def_property_readonly(
      "gnss_datum",
      [](const SubmapGraph& g) -> py::object {
        const auto datum = g.gnss_datum();
        return datum ? py::object(pose_array(*datum)) : py::object(py::none());
      },
      "(4, 4) float64 T_W_G of the frame of GNSS positions, or None before the first solve with such positions.");
  cls.def_property_readonly("num_submaps", &SubmapGraph::num_submaps);
  cls.def("to_g2o", &SubmapGraph::to_g2o, "The poses and the odometry and loop constraints as g2o text.");
  cls.def_static(
      "from_g2o", &SubmapGraph::from_g2o, py::arg("text"), py::arg("config") = graph::SubmapGraphConfig(),
      "Makes a graph from g2o text (SE3:QUAT or SE2). Edges between neighbouring ids become odometry, others "
      "loops.\nKeys of GTSAM (one letter) become their index. Priors, landmarks and TORO files are refused.\n\n"
      "Raises ValueError that names line and fault.");
}

std::vector<graph::SubmapCorrection> corrections_of(const py::array& spans_s, const py::array& T_O_S,
                                                    const py::array& T_W_S) {
  const std::vector<geometry::Pose> from = poses_of(T_O_S, "T_O_S");
  const std::vector<geometry::Pose> to = poses_of(T_W_S, "T_W_S");
  const double* spans = data_of<double>(spans_s, "spans_s", {static_cast<py::ssize_t>(from.size()), 2});
  if (from.size() != to.size()) throw py::value_error("T_O_S and T_W_S must have as many rows as each other");
  std::vector<graph::SubmapCorrection> out(from.size());
  for (std::size_t i = 0; i < from.size(); ++i) {
    out[i] = {base::from_seconds(spans[2 * i]), base::from_seconds(spans[2 * i + 1]), from[i], to[i]};
  }
  return out;
}

void append(const geometry::Pose& pose, std::vector<double>* out) {
  for (int k = 0; k < 16; ++k) out->push_back(pose.matrix()(k / 4, k % 4));
}

py::array_t<double> correct_trajectory(const py::array& stamps_s, const py::array& T_O_B, const py::array& spans_s,
                                       const py::array& T_O_S, const py::array& T_W_S) {
  const std::vector<geometry::StampedPose> trajectory = stamped_poses_of(stamps_s, T_O_B, "T_O_B");
  std::vector<double> out;
  out.reserve(16 * trajectory.size());
  const auto corrected = graph::correct_trajectory(trajectory, corrections_of(spans_s, T_O_S, T_W_S));
  for (const geometry::StampedPose& pose : corrected) append(pose.pose, &out);
  return array_from(std::move(out), 0).attr("reshape")(-1, 4, 4).cast<py::array_t<double>>();
}

py::array_t<double> submap_bends(const py::array& spans_s, const py::array& T_O_S, const py::array& T_W_S,
                                 double max_shift_m) {
  std::vector<double> out;
  for (const geometry::Bend& bend : graph::bends_of(corrections_of(spans_s, T_O_S, T_W_S), max_shift_m)) {
    append(bend.T_S_begin, &out);
    append(bend.T_S_end, &out);
  }
  return array_from(std::move(out), 0).attr("reshape")(-1, 2, 4, 4).cast<py::array_t<double>>();
}

}  // namespace

void bind_graph(py::module_& m) {
  bind_words<ConstraintKind>(m, "ConstraintKind", "The kind of measurement behind a constraint.");
  bind_words<GnssType>(m, "GnssType", "Message type of the positions that satellites give.");
  bind_config<graph::SubmapGraphConfig>(m, "SubmapGraphConfig", "Parameters of SubmapGraph.");
  bind_config<OptimizerConfig>(m, "OptimizerConfig", "Parameters of the submap optimiser beside those of SubmapGraph.");
  bind_report(m);
  bind_submap_graph(m);
  m.def("correct_trajectory", &correct_trajectory, py::arg("stamps_s"), py::arg("T_O_B"), py::arg("spans_s"),
        py::arg("T_O_S"), py::arg("T_W_S"),
        "Moves a trajectory together with the submaps that the graph moved.\n\n"
        "stamps_s: (n,) float64; T_O_B: (n, 4, 4) float64; spans_s: (k, 2) float64, when each of k submaps began and\n"
        "ended; T_O_S, T_W_S: (k, 4, 4) float64, where odometry and where the graph has them. A pose between the\n"
        "middles of two submaps is blended from both. Returns T_W_B, (n, 4, 4) float64.");
  m.def(
      "submap_bends", &submap_bends, py::arg("spans_s"), py::arg("T_O_S"), py::arg("T_W_S"), py::arg("max_shift_m"),
      "Estimates the drift within submaps that the graph moved, from the arguments of correct_trajectory().\n\n"
      "Returns (k, 2, 4, 4) float64, T_S_begin and T_S_end of each submap: they move what the submap observed at its\n"
      "beginning and at its end to where it would lie without drift against its middle. A shift of more than\n"
      "max_shift_m is taken for a jump of odometry, and such a submap is left rigid.");
}

}  // namespace voxnav::bindings
