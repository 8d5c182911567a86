// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

/// Enums that people read and write as words, in YAML, in messages and in Python. The words stand once, beside the
/// enum, in the order of its enumerators, which count from zero:
/// @code
///   enum class UnknownPolicy { kForbid, kPenalise };
///   constexpr auto words_of(UnknownPolicy) { return std::array{"forbid", "penalise"}; }
/// @endcode
/// Code decides by the enumerators; the words are made and understood only where text comes in or goes out.
namespace voxnav::base {

/// True for a type that is an enum with words.
template <class E, class = void>
struct HasWords : std::false_type {};
template <class E>
struct HasWords<E, std::void_t<decltype(words_of(std::declval<E>()))>> : std::is_enum<E> {};

/// All words of an enum, in the order of its enumerators.
template <class E>
std::vector<std::string> all_words() {
  constexpr auto words = words_of(E{});
  return {words.begin(), words.end()};
}

/// All values of an enum with words, in order.
template <class E>
std::vector<E> all_values() {
  std::vector<E> out;
  for (std::size_t i = 0; i < words_of(E{}).size(); ++i) out.push_back(static_cast<E>(i));
  return out;
}

/// The word of a value; of a number that is no enumerator "(none)", which no check accepts.
template <class E>
constexpr const char* word_of(E value) {
  constexpr auto words = words_of(E{});
  const auto index = static_cast<std::size_t>(value);
  return index < words.size() ? words[index] : "(none)";
}

/// The value that a word stands for, or nothing for a word that the enum does not have.
template <class E>
std::optional<E> value_of_word(const std::string& word) {
  for (const E value : all_values<E>()) {
    if (word == word_of(value)) return value;
  }
  return std::nullopt;
}

}  // namespace voxnav::base
