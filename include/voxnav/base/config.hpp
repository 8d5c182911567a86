// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "voxnav/base/config_value.hpp"

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
/// The list feeds the ROS loader, the Python bindings, the shipped YAML test and docs/parameters.md. A field that is
/// one of several choices is an enum with words (words.hpp): YAML, ROS and the documentation speak the words.
namespace voxnav::base {

/// Thrown when a configuration is unusable; what() lists every problem, one per line.
class ConfigError : public std::invalid_argument {
 public:
  explicit ConfigError(const std::vector<std::string>& problems);
  const std::vector<std::string>& problems() const { return problems_; }

 private:
  std::vector<std::string> problems_;
};

/// The values that a field accepts: numbers inside [min, max] (bounds inclusive), or one of the words of an enum.
struct Rule {
  double min;
  double max;
  std::vector<std::string> choices;
};
Rule in(double min, double max);
Rule any();
/// The rule of a field that is the enum E.
template <class E>
Rule one_of() {
  return {0.0, 0.0, all_words<E>()};
}

namespace detail {

std::string range_problem(const std::string& name, const Value& value, const Rule& rule, const std::string& unit);
std::string unknown_problem(const std::string& name, const std::vector<std::string>& known);

template <class C, class = void>
struct HasProblems : std::false_type {};
template <class C>
struct HasProblems<C, std::void_t<decltype(std::declval<const C&>().problems())>> : std::true_type {};

}  // namespace detail

/// One field with everything that the documentation says about it.
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

/// Gives a configuration back if it is usable. Constructors of core classes call this first.
/// @throws ConfigError listing every broken rule
template <class C>
const C& checked(const C& config) {
  const std::vector<std::string> problems = problems_of(config);
  if (!problems.empty()) throw ConfigError(problems);
  return config;
}

/// Sets fields by name. Unknown names, wrong types and values out of range are returned as problems, each of which
/// names key, value and what is allowed; `prefix` is put before the key (as "map/").
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
