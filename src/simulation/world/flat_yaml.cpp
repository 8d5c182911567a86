// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav_simulation/flat_yaml.hpp"

#include <yaml-cpp/yaml.h>

#include <fstream>
#include <optional>
#include <sstream>

namespace voxnav_simulation {
namespace {

using voxnav::base::ConfigError;
using voxnav::base::Value;
using voxnav::base::ValueMap;

/// Returns "file:line: " for messages, with lines counted from one.
std::string place(const std::string& origin, const YAML::Mark& mark) {
  return origin + ":" + std::to_string(mark.line + 1) + ": ";
}

/// Returns the value of a scalar. yaml-cpp leaves it to the caller whether a text is a number; quoted text never is.
std::optional<Value> scalar(const YAML::Node& node) {
  if (!node.IsScalar()) return std::nullopt;
  const std::string& text = node.Scalar();
  if (node.Tag() == "!") return Value(text);
  if (text == "true") return Value(true);
  if (text == "false") return Value(false);
  std::int64_t integer = 0;
  if (YAML::convert<std::int64_t>::decode(node, integer)) return Value(integer);
  double number = 0.0;
  if (YAML::convert<double>::decode(node, number)) return Value(number);
  return Value(text);
}

std::optional<Value> list(const YAML::Node& node) {
  std::vector<double> numbers;
  std::vector<std::string> strings;
  for (const YAML::Node& item : node) {
    const std::optional<Value> value = scalar(item);
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

YAML::Node parsed(const std::string& text, const std::string& origin) {
  try {
    return YAML::Load(text);
  } catch (const YAML::ParserException& error) {
    throw ConfigError({place(origin, error.mark) + "is no YAML: " + error.msg});
  }
}

}  // namespace

ValueMap parse_flat_yaml(const std::string& text, const std::string& origin) {
  const YAML::Node root = parsed(text, origin);
  ValueMap values;
  std::vector<std::string> problems;
  if (root.IsNull()) return values;
  if (!root.IsMap()) throw ConfigError({place(origin, root.Mark()) + "needs lines of the form 'key: value'"});
  for (const auto& entry : root) {
    const std::optional<Value> value = entry.second.IsSequence() ? list(entry.second) : scalar(entry.second);
    const std::string where = place(origin, entry.first.Mark());
    if (!value || !entry.first.IsScalar()) {
      problems.push_back(where + "needs 'key: value' with a number, string, true, false or [list]");
    } else if (!values.emplace(entry.first.Scalar(), *value).second) {
      problems.push_back(where + "key " + entry.first.Scalar() + " is there twice");
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
