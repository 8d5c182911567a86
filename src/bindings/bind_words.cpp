// SPDX-License-Identifier: BSD-3-Clause
#include "bind_words.hpp"

#include <algorithm>
#include <cctype>

namespace voxnav::bindings {
namespace {

/// "os0-128" becomes OS0_128.
std::string member_name(std::string word) {
  std::replace(word.begin(), word.end(), '-', '_');
  std::transform(word.begin(), word.end(), word.begin(), [](unsigned char c) { return std::toupper(c); });
  return word;
}

/// enum.Enum over str whose members print as their words in every version of Python.
py::object base_class() {
  const py::object str = py::reinterpret_borrow<py::object>(reinterpret_cast<PyObject*>(&PyUnicode_Type));
  py::object base = py::module_::import("enum").attr("Enum")("WordEnum", py::list(), py::arg("module") = "voxnav",
                                                             py::arg("type") = str);
  for (const char* method : {"__str__", "__format__"}) base.attr(method) = str.attr(method);
  return base;
}

}  // namespace

py::object make_word_enum(const py::module_& m, const char* name, const std::vector<std::string>& words,
                          const char* doc) {
  py::list members;
  for (const std::string& word : words) members.append(py::make_tuple(member_name(word), word));
  // Pickles find the enum where people do: voxnav._core is a part of voxnav.
  const std::string module = py::cast<std::string>(m.attr("__name__"));
  py::object type = base_class()(name, members, py::arg("module") = module);
  type.attr("__doc__") = doc;
  return type;
}

void refuse_word(const char* argument, const std::vector<std::string>& words, const std::string& given) {
  std::string list;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (i > 0) list += i + 1 == words.size() ? " or " : ", ";
    list += words[i];
  }
  throw py::value_error(std::string(argument) + " must be " + list + ", got '" + given + "'");
}

}  // namespace voxnav::bindings
