// SPDX-License-Identifier: BSD-3-Clause
#include <pybind11/stl.h>

#include <cstring>
#include <optional>

#include "arrays.hpp"
#include "bind_config.hpp"
#include "depth_cloud.hpp"
#include "floors.hpp"
#include "pcl_filters.hpp"
#include "voxnav/cloud/open_beams.hpp"
#include "voxnav/cloud/sweep.hpp"

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

FilterResult apply(cloud::CloudFilter& self, const py::array& array) {
  const auto* bytes = static_cast<const std::uint8_t*>(array.data());
  const cloud::RawCloudView view(layout_of(array), bytes, static_cast<std::size_t>(array.nbytes()));
  py::gil_scoped_release release;
  return self.apply(view);
}

cloud::RawCloudView view_of(const py::bytes& data, const CloudLayout& layout, base::StampNs stamp_ns) {
  char* bytes = nullptr;
  py::ssize_t size = 0;
  if (PyBytes_AsStringAndSize(data.ptr(), &bytes, &size) != 0) throw py::error_already_set();
  return {layout, reinterpret_cast<const std::uint8_t*>(bytes), static_cast<std::size_t>(size), stamp_ns};
}

FilterResult apply_raw(cloud::CloudFilter& self, const py::bytes& data, const CloudLayout& layout, double stamp_s,
                       const std::optional<base::StampNs>& stamp_ns) {
  const auto view = view_of(data, layout, stamp_ns ? *stamp_ns : base::from_seconds(stamp_s));
  py::gil_scoped_release release;
  return self.apply(view);
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

std::vector<FieldTuple> fields_of(const CloudLayout& layout) {
  std::vector<FieldTuple> out;
  for (const auto& field : layout.fields)
    out.emplace_back(field.name, field.offset, static_cast<int>(field.type), field.count);
  return out;
}

py::array_t<float> rows_of(const std::vector<geometry::Vec3f>& points) {
  py::array_t<float> out({static_cast<py::ssize_t>(points.size()), py::ssize_t{3}});
  if (!points.empty()) std::memcpy(out.mutable_data(), points.front().data(), points.size() * sizeof(geometry::Vec3f));
  return out;
}

std::vector<geometry::Vec3f> directions_of(const py::object& rows) {
  if (rows.is_none()) return {};
  const auto array = py::cast<py::array>(rows);
  const float* data = data_of<float>(array, "open_beams", {-1, 3});
  std::vector<geometry::Vec3f> out(static_cast<std::size_t>(array.shape(0)));
  if (!out.empty()) std::memcpy(out.front().data(), data, out.size() * sizeof(geometry::Vec3f));
  return out;
}

void bind_sweep(py::module_& m) {
  using cloud::Sweep;
  py::class_<Sweep>(m, "Sweep",
                    "One turn of a LiDAR or image of a depth camera: points with their times, and open beams.\n"
                    "See read_sweep().")
      .def_readonly("stamp_ns", &Sweep::stamp_ns)
      .def_readonly("start_ns", &Sweep::start_ns, "When the sweep began.")
      .def_readonly("duration_ns", &Sweep::duration_ns, "The largest time offset.")
      .def_readwrite("sensor", &Sweep::sensor, "Number of the sensor among those of the vehicle.")
      .def_property_readonly(
          "points", [](const Sweep& s) { return rows_of(s.points); },
          "(n, 3) float32, sensor frame [m], each as seen at its time.")
      .def_property_readonly(
          "time_offsets_ns",
          [](const Sweep& s) {
            return py::array_t<std::uint32_t>(static_cast<py::ssize_t>(s.time_offsets_ns.size()),
                                              s.time_offsets_ns.data());
          },
          "(n,) uint32, after start_ns.")
      .def_property_readonly(
          "open_beams", [](const Sweep& s) { return rows_of(s.open_beams); },
          "(k, 3) float32 unit directions in which nothing returned.");
  m.def(
      "read_sweep",
      [](const py::bytes& data, const CloudLayout& layout, base::StampNs stamp_ns) {
        return cloud::read_sweep(view_of(data, layout, stamp_ns));
      },
      py::arg("data"), py::arg("layout"), py::arg("stamp_ns") = 0,
      "Reads a cloud, as drivers publish it, into a Sweep.\n\n"
      "data: bytes; layout: CloudLayout; stamp_ns: stamp of the cloud's header.\n"
      "Raises ValueError that says what is wrong with the layout. O(points).");
  bind_config<cloud::OpenBeamsConfig>(m, "OpenBeamsConfig", "Which beams without return count as open beams.");
  py::class_<cloud::OpenBeams>(
      m, "OpenBeams",
      "Finds the open beams of organised scans: those that met nothing, and neither did their neighbours. Not "
      "thread-safe.")
      .def(py::init<const cloud::OpenBeamsConfig&>(), py::arg("config") = cloud::OpenBeamsConfig())
      .def(
          "find",
          [](cloud::OpenBeams& self, const py::bytes& data, const CloudLayout& layout) {
            return rows_of(self.find(view_of(data, layout, 0)));
          },
          py::arg("data"), py::arg("layout"), "(k, 3) float32 unit directions, sensor frame; learns from each scan.");
}

void bind_point_times(py::module_& m) {
  using cloud::PointTimes;
  using cloud::TimesReport;
  bind_words<cloud::TimeUnit>(m, "TimeUnit", "What one step of a time field lasts.");
  bind_words<cloud::TimeZero>(m, "TimeZero", "From when a time field counts.");
  bind_words<cloud::TimesState>(m, "TimesState", "How much is known of a sensor's time field.");
  py::class_<TimesReport>(m, "TimesReport", "What is known of a sensor's time field, and how.")
      .def_property_readonly(
          "state", [](const TimesReport& r) { return to_member(r.state); },
          "TimesState: NO_FIELD; UNDECIDED, the times are not used; BY_NAME; MEASURED.")
      .def_readonly("field", &TimesReport::field, "Its name; empty when there is none.")
      .def_property_readonly("type", [](const TimesReport& r) { return std::string(cloud::name_of(r.type)); })
      .def_property_readonly(
          "unit", [](const TimesReport& r) { return to_member(r.unit); }, "TimeUnit, unless undecided.")
      .def_property_readonly(
          "zero", [](const TimesReport& r) { return to_member(r.zero); }, "TimeZero, unless undecided.")
      .def_readonly("sweep_period_ns", &TimesReport::sweep_period_ns, "Median step between stamps, or None.")
      .def_readonly("sweep_span_ns", &TimesReport::sweep_span_ns, "Longest that the points of a cloud took.")
      .def_readonly("is_stamp_at_end", &TimesReport::is_stamp_at_end)
      .def_readonly("num_clouds", &TimesReport::num_clouds, "With a time field.")
      .def_readonly("num_clouds_untimed", &TimesReport::num_clouds_untimed, "Whose times were not used.")
      .def_readonly("how", &TimesReport::how, "What the field counts and how that was decided, or why not.")
      .def_property_readonly("problem", &cloud::problem_of, "What is wrong, for people; empty when all were used.");
  py::class_<PointTimes>(m, "PointTimes",
                         "Finds out what the point times of one sensor count, by how long its sweeps last. CloudFilter "
                         "has one of its own.")
      .def(py::init<>())
      .def(
          "judge",
          [](PointTimes& self, const py::bytes& data, const CloudLayout& layout, base::StampNs stamp_ns) {
            return self.judge(view_of(data, layout, stamp_ns)).tick_ns > 0.0;
          },
          py::arg("data"), py::arg("layout"), py::arg("stamp_ns"),
          "Take the next cloud of the sensor into account. Returns whether its times can be used. Raises ValueError\n"
          "saying what is wrong with the layout.")
      .def_property_readonly("report", &PointTimes::report, "TimesReport after the clouds so far.");
}

void bind_layout(py::module_& m) {
  py::class_<CloudLayout>(m, "CloudLayout",
                          "How the bytes of a cloud are laid out (sensor_msgs/PointCloud2 without header).")
      .def(py::init(&make_layout), py::arg("height"), py::arg("width"), py::arg("point_step"), py::arg("fields"),
           py::arg("row_step") = 0, py::arg("is_big_endian") = false,
           "fields: list of (name, offset, datatype, count), datatypes numbered as in sensor_msgs/PointField.")
      .def_readonly("height", &CloudLayout::height)
      .def_readonly("width", &CloudLayout::width)
      .def_readonly("point_step", &CloudLayout::point_step, "Bytes from point to point.")
      .def_property_readonly("fields", &fields_of, "As the constructor takes them.")
      .def("problem", &CloudLayout::problem, py::arg("data_size"),
           "Explains why data of this many bytes cannot be read with this layout; empty if it can.");
}

void bind_result(py::module_& m) {
  py::class_<FilterResult>(m, "FilterResult", "The result of CloudFilter for one cloud.")
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
      .def_property_readonly("counts", &counts_of, "Numbers of points kept and removed by reason; they sum to `total`.")
      .def_property_readonly("total", [](const FilterResult& r) { return r.counts.total; })
      .def_property_readonly(
          "sweep_start_s", [](const FilterResult& r) { return base::to_seconds(r.sweep_start_ns); },
          "Start of the sweep relative to the cloud's stamp [s]; negative if the stamp is the end of the sweep.")
      .def(
          "sweep",
          [](const FilterResult& r, base::StampNs stamp_ns, const py::object& open_beams, std::size_t sensor) {
            cloud::Sweep sweep = cloud::sweep_of(r, stamp_ns, directions_of(open_beams));
            sweep.sensor = sensor;
            return sweep;
          },
          py::arg("stamp_ns"), py::arg("open_beams") = py::none(), py::arg("sensor") = 0,
          "The filtered points as a Sweep.\n\n"
          "The stamp is that of the cloud; open_beams: (k, 3) float32 from OpenBeams.find(); sensor: number of the "
          "sensor\namong those of the vehicle.")
      .def_readonly("num_bad_times", &FilterResult::num_bad_times)
      .def_readonly("is_ghost_filter_suspended", &FilterResult::is_ghost_filter_suspended,
                    "True if no return had any intensity, so that none was removed as a ghost.")
      .def_readonly("is_outlier_filter_suspended", &FilterResult::is_outlier_filter_suspended,
                    "True if most returns have no neighbours in the image, so that none was removed as an outlier.");
}

}  // namespace

