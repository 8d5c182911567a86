// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/cloud/depth_cloud.hpp"

#include <pybind11/stl.h>

#include <array>
#include <string>
#include <vector>

#include "arrays.hpp"
#include "bind_config.hpp"
#include "depth_cloud.hpp"

namespace voxnav::bindings {
namespace {

using cloud::CameraModel;

template <class T>
T field(const py::object& msg, const char* name) {
  return msg.attr(name).cast<T>();
}

/// Reads a sensor_msgs/CameraInfo of Python.
CameraModel camera_of(const py::object& msg) {
  cloud::CameraInfo info;
  info.width = field<std::uint32_t>(msg, "width");
  info.height = field<std::uint32_t>(msg, "height");
  info.K = field<std::array<double, 9>>(msg, "K");
  info.P = field<std::array<double, 12>>(msg, "P");
  info.binning_x = field<std::uint32_t>(msg, "binning_x");
  info.binning_y = field<std::uint32_t>(msg, "binning_y");
  const py::object roi = msg.attr("roi");
  info.roi_x = field<std::uint32_t>(roi, "x_offset");
  info.roi_y = field<std::uint32_t>(roi, "y_offset");
  info.roi_width = field<std::uint32_t>(roi, "width");
  info.roi_height = field<std::uint32_t>(roi, "height");
  return cloud::camera_of(info);
}

py::tuple converted(cloud::DepthCloud& self, const cloud::DepthImage& image, const CameraModel& camera) {
  std::vector<std::uint8_t> bytes;
  self.convert(image, camera, &bytes);
  return py::make_tuple(py::bytes(reinterpret_cast<const char*>(bytes.data()), bytes.size()), self.layout(camera));
}

/// Makes a cloud of a depth image: (h, w) uint16 in millimetres or float32 in metres.
py::tuple convert(cloud::DepthCloud& self, const py::array& image, const py::array& K) {
  const double* k = data_of<double>(K, "K", {3, 3});
  const bool is_millimetres = py::isinstance<py::array_t<std::uint16_t>>(image);
  if (is_millimetres) {
    data_of<std::uint16_t>(image, "image", {-1, -1});
  } else {
    data_of<float>(image, "image", {-1, -1});
  }
  cloud::CameraInfo info;
  info.height = static_cast<std::uint32_t>(image.shape(0));
  info.width = static_cast<std::uint32_t>(image.shape(1));
  std::copy(k, k + 9, info.K.begin());
  const CameraModel camera = cloud::camera_of(info);
  return converted(self,
                   {is_millimetres ? "16UC1" : "32FC1", info.width, info.height,
                    static_cast<std::uint32_t>(image.nbytes() / image.shape(0)), false,
                    static_cast<const std::uint8_t*>(image.data()), static_cast<std::size_t>(image.nbytes())},
                   camera);
}

/// Makes a cloud of a sensor_msgs/Image of Python.
py::tuple convert_message(cloud::DepthCloud& self, const py::object& msg, const CameraModel& camera) {
  const auto data = field<py::bytes>(msg, "data");
  char* bytes = nullptr;
  py::ssize_t size = 0;
  if (PyBytes_AsStringAndSize(data.ptr(), &bytes, &size) != 0) throw py::error_already_set();
  return converted(
      self,
      {field<std::string>(msg, "encoding"), field<std::uint32_t>(msg, "width"), field<std::uint32_t>(msg, "height"),
       field<std::uint32_t>(msg, "step"), field<int>(msg, "is_bigendian") != 0,
       reinterpret_cast<const std::uint8_t*>(bytes), static_cast<std::size_t>(size)},
      camera);
}

}  // namespace

void bind_depth_cloud(py::module_& m) {
  py::class_<CameraModel>(m, "CameraModel", "The pinhole camera of rectified images, axes right, down and forward.")
      .def_readonly("width", &CameraModel::width)
      .def_readonly("height", &CameraModel::height)
      .def_readonly("fx", &CameraModel::fx)
      .def_readonly("fy", &CameraModel::fy)
      .def_readonly("cx", &CameraModel::cx)
      .def_readonly("cy", &CameraModel::cy);
  m.def("camera_of", &camera_of, py::arg("camera_info"),
        "Returns the CameraModel of a sensor_msgs/CameraInfo, with binning and region of interest taken into account.\n"
        "Raises ValueError that says what is missing: the size, the intrinsics.");
  bind_config<cloud::DepthCloudConfig>(m, "DepthCloudConfig", "Which pixels of a depth image become points.");
  py::class_<cloud::DepthCloud>(m, "DepthCloud", "Turns depth images into organised clouds. Not thread-safe.")
      .def(py::init<const cloud::DepthCloudConfig&>(), py::arg("config") = cloud::DepthCloudConfig())
      .def("convert", &convert, py::arg("image"), py::arg("K"),
           "Converts a rectified image: (h, w) uint16 in millimetres or float32 in metres, 0 = none.\n\n"
           "K: (3, 3) float64 intrinsics. Returns the bytes of a cloud in the optical frame and its CloudLayout, for\n"
           "CloudFilter.apply_raw(). Raises ValueError.")
      .def("convert_message", &convert_message, py::arg("image"), py::arg("camera"),
           "Converts a sensor_msgs/Image of rectified depth, as convert() does. camera: CameraModel.\n\n"
           "Raises ValueError that says what is wrong with the image, or that it is of another size.");
}

}  // namespace voxnav::bindings
