// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "pybind.hpp"
#include "voxnav/base/words.hpp"

namespace voxnav::bindings {

namespace py = pybind11;

/// A Python enum whose members are their words: `PlanStatus.NO_PATH`, equal to "no_path", printed as no_path.
/// Functions therefore take a member or its word alike, as a std::string.
py::object make_word_enum(const py::module_& m, const char* name, const std::vector<std::string>& words,
                          const char* doc);
/// @throws py::value_error naming the argument, what it may be and what it is
[[noreturn]] void refuse_word(const char* argument, const std::vector<std::string>& words, const std::string& given);

/// The Python enum of E; null before bind_words<E>() was called.
template <class E>
py::handle& word_enum() {
  static py::handle type = py::none();
  return type;
}

template <class E>
void bind_words(py::module_& m, const char* name, const char* doc) {
  py::object type = make_word_enum(m, name, base::all_words<E>(), doc);
  m.attr(name) = type;
  word_enum<E>() = type.release();  // lives as long as the interpreter
}

/// The member of the Python enum for a value.
template <class E>
py::object to_member(E value) {
  return word_enum<E>()(base::word_of(value));
}

/// The value for a member of the Python enum or its word.
template <class E>
E from_word(const std::string& given, const char* argument) {
  const auto value = base::value_of_word<E>(given);
  if (!value) refuse_word(argument, base::all_words<E>(), given);
  return *value;
}

}  // namespace voxnav::bindings
