// SPDX-License-Identifier: BSD-3-Clause
#include "pcl_filters.hpp"

#include <pybind11/stl.h>

#include <memory>
#include <string>

#include "bind_config.hpp"
#include "voxnav/cloud/pcl_filters.hpp"

namespace voxnav::bindings {

void bind_pcl_filters(py::module_& m) {
  bind_words<cloud::PclField>(m, "PclField", "What pass_through looks at.");
  bind_config<cloud::PclFiltersConfig>(
      m, "PclFiltersConfig", "Filters of PCL behind the CloudFilter, and their parameters as PCL names them.");
  py::class_<cloud::PclFilter>(m, "PclFilter", "One filter of PCL. Not thread-safe.")
      .def_property_readonly(
          "name", [](const cloud::PclFilter& f) { return std::string(base::word_of(f.kind())); },
          "As in PclFiltersConfig.filters.")
      .def("apply", &cloud::PclFilter::apply, py::arg("result"), py::call_guard<py::gil_scoped_release>(),
           "Filters the points of a FilterResult in place; what is dropped or merged is counted as `pcl`.");
  m.def(
      "make_pcl_filters",
      [](const cloud::PclFiltersConfig& config) {
        py::list out;
        for (auto& filter : cloud::make_pcl_filters(config)) out.append(py::cast(std::move(filter)));
        return out;
      },
      py::arg("config"),
      "List of PclFilter in the order of config.filters. Raises RuntimeError when voxnav was built without PCL.");
}

}  // namespace voxnav::bindings
