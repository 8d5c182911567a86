// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav_simulation/flat_yaml.hpp"

#include <fstream>
#include <optional>
#include <sstream>

namespace voxnav_simulation {
namespace {

using voxnav::base::ConfigError;
using voxnav::base::Value;
using voxnav::base::ValueMap;

std::string trimmed(const std::string& text) {
  const auto first = text.find_first_not_of(" \t\r");
  if (first == std::string::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

/// Cuts a comment: a # outside of quotes at the start or after a blank.
std::string without_comment(const std::string& line) {
  char quote = 0;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (quote) {
      if (line[i] == quote) quote = 0;
    } else if (line[i] == '"' || line[i] == '\'') {
      quote = line[i];
    } else if (line[i] == '#' && (i == 0 || line[i - 1] == ' ' || line[i - 1] == '\t')) {
      return line.substr(0, i);
    }
  }
  return line;
}

bool is_integer(const std::string& text) {
  const std::size_t start = text[0] == '-' || text[0] == '+' ? 1 : 0;
  return text.size() > start && text.size() < 19 && text.find_first_not_of("0123456789", start) == std::string::npos;
}

std::optional<Value> scalar(const std::string& text) {
  if (text.empty()) return std::nullopt;
  if (text == "true") return Value(true);
  if (text == "false") return Value(false);
  if (text.size() >= 2 && (text[0] == '"' || text[0] == '\'') && text.back() == text[0]) {
    return Value(text.substr(1, text.size() - 2));
  }
  if (is_integer(text)) return Value(static_cast<std::int64_t>(std::stoll(text)));
  std::istringstream number(text);
  number.imbue(std::locale::classic());
  double value = 0.0;
  if (number >> value && number.peek() == std::istringstream::traits_type::eof()) return Value(value);
  if (text.find_first_of("[]{}:,&*!|>%@`\"'") != std::string::npos) return std::nullopt;
  return Value(text);
}

std::optional<Value> list(const std::string& inside) {
  std::vector<double> numbers;
  std::vector<std::string> strings;
  std::istringstream items(inside);
  for (std::string item; std::getline(items, item, ',');) {
    const std::optional<Value> value = scalar(trimmed(item));
    if (!value) return std::nullopt;
    if (const auto* text = std::get_if<std::string>(&*value)) {
      strings.push_back(*text);
    } else if (const auto* real = std::get_if<double>(&*value)) {
      numbers.push_back(*real);
    } else if (const auto* integer = std::get_if<std::int64_t>(&*value)) {
      numbers.push_back(static_cast<double>(*integer));
    } else {
      return std::nullopt;
    }
  }
  if (!strings.empty() && !numbers.empty()) return std::nullopt;
  if (!strings.empty()) return Value(strings);
  return Value(numbers);
}

std::optional<Value> value_of(const std::string& text) {
  if (text.size() >= 2 && text.front() == '[' && text.back() == ']') return list(text.substr(1, text.size() - 2));
  return scalar(text);
}

}  // namespace

ValueMap parse_flat_yaml(const std::string& text, const std::string& origin) {
  ValueMap values;
  std::vector<std::string> problems;
  std::istringstream lines(text);
  int number = 0;
  for (std::string raw; std::getline(lines, raw);) {
    ++number;
    const std::string line = trimmed(without_comment(raw));
    if (line.empty() || line == "---") continue;
    const auto colon = line.find(": ");
    const std::optional<Value> value =
        colon == std::string::npos ? std::nullopt : value_of(trimmed(line.substr(colon + 1)));
    const std::string where = origin + ":" + std::to_string(number) + ": ";
    if (!value) {
      problems.push_back(where + "needs 'key: value' with a number, string, true, false or [list]");
    } else if (!values.emplace(trimmed(line.substr(0, colon)), *value).second) {
      problems.push_back(where + "key is there twice");
    }
  }
  if (!problems.empty()) throw ConfigError(problems);
  return values;
}

ValueMap read_flat_yaml(const std::string& path) {
  std::ifstream file(path);
  std::stringstream text;
  if (!file || !(text << file.rdbuf())) throw ConfigError({path + ": cannot be read, or is empty"});
  return parse_flat_yaml(text.str(), path);
}

}  // namespace voxnav_simulation
