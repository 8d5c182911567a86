// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pybind11/stl.h>

#include "bind_words.hpp"
#include "pybind.hpp"
#include "voxnav/base/config.hpp"

namespace voxnav::bindings {

namespace py = pybind11;

/// @throws base::ConfigError naming the key if no field can have the type of the value
base::ValueMap to_values(const py::dict& dict);
py::object to_python(const base::Value& value);

/// Converts a field for Python. An enum becomes a member of its Python enum, which bind_words() must have made before.
template <class T>
py::object field_object(const T& field) {
  if constexpr (base::HasWords<T>::value) {
    return to_member(field);
  } else {
    return to_python(base::detail::to_value(field));
  }
}

/// Assigns keyword arguments on top of the defaults; raises ConfigError listing every problem.
template <class C>
C config_from(const py::dict& values) {
  C config;
  const std::vector<std::string> problems = base::assign(&config, to_values(values));
  if (!problems.empty()) throw base::ConfigError(problems);
  return config;
}

/// One Python class per configuration: `Name(**fields)`, attributes, `to_dict()`, `describe()`.
template <class C>
py::class_<C> bind_config(py::module_& m, const char* name, const char* doc) {
  py::class_<C> cls(m, name, doc);
  cls.def(py::init([](const py::kwargs& kwargs) { return config_from<C>(kwargs); }),
          "Defaults, with fields set by keyword.\n\nRaises ConfigError listing every unknown, mistyped or out-of-range "
          "field.");
  cls.def_static("from_dict", &config_from<C>, py::arg("values"),
                 "Makes a configuration from a dict, as YAML gives it.");
  C::fields([&](const char* field, auto member, const base::Rule& rule, const char* unit, const char* field_doc) {
    const std::string text = std::string(field_doc) + (*unit ? std::string(" [") + unit + "]" : std::string());
    const std::string key = field;
    cls.def_property(
        field, [member](const C& c) { return field_object(c.*member); },
        [key](C& c, const py::object& value) {
          C changed = c;
          py::dict one;
          one[py::str(key)] = value;
          const std::vector<std::string> problems = base::assign(&changed, to_values(one));
          if (!problems.empty()) throw base::ConfigError(problems);
          c = changed;
        },
        text.c_str());
    (void)rule;
  });
  cls.def("to_dict", [](const C& c) {
    py::dict out;
    for (const auto& field : base::describe(c)) out[py::str(field.name)] = to_python(field.value);
    return out;
  });
  cls.def_static(
      "describe",
      [] {
        py::list out;
        for (const auto& f : base::describe(C{})) {
          py::dict row;
          row["name"] = f.name;
          row["default"] = to_python(f.value);
          row["min"] = f.rule.min;
          row["max"] = f.rule.max;
          row["choices"] = f.rule.choices;
          row["unit"] = f.unit;
          row["doc"] = f.doc;
          out.append(row);
        }
        return out;
      },
      "List of dicts (name, default, min, max, choices, unit, doc), in source order.");
  const std::string class_name = name;
  cls.def("__repr__", [class_name](const C& c) {
    std::string out = class_name + "(";
    bool first = true;
    for (const auto& f : base::describe(c)) {
      out += (first ? "" : ", ") + f.name + "=" + base::to_string(f.value);
      first = false;
    }
    return out + ")";
  });
  return cls;
}

}  // namespace voxnav::bindings
