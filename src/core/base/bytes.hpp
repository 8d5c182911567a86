// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>
#include <type_traits>

namespace voxnav::base {

/// CRC-32 (IEEE 802.3) of a byte range.
std::uint32_t crc32(const char* data, std::size_t size);

/// The header of our files and messages: eight bytes that tell their content and the version of its format.
struct Format {
  std::uint32_t magic;
  std::uint32_t version;
  const char* name;  ///< with its article, as in "is not a voxnav submap"
};

/// Appends plain values to a byte string. Little-endian hosts only (x86-64, arm64).
class ByteWriter {
 public:
  template <class T>
  void put(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof(T));
  }
  void put_raw(const void* data, std::size_t size) { bytes_.append(static_cast<const char*>(data), size); }
  void put_header(const Format& format) {
    put(format.magic);
    put(format.version);
  }
  /// Appends the checksum of all that was written and hands the string out.
  std::string finish();

 private:
  std::string bytes_;
};

/// Reads what ByteWriter wrote. Every read past the end throws std::invalid_argument naming `what`, so that nobody goes
/// on with input that is truncated or corrupt.
class ByteReader {
 public:
  /// @throws std::invalid_argument when the checksum at the end does not match
  ByteReader(const std::string& bytes, std::string what);

  template <class T>
  T get() {
    static_assert(std::is_trivially_copyable_v<T>);
    T value;
    get_raw(&value, sizeof(T));
    return value;
  }
  /// Skips the header. @throws std::invalid_argument when the bytes hold something else or another version of it
  void check_header(const Format& format);
  void get_raw(void* data, std::size_t size) {
    if (size > end_ - position_) fail("ends early");
    if (size > 0) std::memcpy(data, bytes_->data() + position_, size);  // the data() of an empty vector may be null
    position_ += size;
  }
  /// A count of items of which each takes at least `item_size` bytes: refused when they cannot all be there.
  std::uint64_t get_count(std::size_t item_size);
  std::size_t remaining() const { return end_ - position_; }
  [[noreturn]] void fail(const std::string& why) const;

 private:
  const std::string* bytes_;
  std::string what_;
  std::size_t position_ = 0;
  std::size_t end_ = 0;
};

}  // namespace voxnav::base
