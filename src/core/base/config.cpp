// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/base/config.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <sstream>

namespace voxnav::base {
namespace {

std::string join(const std::vector<std::string>& parts, const std::string& separator) {
  std::string out;
  for (const std::string& part : parts) out += (out.empty() ? "" : separator) + part;
  return out;
}

std::string number(double value) {
  std::ostringstream out;
  out.precision(12);
  out << value;
  return out.str();
}

/// The Levenshtein distance finds the parameter that somebody may have meant.
std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t above = row[j];
      row[j] = std::min({above + 1, row[j - 1] + 1, diagonal + (a[i - 1] != b[j - 1] ? 1 : 0)});
      diagonal = above;
    }
  }
  return row.back();
}

std::string number_problem(double value, const Rule& rule, const std::string& unit) {
  if (value >= rule.min && value <= rule.max) return {};
  const std::string suffix = unit.empty() ? "" : " " + unit;
  return "allowed is " + number(rule.min) + " to " + number(rule.max) + suffix;
}

std::string word_problem(const std::string& word, const Rule& rule) {
  if (rule.choices.empty()) return {};
  if (std::find(rule.choices.begin(), rule.choices.end(), word) != rule.choices.end()) return {};
  return detail::choice_problem(rule.choices);
}

}  // namespace

ConfigError::ConfigError(const std::vector<std::string>& problems)
    : std::invalid_argument(join(problems, "\n")), problems_(problems) {}

Rule in(double min, double max) { return {min, max, {}}; }
Rule any() {
  const double infinity = std::numeric_limits<double>::infinity();
  return {-infinity, infinity, {}};
}

std::string to_string(const Value& value) {
  struct Printer {
    std::string operator()(bool v) const { return v ? "true" : "false"; }
    std::string operator()(std::int64_t v) const { return std::to_string(v); }
    std::string operator()(double v) const { return number(v); }
    std::string operator()(const std::string& v) const { return "'" + v + "'"; }
    std::string operator()(const std::vector<double>& v) const {
      std::vector<std::string> parts;
      parts.reserve(v.size());
      for (double x : v) parts.push_back(number(x));
      return "[" + join(parts, ", ") + "]";
    }
    std::string operator()(const std::vector<std::string>& v) const { return "[" + join(v, ", ") + "]"; }
  };
  return std::visit(Printer{}, value);
}

namespace detail {

std::string read(const Value& value, bool* field) {
  if (!std::holds_alternative<bool>(value)) return "needs true or false";
  *field = std::get<bool>(value);
  return {};
}

std::string read(const Value& value, int* field) {
  if (!std::holds_alternative<std::int64_t>(value)) return "needs an integer";
  const std::int64_t wide = std::get<std::int64_t>(value);
  if (wide < std::numeric_limits<int>::min() || wide > std::numeric_limits<int>::max()) return "does not fit 32 bits";
  *field = static_cast<int>(wide);
  return {};
}

std::string read(const Value& value, double* field) {
  if (std::holds_alternative<std::int64_t>(value)) {
    *field = static_cast<double>(std::get<std::int64_t>(value));
    return {};
  }
  if (!std::holds_alternative<double>(value)) return "needs a number";
  *field = std::get<double>(value);
  return {};
}

std::string read(const Value& value, std::string* field) {
  if (!std::holds_alternative<std::string>(value)) return "needs a string";
  *field = std::get<std::string>(value);
  return {};
}

std::string read(const Value& value, std::vector<double>* field) {
  // An empty list in YAML says nothing about the type of its elements.
  const auto* strings = std::get_if<std::vector<std::string>>(&value);
  if (strings && strings->empty()) {
    field->clear();
    return {};
  }
  if (!std::holds_alternative<std::vector<double>>(value)) return "needs a list of numbers";
  *field = std::get<std::vector<double>>(value);
  return {};
}

std::string read(const Value& value, std::vector<std::string>* field) {
  const auto* numbers = std::get_if<std::vector<double>>(&value);
  if (numbers && numbers->empty()) {
    field->clear();
    return {};
  }
  if (!std::holds_alternative<std::vector<std::string>>(value)) return "needs a list of strings";
  *field = std::get<std::vector<std::string>>(value);
  return {};
}

std::string choice_problem(const std::vector<std::string>& choices) {
  return "allowed is one of " + join(choices, ", ");
}

std::string range_problem(const std::string& name, const Value& value, const Rule& rule, const std::string& unit) {
  std::string problem;
  if (const auto* v = std::get_if<std::int64_t>(&value)) problem = number_problem(static_cast<double>(*v), rule, unit);
  if (const auto* v = std::get_if<double>(&value)) problem = number_problem(*v, rule, unit);
  if (const auto* v = std::get_if<std::string>(&value)) problem = word_problem(*v, rule);
  if (const auto* v = std::get_if<std::vector<double>>(&value)) {
    for (double x : *v) {
      if (problem.empty()) problem = number_problem(x, rule, unit);
    }
  }
  return problem.empty() ? problem : name + " = " + to_string(value) + ": " + problem;
}

std::string unknown_problem(const std::string& name, const std::vector<std::string>& known) {
  if (std::find(known.begin(), known.end(), name) != known.end()) return {};
  const auto nearest = std::min_element(known.begin(), known.end(), [&](const auto& a, const auto& b) {
    return edit_distance(name, a) < edit_distance(name, b);
  });
  std::string problem = name + ": unknown parameter";
  if (nearest != known.end() && edit_distance(name, *nearest) <= 4) problem += ", did you mean " + *nearest + "?";
  return problem;
}

}  // namespace detail
}  // namespace voxnav::base
