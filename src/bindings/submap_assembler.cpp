// SPDX-License-Identifier: BSD-3-Clause
#include "submap_assembler.hpp"

#include <pybind11/stl.h>

#include <cstring>
#include <memory>

#include "arrays.hpp"
#include "voxnav/pipeline/submap_assembler.hpp"

namespace voxnav::bindings {
namespace {

using pipeline::SubmapAssembler;
using pipeline::SubmapAssemblerConfig;
using submap::Submap;
using submap::SubmapEntry;

std::unique_ptr<SubmapAssembler> make(const submap::SubmapConfig& config, int max_open_submaps,
                                      const std::optional<submap::ProjectiveConfig>& projective,
                                      double projective_period_s) {
  SubmapAssemblerConfig all;
  all.submap = config;
  all.max_open_submaps = max_open_submaps;
  all.projective = projective;
  all.projective_period_s = projective_period_s;
  return std::make_unique<SubmapAssembler>(all);
}

void integrate(SubmapAssembler& assembler, const py::array& points_L, const py::array& T_O_L, double stamp) {
  const float* data = data_of<float>(points_L, "points_L", {-1, 3});
  const geometry::Pose pose = pose_of(T_O_L, "T_O_L");
  std::vector<geometry::Vec3f> points(static_cast<std::size_t>(points_L.shape(0)));
  if (!points.empty()) std::memcpy(points[0].data(), data, points.size() * 3 * sizeof(float));
  py::gil_scoped_release release;
  assembler.integrate(points, pose, base::from_seconds(stamp));
}

void bind_results(py::module_& m) {
  py::class_<SubmapEntry>(m, "FinishedSubmap", "A submap with its time span and its pose history.")
      .def_readonly("submap_id", &SubmapEntry::id)
      .def_property_readonly(
          "submap", [](const SubmapEntry& e) { return std::const_pointer_cast<Submap>(e.submap); }, "Submap, frame S.")
      .def_property_readonly(
          "start", [](const SubmapEntry& e) { return base::to_seconds(e.start_ns); }, "Stamp of the first scan [s].")
      .def_property_readonly(
          "stamp", [](const SubmapEntry& e) { return base::to_seconds(e.end_ns); }, "Stamp of the newest scan [s].")
      .def_property_readonly(
          "T_O_S", [](const SubmapEntry& e) { return pose_array(e.T_O_S); }, "(4, 4) float64, gravity-aligned.")
      .def_property_readonly(
          "pose_stamps", [](const SubmapEntry& e) { return stamps_array(e.T_S_B); }, "(n,) float64 [s].")
      .def_property_readonly(
          "T_S_B", [](const SubmapEntry& e) { return poses_array(e.T_S_B); }, "(n, 4, 4) float64 pose history.");
  py::class_<SubmapAssembler::Result>(m, "AssemblyResult", "The result of SubmapAssembler.add() for one handover.")
      .def_readonly("submap", &SubmapAssembler::Result::submap, "FinishedSubmap that it completed, or None.")
      .def_readonly("dropped", &SubmapAssembler::Result::dropped,
                    "Why early content of a submap was dropped, or None.");
}

}  // namespace

void bind_submap_assembler(py::module_& m) {
  bind_results(m);
  py::class_<SubmapAssembler>(m, "SubmapAssembler", "Assembles the handovers of a local map into finished submaps.")
      .def(py::init(&make), py::arg("config") = submap::SubmapConfig{}, py::arg("max_open_submaps") = 4,
           py::arg("projective") = py::none(), py::arg("projective_period_s") = 0.0,
           "config: SubmapConfig. max_open_submaps: number of submaps whose early content is kept until they close.\n\n"
           "projective: ProjectiveConfig, which fills submaps from clouds instead; they then close at the age of\n"
           "projective_period_s, or together with the handovers if that is 0. Raises ValueError, ConfigError.")
      .def("add", &SubmapAssembler::add, py::arg("handover"), py::call_guard<py::gil_scoped_release>(),
           "Adds the next Handover and returns an AssemblyResult. Raises ValueError if its content does not fit the\n"
           "early content of its submap.")
      .def("integrate", &integrate, py::arg("points_L"), py::arg("T_O_L"), py::arg("stamp"),
           "Fuses one cloud: (n, 3) float32 [m, sensor frame], (4, 4) float64, seconds. Needs projective.")
      .def("close", &SubmapAssembler::close, py::call_guard<py::gil_scoped_release>(),
           "Returns the FinishedSubmap of the clouds so far. Needs projective.")
      .def_property_readonly("is_due", &SubmapAssembler::is_due,
                             "True if the submap that is filled from clouds is old enough to close.")
      .def_property_readonly("num_open", &SubmapAssembler::num_open,
                             "Number of submaps whose early content waits until they close.");
}

}  // namespace voxnav::bindings
