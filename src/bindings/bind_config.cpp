// SPDX-License-Identifier: BSD-3-Clause
#include "bind_config.hpp"

namespace voxnav::bindings {
namespace {

base::Value list_value(const std::string& key, const py::sequence& list) {
  std::vector<double> numbers;
  std::vector<std::string> strings;
  for (const py::handle item : list) {
    if (py::isinstance<py::str>(item)) {
      strings.push_back(py::cast<std::string>(item));
    } else if ((PyNumber_Check(item.ptr()) != 0) && !PyBool_Check(item.ptr())) {
      numbers.push_back(PyFloat_AsDouble(py::float_(py::reinterpret_borrow<py::object>(item)).ptr()));
    } else {
      throw base::ConfigError({key + ": a list may hold numbers or strings only"});
    }
  }
  if (!numbers.empty() && !strings.empty()) throw base::ConfigError({key + ": a list may not mix numbers and strings"});
  if (!strings.empty()) return strings;
  return numbers;
}

base::Value value_of(const std::string& key, const py::handle& object) {
  if (PyBool_Check(object.ptr())) return py::cast<bool>(object);
  if (py::isinstance<py::str>(object)) return py::cast<std::string>(object);
  if (PyFloat_Check(object.ptr())) return py::cast<double>(object);
  if (PyLong_Check(object.ptr())) return py::cast<std::int64_t>(object);
  if (PyIndex_Check(object.ptr()))
    return py::cast<std::int64_t>(py::reinterpret_steal<py::object>(PyNumber_Index(object.ptr())));
  if (py::isinstance<py::sequence>(object)) return list_value(key, py::reinterpret_borrow<py::sequence>(object));
  if (PyNumber_Check(object.ptr()))
    return PyFloat_AsDouble(py::float_(py::reinterpret_borrow<py::object>(object)).ptr());
  throw base::ConfigError({key + ": values are booleans, numbers, strings or lists"});
}

}  // namespace

base::ValueMap to_values(const py::dict& dict) {
  base::ValueMap out;
  for (const auto& item : dict) {
    const auto key = py::cast<std::string>(py::str(item.first));
    out[key] = value_of(key, item.second);
  }
  return out;
}

py::object to_python(const base::Value& value) {
  return std::visit([](const auto& v) -> py::object { return py::cast(v); }, value);
}

}  // namespace voxnav::bindings
