// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/cloud/cloud_layout.hpp"

#include <algorithm>
#include <cctype>
#include <cstring>
#include <stdexcept>

namespace voxnav::cloud {
namespace {

/// No LiDAR has more points in a sweep, so a larger cloud has a damaged header.
constexpr std::uint64_t kMaxPoints = std::uint64_t{1} << 26;

template <class T>
double load(const std::uint8_t* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof(T));
  return static_cast<double>(value);
}

std::string field_problem(const CloudField& field, std::uint32_t point_step) {
  const std::size_t size = size_of(field.type);
  const std::string name = "field '" + field.name + "'";
  if (size == 0) return name + " has unknown datatype " + std::to_string(static_cast<int>(field.type));
  const std::uint64_t end = field.offset + std::uint64_t{size} * std::max(field.count, 1u);
  if (end <= point_step) return {};
  return name + " ends at byte " + std::to_string(end) + " of a point of " + std::to_string(point_step) + " bytes";
}

std::string coordinate_problem(const CloudLayout& layout, const char* name) {
  const CloudField* field = layout.find(name);
  if (!field) {
    std::string names;
    for (const CloudField& f : layout.fields) names += (names.empty() ? "" : ", ") + f.name;
    return std::string("field '") + name + "' is missing (the cloud has: " + (names.empty() ? "none" : names) + ")";
  }
  const bool is_float = field->type == FieldType::kFloat32 || field->type == FieldType::kFloat64;
  if (!is_float) return std::string("field '") + name + "' is " + name_of(field->type) + ", must be float32 or float64";
  if (field->count > 1)
    return std::string("field '") + name + "' has " + std::to_string(field->count) + " values per point";
  return {};
}

/// Returns what is wrong with the sizes of a layout. The sides are 32-bit numbers, so every product fits 64 bits.
std::string size_problem(const CloudLayout& layout, std::size_t data_size) {
  const std::string shape = std::to_string(layout.height) + " x " + std::to_string(layout.width) + " points";
  if (layout.num_points() > kMaxPoints) return shape + " are more than " + std::to_string(kMaxPoints);
  const std::uint64_t packed_row = static_cast<std::uint64_t>(layout.width) * layout.point_step;
  const std::uint64_t row = layout.bytes_per_row(data_size);
  if (row < packed_row && layout.height > 1) {
    return "row_step " + std::to_string(row) + " is shorter than " + std::to_string(layout.width) + " points of " +
           std::to_string(layout.point_step) + " bytes";
  }
  const std::uint64_t needed = (layout.height - std::uint64_t{1}) * row + packed_row;
  if (data_size >= needed) return {};
  return "data has " + std::to_string(data_size) + " bytes, " + shape + " of " + std::to_string(layout.point_step) +
         " bytes need " + std::to_string(needed);
}

FieldAccess access_of(const CloudField& field) { return {field.offset, field.type}; }

bool mentions_time(std::string name) {
  for (char& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return name.find("time") != std::string::npos || name.find("stamp") != std::string::npos;
}

/// Finds the time field, first by the names that drivers use, then by any name that contains the word time.
const CloudField* find_time(const CloudLayout& layout) {
  for (const char* name : {"t", "time", "timestamp", "time_stamp", "offset_time", "time_offset", "time_offset_ns"}) {
    if (const CloudField* field = layout.find(name)) return field;
  }
  const auto it = std::find_if(layout.fields.begin(), layout.fields.end(),
                               [](const CloudField& field) { return mentions_time(field.name); });
  return it == layout.fields.end() ? nullptr : &*it;
}

/// Finds the fields of beam directions: all three as floating-point numbers, or none.
void resolve_beam(const CloudLayout& layout, CloudAccess* access) {
  const CloudField* fields[] = {layout.find("beam_x"), layout.find("beam_y"), layout.find("beam_z")};
  for (const CloudField* field : fields) {
    if (!field || (field->type != FieldType::kFloat32 && field->type != FieldType::kFloat64)) return;
  }
  access->beam = {access_of(*fields[0]), access_of(*fields[1]), access_of(*fields[2])};
}

CloudAccess resolve(const CloudLayout& layout) {
  CloudAccess access;
  access.x = access_of(*layout.find("x"));
  access.y = access_of(*layout.find("y"));
  access.z = access_of(*layout.find("z"));
  for (const char* name : {"reflectivity", "intensity"}) {
    if (const CloudField* field = layout.find(name)) access.intensity = access_of(*field);
  }
  if (const CloudField* time = find_time(layout)) access.time = TimeField{time->name, access_of(*time)};
  resolve_beam(layout, &access);
  return access;
}

}  // namespace

std::size_t size_of(FieldType type) {
  constexpr std::size_t kSizes[] = {0, 1, 1, 2, 2, 4, 4, 4, 8, 8, 8};
  const auto index = static_cast<std::size_t>(type);
  return index < std::size(kSizes) ? kSizes[index] : 0;
}

const char* name_of(FieldType type) {
  constexpr const char* kNames[] = {"unknown", "int8",    "uint8",   "int16", "uint16", "int32",
                                    "uint32",  "float32", "float64", "int64", "uint64"};
  const auto index = static_cast<std::size_t>(type);
  return kNames[index < std::size(kNames) ? index : 0];
}

const CloudField* CloudLayout::find(const std::string& name) const {
  const auto it = std::find_if(fields.begin(), fields.end(), [&](const CloudField& f) { return f.name == name; });
  return it == fields.end() ? nullptr : &*it;
}

std::uint64_t CloudLayout::bytes_per_row(std::size_t data_size) const {
  const std::uint64_t packed_row = static_cast<std::uint64_t>(width) * point_step;
  const std::uint64_t packed = packed_row * height;
  const std::uint64_t needed = (height - std::uint64_t{1}) * row_step + packed_row;
  // If the buffer holds all points but is too short for the given row step, the rows are packed.
  const bool is_whole_cloud = height > 1 && row_step == packed && data_size >= packed && data_size < needed;
  return row_step == 0 || is_whole_cloud ? packed_row : row_step;
}

std::string CloudLayout::problem(std::size_t data_size) const {
  // Drivers announce empty clouds with and without fields; there is nothing to read either way.
  if (num_points() == 0) return {};
  if (is_big_endian) return "big-endian clouds are not supported";
  if (point_step == 0) return "point_step is 0";
  for (const CloudField& field : fields) {
    std::string problem = field_problem(field, point_step);
    if (!problem.empty()) return problem;
  }
  for (const char* name : {"x", "y", "z"}) {
    std::string problem = coordinate_problem(*this, name);
    if (!problem.empty()) return problem;
  }
  return size_problem(*this, data_size);
}

RawCloudView::RawCloudView(const CloudLayout& layout, const std::uint8_t* data, std::size_t data_size,
                           base::StampNs stamp_ns)
    : height_(layout.height),
      width_(layout.width),
      point_step_(layout.point_step),
      row_step_(layout.bytes_per_row(data_size)),
      stamp_ns_(stamp_ns),
      data_(data) {
  std::string problem = layout.problem(data_size);
  if (problem.empty() && num_points() > 0 && data == nullptr) problem = "no data";
  if (!problem.empty()) throw std::invalid_argument(problem);
  if (num_points() > 0) access_ = resolve(layout);
}

double read_number(const std::uint8_t* point, const FieldAccess& field) {
  const std::uint8_t* bytes = point + field.offset;
  switch (field.type) {
    case FieldType::kInt8:
      return load<std::int8_t>(bytes);
    case FieldType::kUint8:
      return load<std::uint8_t>(bytes);
    case FieldType::kInt16:
      return load<std::int16_t>(bytes);
    case FieldType::kUint16:
      return load<std::uint16_t>(bytes);
    case FieldType::kInt32:
      return load<std::int32_t>(bytes);
    case FieldType::kUint32:
      return load<std::uint32_t>(bytes);
    case FieldType::kFloat32:
      return load<float>(bytes);
    case FieldType::kFloat64:
      return load<double>(bytes);
    case FieldType::kInt64:
      return load<std::int64_t>(bytes);
    case FieldType::kUint64:
      return load<std::uint64_t>(bytes);
  }
  return 0.0;  // not reached: RawCloudView refuses unknown types
}

}  // namespace voxnav::cloud
