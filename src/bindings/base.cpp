// SPDX-License-Identifier: BSD-3-Clause
#include "arrays.hpp"
#include "floors.hpp"
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
  m.def("write_ply_points", &write_ply_points, py::arg("path"), py::arg("points"), py::arg("colors") = py::none(),
        "Write points as a binary PLY file.\n\n"
        "points: (n, 3) float32 [m]; colors: (n, 3) uint8 red, green and blue, or None. Raises RuntimeError naming a\n"
        "file that cannot be written.");
}

}  // namespace voxnav::bindings