void bind_cloud(py::module_& m) {
  bind_layout(m);
  bind_point_times(m);
  bind_sweep(m);
  bind_depth_cloud(m);
  bind_result(m);
  bind_config<cloud::CloudFilterConfig>(m, "CloudFilterConfig", "Which returns of a scan are kept.");
  py::class_<cloud::CloudFilter>(m, "CloudFilter",
                                 "Removes missing returns, returns of the vehicle itself, ghosts and surplus points "
                                 "from scans. Not thread-safe.")
      .def(py::init<const cloud::CloudFilterConfig&>(), py::arg("config") = cloud::CloudFilterConfig())
      .def("apply", &apply, py::arg("cloud"),
           "Filters a cloud in the sensor frame.\n\n"
           "cloud: (h, w, 4) float32 organised, or (n, 4) float32; x y z [m], intensity.\n"
           "Returns FilterResult. Raises ValueError on another shape or dtype. O(points).")
      .def("apply_raw", &apply_raw, py::arg("data"), py::arg("layout"), py::arg("stamp_s") = 0.0,
           py::arg("stamp_ns") = py::none(),
           "Filters a cloud as drivers publish it, which is read in place.\n\n"
           "data: bytes; layout: CloudLayout; stamp_s: header stamp, for drivers with absolute point times, or "
           "stamp_ns,\n"
           "the same to the last nanosecond.\n"
           "Raises ValueError that says what is wrong with the layout.")
      .def_property_readonly("point_times", &cloud::CloudFilter::point_times,
                             "TimesReport: what is known of the sensor's point times after the clouds so far.");
  bind_pcl_filters(m);
}

}  // namespace voxnav::bindings
