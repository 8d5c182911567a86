// SPDX-License-Identifier: BSD-3-Clause
#include <pybind11/stl.h>

#include "arrays.hpp"
#include "bind_config.hpp"
#include "floors.hpp"
#include "voxnav/cloud/cloud_filter.hpp"

namespace voxnav::bindings {
namespace {

using cloud::CloudLayout;
using cloud::FilterResult;
using cloud::Point;

py::array_t<float> rows_of(const std::vector<Point>& points) {
  py::array_t<float> out({static_cast<py::ssize_t>(points.size()), py::ssize_t{4}});
  float* p = out.mutable_data();
  for (const Point& point : points) {
    *p++ = point.x;
    *p++ = point.y;
    *p++ = point.z;
    *p++ = point.intensity;
  }
  return out;
}

py::array_t<std::uint32_t> times_of(const std::vector<Point>& points) {
  py::array_t<std::uint32_t> out(static_cast<py::ssize_t>(points.size()));
  std::uint32_t* t = out.mutable_data();
  for (const Point& point : points) *t++ = point.time_offset_ns;
  return out;
}

py::dict counts_of(const FilterResult& result) {
  py::dict out;
  for (const auto& [name, value] : result.counts.reasons()) out[name] = value;
  return out;
}

/// Layout of an (h, w, 4) or (n, 4) float32 array.
CloudLayout layout_of(const py::array& array) {
  const bool organised = array.ndim() == 3;
  data_of<float>(array, "cloud", organised ? std::vector<py::ssize_t>{-1, -1, 4} : std::vector<py::ssize_t>{-1, 4});
  CloudLayout layout;
  layout.height = organised ? static_cast<std::uint32_t>(array.shape(0)) : 1;
  layout.width = static_cast<std::uint32_t>(array.shape(organised ? 1 : 0));
  layout.point_step = 16;
  const char* names[] = {"x", "y", "z", "intensity"};
  for (std::uint32_t i = 0; i < 4; ++i) layout.fields.push_back({names[i], 4 * i, cloud::FieldType::kFloat32, 1});
  return layout;
}

FilterResult filter(cloud::CloudFilter& self, const CloudLayout& layout, const void* data, std::size_t size,
                    double stamp_s) {
  const cloud::RawCloudView view(layout, static_cast<const std::uint8_t*>(data), size, base::from_seconds(stamp_s));
  py::gil_scoped_release release;
  return self.apply(view);
}

FilterResult apply(cloud::CloudFilter& self, const py::array& array) {
  const CloudLayout layout = layout_of(array);
  return filter(self, layout, array.data(), static_cast<std::size_t>(array.nbytes()), 0.0);
}

FilterResult apply_raw(cloud::CloudFilter& self, const py::bytes& data, const CloudLayout& layout, double stamp_s) {
  char* bytes = nullptr;
  py::ssize_t size = 0;
  if (PyBytes_AsStringAndSize(data.ptr(), &bytes, &size) != 0) throw py::error_already_set();
  return filter(self, layout, bytes, static_cast<std::size_t>(size), stamp_s);
}

using FieldTuple = std::tuple<std::string, std::uint32_t, int, std::uint32_t>;

CloudLayout make_layout(std::uint32_t height, std::uint32_t width, std::uint32_t point_step,
                        const std::vector<FieldTuple>& fields, std::uint32_t row_step, bool is_big_endian) {
  CloudLayout layout;
  layout.height = height;
  layout.width = width;
  layout.point_step = point_step;
  layout.row_step = row_step;
  layout.is_big_endian = is_big_endian;
  for (const auto& [name, offset, datatype, count] : fields) {
    if (datatype < 0 || datatype > 255) throw py::value_error("field '" + name + "': datatype must be 1 to 8");
    layout.fields.push_back({name, offset, static_cast<cloud::FieldType>(datatype), count});
  }
  return layout;
}

void bind_layout(py::module_& m) {
  py::class_<CloudLayout>(m, "CloudLayout",
                          "How the bytes of a cloud are laid out (sensor_msgs/PointCloud2 without header).")
      .def(py::init(&make_layout), py::arg("height"), py::arg("width"), py::arg("point_step"), py::arg("fields"),
           py::arg("row_step") = 0, py::arg("is_big_endian") = false,
           "fields: list of (name, offset, datatype, count), datatypes numbered as in sensor_msgs/PointField.")
      .def("problem", &CloudLayout::problem, py::arg("data_size"),
           "Why so many bytes cannot be read as this layout; empty when they can.");
}

void bind_result(py::module_& m) {
  py::class_<FilterResult>(m, "FilterResult", "What CloudFilter made of one cloud.")
      .def_property_readonly(
          "points", [](const FilterResult& r) { return rows_of(r.points); },
          "(n, 4) float32: x y z in the sensor frame [m], intensity.")
      .def_property_readonly(
          "time_offsets_ns", [](const FilterResult& r) { return times_of(r.points); },
          "(n,) uint32, after the start of the sweep.")
      .def_property_readonly(
          "ghosts", [](const FilterResult& r) { return rows_of(r.ghosts); }, "(k, 4) float32.")
      .def_property_readonly(
          "far", [](const FilterResult& r) { return rows_of(r.far); }, "(k, 4) float32.")
      .def_property_readonly("counts", &counts_of, "Points by what became of them; the values sum up to `total`.")
      .def_property_readonly("total", [](const FilterResult& r) { return r.counts.total; })
      .def_property_readonly(
          "sweep_start_s", [](const FilterResult& r) { return base::to_seconds(r.sweep_start_ns); },
          "Start of the sweep after the cloud's stamp [s]; negative when the stamp is its end.")
      .def_readonly("num_bad_times", &FilterResult::num_bad_times)
      .def_readonly("is_ghost_filter_suspended", &FilterResult::is_ghost_filter_suspended,
                    "True when no return had any intensity, so that none was dropped for it.");
}

}  // namespace

void bind_cloud(py::module_& m) {
  bind_layout(m);
  bind_result(m);
  bind_config<cloud::CloudFilterConfig>(m, "CloudFilterConfig", "Which returns of a scan are kept.");
  py::class_<cloud::CloudFilter>(m, "CloudFilter",
                                 "Removes missing returns, own body, ghosts and surplus from scans. Not thread-safe.")
      .def(py::init<const cloud::CloudFilterConfig&>(), py::arg("config") = cloud::CloudFilterConfig())
      .def("apply", &apply, py::arg("cloud"),
           "Filter a cloud in the sensor frame.\n\n"
           "cloud: (h, w, 4) float32 organised, or (n, 4) float32; x y z [m], intensity.\n"
           "Returns FilterResult. Raises ValueError on another shape or dtype. O(points).")
      .def("apply_raw", &apply_raw, py::arg("data"), py::arg("layout"), py::arg("stamp_s") = 0.0,
           "Filter a cloud as drivers publish it, read in place.\n\n"
           "data: bytes; layout: CloudLayout; stamp_s: header stamp, for drivers with absolute point times.\n"
           "Raises ValueError saying what is wrong with the layout.");
}

}  // namespace voxnav::bindings
