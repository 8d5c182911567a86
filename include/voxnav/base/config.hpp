// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

/// Every parameter of voxnav is written once, in a plain struct that lists its fields:
/// @code
///   struct FooConfig {
///     double resolution_m = 0.4;
///     template <class V> static void fields(V&& v) {
///       v("resolution_m", &FooConfig::resolution_m, base::in(0.01, 10.0), "m", "edge of one voxel");
///     }
///     std::vector<std::string> problems() const;   // optional: rules between fields
///   };
/// @endcode
/// The list feeds the ROS loader, the Python bindings, the shipped YAML test and docs/parameters.md.
namespace voxnav::base {

/// Thrown when a configuration is unusable; what() lists every problem, one per line.
class ConfigError : public std::invalid_argument {
 public:
  explicit ConfigError(const std::vector<std::string>& problems);
  const std::vector<std::string>& problems() const { return problems_; }

 private:
  std::vector<std::string> problems_;
};

/// What a field accepts: numbers inside [min, max] (bounds inclusive), or one of the named strings.
struct Rule {
  double min;
  double max;
  std::vector<std::string> choices;
};
Rule in(double min, double max);
Rule one_of(std::vector<std::string> choices);
Rule any();

/// A parameter value as YAML, XML-RPC and Python deliver it.
using Value = std::variant<bool, std::int64_t, double, std::string, std::vector<double>, std::vector<std::string>>;
using ValueMap = std::map<std::string, Value>;

std::string to_string(const Value& value);

namespace detail {

template <class T>
struct IsDoubleArray : std::false_type {};
template <std::size_t N>
struct IsDoubleArray<std::array<double, N>> : std::true_type {};

template <class T>
Value to_value(const T& field) {
  if constexpr (std::is_same_v<T, int>) {
    return static_cast<std::int64_t>(field);
  } else if constexpr (IsDoubleArray<T>::value) {
    return std::vector<double>(field.begin(), field.end());
  } else {
    return field;
  }
}

/// Strict conversions: an integer may become a double, nothing else changes type. Empty result = accepted.
std::string read(const Value& value, bool* field);
std::string read(const Value& value, int* field);
std::string read(const Value& value, double* field);
std::string read(const Value& value, std::string* field);
std::string read(const Value& value, std::vector<double>* field);
std::string read(const Value& value, std::vector<std::string>* field);
template <std::size_t N>
std::string read(const Value& value, std::array<double, N>* field) {
  std::vector<double> list;
  const std::string problem = read(value, &list);
  if (!problem.empty()) return problem;
  if (list.size() != N) return "needs " + std::to_string(N) + " numbers, has " + std::to_string(list.size());
  for (std::size_t i = 0; i < N; ++i) (*field)[i] = list[i];
  return {};
}

std::string range_problem(const std::string& name, const Value& value, const Rule& rule, const std::string& unit);
std::string unknown_problem(const std::string& name, const std::vector<std::string>& known);

template <class C, class = void>
struct HasProblems : std::false_type {};
template <class C>
struct HasProblems<C, std::void_t<decltype(std::declval<const C&>().problems())>> : std::true_type {};

}  // namespace detail

/// One field as documentation shows it.
struct FieldInfo {
  std::string name;
  Value value;
  Rule rule;
  std::string unit;
  std::string doc;
};

/// The fields of a configuration with their present values, in the order they are written.
template <class C>
std::vector<FieldInfo> describe(const C& config) {
  std::vector<FieldInfo> out;
  C::fields([&](const char* name, auto member, const Rule& rule, const char* unit, const char* doc) {
    out.push_back({name, detail::to_value(config.*member), rule, unit, doc});
  });
  return out;
}

/// Every broken rule of a configuration; empty when it is usable.
template <class C>
std::vector<std::string> problems_of(const C& config) {
  std::vector<std::string> out;
  for (const FieldInfo& field : describe(config)) {
    const std::string problem = detail::range_problem(field.name, field.value, field.rule, field.unit);
    if (!problem.empty()) out.push_back(problem);
  }
  if constexpr (detail::HasProblems<C>::value) {
    if (out.empty()) out = config.problems();
  }
  return out;
}

/// @throws ConfigError listing every broken rule. Constructors of core classes call this first.
template <class C>
const C& checked(const C& config) {
  const std::vector<std::string> problems = problems_of(config);
  if (!problems.empty()) throw ConfigError(problems);
  return config;
}

/// Set fields by name. Unknown names, wrong types and out-of-range values are returned as problems,
/// each naming key, value and what is allowed; `prefix` is put before the key (as "map/").
template <class C>
std::vector<std::string> assign(C* config, const ValueMap& values, const std::string& prefix = "") {
  std::vector<std::string> problems;
  std::vector<std::string> known;
  C::fields([&](const char* name, auto member, const Rule& rule, const char* unit, const char*) {
    known.emplace_back(name);
    const auto it = values.find(name);
    if (it == values.end()) return;
    std::string problem = detail::read(it->second, &(config->*member));
    if (!problem.empty()) {
      problem = prefix + name + " = " + to_string(it->second) + ": " + problem;
    } else {
      problem = detail::range_problem(prefix + name, detail::to_value(config->*member), rule, unit);
    }
    if (!problem.empty()) problems.push_back(problem);
  });
  for (const auto& [name, value] : values) {
    const std::string problem = detail::unknown_problem(name, known);
    if (!problem.empty()) problems.push_back(prefix + problem);
  }
  if constexpr (detail::HasProblems<C>::value) {
    if (problems.empty()) {
      for (const std::string& problem : config->problems()) problems.push_back(prefix + problem);
    }
  }
  return problems;
}

}  // namespace voxnav::base
