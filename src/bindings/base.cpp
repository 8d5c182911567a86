// SPDX-License-Identifier: BSD-3-Clause
#include "floors.hpp"
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

}  // namespace

void bind_base(py::module_& m) {
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
}

}  // namespace voxnav::bindings
