// SPDX-License-Identifier: BSD-3-Clause
#include <pybind11/stl.h>

#include "arrays.hpp"
#include "bind_words.hpp"
#include "floors.hpp"
#include "voxnav/base/clock_watch.hpp"
#include "voxnav/base/ply.hpp"
#include "voxnav/base/stage_statistics.hpp"

namespace voxnav::bindings {

namespace py = pybind11;
using base::StageStatistics;

namespace {

py::dict summary(const StageStatistics& s) {
  py::dict out;
  out["count"] = s.wall.count();
  out["dropped"] = s.dropped;
  out["mean_ms"] = s.wall.mean_ms();
  out["median_ms"] = s.wall.quantile_ms(0.5);
  out["p99_ms"] = s.wall.quantile_ms(0.99);
  out["max_ms"] = s.wall.max_ms();
  out["cpu_ms"] = s.cpu.mean_ms();
  out["latency_mean_ms"] = s.latency.mean_ms();
  out["latency_p99_ms"] = s.latency.quantile_ms(0.99);
  return out;
}

void write_ply_points(const std::string& path, const py::array& points, const py::object& colors) {
  const auto* p = data_of<float>(points, "points", {-1, 3});
  const auto count = static_cast<std::size_t>(points.shape(0));
  base::PlyWriter out;
  if (colors.is_none()) {
    out.element("vertex", count, {"float x", "float y", "float z"});
    out.put_raw(p, 3 * count * sizeof(float));
  } else {
    const auto rows = py::cast<py::array>(colors);
    const auto* c = data_of<std::uint8_t>(rows, "colors", {points.shape(0), 3});
    out.element("vertex", count, {"float x", "float y", "float z", "uchar red", "uchar green", "uchar blue"});
    for (std::size_t i = 0; i < 3 * count; i += 3) {
      out.put_raw(p + i, 3 * sizeof(float));
      out.put_raw(c + i, 3);
    }
  }
  out.save(path);
}

py::dict counts_of(const base::StampCounts& c) {
  py::dict out;
  out["next"] = c.next;
  out["repeated"] = c.repeated;
  out["late"] = c.late;
  out["stray"] = c.stray;
  out["new_clocks"] = c.new_clocks;
  out["stuck_clocks"] = c.stuck_clocks;
  out["longest_repeat"] = c.longest_repeat;
  return out;
}

void bind_clock_watch(py::module_& m) {
  using base::ClockWatch;
  bind_words<base::StampVerdict>(m, "StampVerdict", "What a stamp says about the time of its source.");
  py::class_<ClockWatch>(m, "ClockWatch",
                         "Tells stamps that are late or mistaken, a few at a time, from a clock that was set anew for "
                         "good.\nStamps of one source are given to it in the order of their arrival. O(1).")
      .def(py::init([](base::StampNs max_lag_ns, const std::optional<base::StampNs>& max_lead_ns, int num_confirming) {
             if (max_lag_ns < 0 || max_lead_ns.value_or(0) < 0 || num_confirming < 1) {
               throw py::value_error("limits must not be negative, and num_confirming at least 1");
             }
             return ClockWatch({max_lag_ns, max_lead_ns, num_confirming});
           }),
           py::arg("max_lag_ns") = ClockWatch::Limits{}.max_lag_ns, py::arg("max_lead_ns") = py::none(),
           py::arg("num_confirming") = ClockWatch::Limits{}.num_confirming,
           "A stamp more than max_lag_ns behind the newest, or more than max_lead_ns ahead of it (None: any lead is\n"
           "believed), is on another clock; num_confirming such stamps in a row, rising, make that the clock.\n"
           "Raises ValueError for limits below zero.")
      .def(
          "add", [](ClockWatch& self, base::StampNs stamp_ns) { return to_member(self.add(stamp_ns)); },
          py::arg("stamp_ns"),
          "StampVerdict: NEXT; REPEATED, equal to the newest; LATE, older; STRAY, on another clock that nothing\n"
          "confirms yet; NEW_CLOCK, with which the strays before it are confirmed too.")
      .def("reset", &ClockWatch::reset, "Forget the clock; the counts stay.")
      .def_property_readonly(
          "newest_ns", [](const ClockWatch& self) { return self.newest_ns(); },
          "The newest stamp of the clock that is believed; None before the first.")
      .def_property_readonly("is_stuck", &ClockWatch::is_stuck, "Whether the last ten stamps or more were equal.")
      .def_property_readonly(
          "counts", [](const ClockWatch& self) { return counts_of(self.counts()); },
          "dict: next, repeated, late, stray, new_clocks, stuck_clocks, longest_repeat.")
      .def(
          "summary", [](const ClockWatch& self) { return base::describe(self.counts()); },
          "What was wrong with the stamps as a phrase for people; empty when they followed each other.");
}

}  // namespace

void bind_base(py::module_& m) {
  bind_clock_watch(m);
  py::class_<StageStatistics>(m, "StageStatistics",
                              "Time of one stage in constant memory; quantiles are exact within 7 %.")
      .def(py::init<>())
      .def(
          "add",
          [](StageStatistics& s, double wall_ms, double cpu_ms) {
            s.wall.add(wall_ms);
            s.cpu.add(cpu_ms);
          },
          py::arg("wall_ms"), py::arg("cpu_ms"))
      .def(
          "add_latency", [](StageStatistics& s, double ms) { s.latency.add(ms); }, py::arg("milliseconds"))
      .def_readwrite("dropped", &StageStatistics::dropped)
      .def("summary", &summary, "dict: count, dropped, mean_ms, median_ms, p99_ms, max_ms, cpu_ms, latency_*.");
  m.def(
      "process_usage",
      [] {
        const base::ProcessUsage usage = base::process_usage();
        py::dict out;
        out["rss_bytes"] = usage.rss_bytes;
        out["cpu_s"] = usage.cpu_s;
        return out;
      },
      "Resident memory and CPU time of this process.");
  m.def("write_ply_points", &write_ply_points, py::arg("path"), py::arg("points"), py::arg("colors") = py::none(),
        "Write points as a binary PLY file.\n\n"
        "points: (n, 3) float32 [m]; colors: (n, 3) uint8 red, green and blue, or None. Raises RuntimeError naming a\n"
        "file that cannot be written.");
}

}  // namespace voxnav::bindings
