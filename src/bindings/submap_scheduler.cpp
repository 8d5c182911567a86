// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/pipeline/submap_scheduler.hpp"

#include "arrays.hpp"
#include "bind_config.hpp"
#include "submap_scheduler.hpp"
#include "voxnav/geometry/pose.hpp"
#include "voxnav/pipeline/sweep_locator.hpp"

namespace voxnav::bindings {
namespace {

using pipeline::Handover;
using pipeline::SubmapScheduler;
using pipeline::SubmapSchedulerConfig;

Handover as_sent(const Handover& handover) {
  Handover out = handover;
  out.T_O_S = geometry::as_sent(handover.T_O_S);
  for (geometry::StampedPose& pose : out.poses) pose.pose = geometry::as_sent(pose.pose);
  return out;
}

void bind_handover(py::module_& m) {
  py::class_<Handover>(m, "Handover", "The content and poses of the local map that make a submap when it closes.")
      .def("as_sent", &as_sent,
           "Returns the handover with its poses as they arrive at the submap integrator; see voxnav.as_sent().")
      .def_readonly("submap_id", &Handover::submap_id)
      .def_readonly("is_final", &Handover::is_final, "False: early content of a submap that is still open.")
      .def_readonly("reason", &Handover::reason)
      .def_property_readonly(
          "start", [](const Handover& h) { return base::to_seconds(h.start_ns); }, "Stamp of the first scan [s].")
      .def_property_readonly(
          "stamp", [](const Handover& h) { return base::to_seconds(h.stamp_ns); }, "Stamp of the newest scan [s].")
      .def_property_readonly("T_O_S", [](const Handover& h) { return pose_array(h.T_O_S); })
      .def_property_readonly(
          "pose_stamps", [](const Handover& h) { return stamps_array(h.poses); }, "(n,) float64 [s].")
      .def_property_readonly(
          "T_S_B", [](const Handover& h) { return poses_array(h.poses); }, "(n, 4, 4) float64 pose history.")
      .def_readonly("content", &Handover::content, "MapContent in frame O.");
}

/// Returns deskewed points; see pipeline::deskew().
py::array_t<float> deskew(const py::array& points_L, const py::array& times, const py::array& T_O_L_start,
                          const py::array& T_O_L_end, double duration_s) {
  const float* points = data_of<float>(points_L, "points_L", {-1, 3});
  const py::ssize_t n = points_L.shape(0);
  const auto* offsets = data_of<std::uint32_t>(times, "time_offsets_ns", {n});
  if (!(duration_s >= 0.0 && duration_s < 4.0)) throw py::value_error("duration_s must lie in [0, 4)");
  const pipeline::SweepMotion motion{pose_of(T_O_L_start, "T_O_L_start"), pose_of(T_O_L_end, "T_O_L_end"),
                                     static_cast<std::uint32_t>(base::from_seconds(duration_s))};
  std::vector<float> out(points, points + 3 * n);
  pipeline::deskew(geometry::view_of_rows(&out), std::vector<std::uint32_t>(offsets, offsets + n), motion);
  return array_from(std::move(out), 3);
}

}  // namespace

void bind_submap_scheduler(py::module_& m) {
  bind_config<SubmapSchedulerConfig>(m, "SubmapSchedulerConfig", "When a submap closes.");
  bind_handover(m);
  py::class_<SubmapScheduler>(m, "SubmapScheduler", "Decides when a submap closes and collects its content and poses.")
      .def(py::init<const SubmapSchedulerConfig&, std::uint32_t>(), py::arg("config") = SubmapSchedulerConfig{},
           py::arg("first_id") = 0)
      .def(
          "add_scan",
          [](SubmapScheduler& scheduler, occupancy::LocalMap& map, double stamp, const py::array& T_O_B) {
            return scheduler.add_scan(&map, base::from_seconds(stamp), pose_of(T_O_B, "T_O_B"));
          },
          py::arg("map"), py::arg("stamp"), py::arg("T_O_B"),
          "Adds a scan; to be called after each insertion into the map. stamp: seconds.\n\n"
          "Returns the list of Handover that are due, oldest first.")
      .def(
          "finish",
          [](SubmapScheduler& scheduler, occupancy::LocalMap& map, const std::string& reason) {
            return scheduler.finish(&map, reason);
          },
          py::arg("map"), py::arg("reason") = "shutdown",
          "Closes the open submap. Returns a list of at most one Handover.")
      .def("request_close", &SubmapScheduler::request_close, py::arg("reason"))
      .def("discard", &SubmapScheduler::discard)
      .def_property_readonly("is_open", &SubmapScheduler::is_open)
      .def_property_readonly("submap_id", &SubmapScheduler::submap_id);
  m.def("deskew", &deskew, py::arg("points_L"), py::arg("time_offsets_ns"), py::arg("T_O_L_start"),
        py::arg("T_O_L_end"), py::arg("duration_s"),
        "Returns (n, 3) float32 points, moved to the sensor frame halfway through the sweep. The poses are those at\n"
        "offset 0 and at duration_s.");
}

}  // namespace voxnav::bindings
