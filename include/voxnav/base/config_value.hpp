// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

#include "voxnav/base/words.hpp"

namespace voxnav::base {

/// A parameter value as YAML, XML-RPC and Python deliver it; that of an enum is its word.
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
  } else if constexpr (HasWords<T>::value) {
    return std::string(word_of(field));
  } else if constexpr (IsDoubleArray<T>::value) {
    return std::vector<double>(field.begin(), field.end());
  } else {
    return field;
  }
}

/// Strict conversions: an integer may become a double and a word an enum, nothing else changes type. An empty result
/// means that the value was accepted.
std::string read(const Value& value, bool* field);
std::string read(const Value& value, int* field);
std::string read(const Value& value, double* field);
std::string read(const Value& value, std::string* field);
std::string read(const Value& value, std::vector<double>* field);
std::string read(const Value& value, std::vector<std::string>* field);
template <std::size_t N>
std::string read(const Value& value, std::array<double, N>* field) {
  std::vector<double> list;
  std::string problem = read(value, &list);
  if (!problem.empty()) return problem;
  if (list.size() != N) return "needs " + std::to_string(N) + " numbers, has " + std::to_string(list.size());
  for (std::size_t i = 0; i < N; ++i) (*field)[i] = list[i];
  return {};
}

std::string choice_problem(const std::vector<std::string>& choices);
template <class E, class = std::enable_if_t<HasWords<E>::value>>
std::string read(const Value& value, E* field) {
  std::string word;
  std::string problem = read(value, &word);
  if (!problem.empty()) return problem;
  const std::optional<E> known = value_of_word<E>(word);
  if (!known) return choice_problem(all_words<E>());
  *field = *known;
  return {};
}

}  // namespace detail
}  // namespace voxnav::base
