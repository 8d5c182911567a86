// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <initializer_list>
#include <string>
#include <type_traits>

namespace voxnav::base {

/// Makes the bytes of a binary little-endian PLY file: a header that lists elements and their properties, then the rows
/// of each element in that order. Comments and elements go to the header, values to the rows, so that the caller names
/// each element right before the rows of it. Little-endian hosts only (x86-64, arm64).
/// Source of the format: Turk, The PLY Polygon File Format, 1994.
class PlyWriter {
 public:
  void comment(const std::string& text) { header_ += "comment " + text + "\n"; }
  /// @param properties  type and name, as in "float x" or "list uchar uint vertex_indices"
  void element(const std::string& name, std::size_t count, std::initializer_list<const char*> properties);
  template <class T>
  void put(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    put_raw(&value, sizeof(T));
  }
  void put_raw(const void* data, std::size_t size) { rows_.append(static_cast<const char*>(data), size); }
  /// The whole file. The writer is empty afterwards.
  std::string finish();
  /// @throws std::runtime_error naming the file when it cannot be written
  void save(const std::string& path);

 private:
  std::string header_;
  std::string rows_;
};

}  // namespace voxnav::base
