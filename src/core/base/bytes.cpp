// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/base/bytes.hpp"

#include <array>

namespace voxnav::base {
namespace {

std::array<std::uint32_t, 256> make_crc_table() {
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t i = 0; i < 256; ++i) {
    std::uint32_t c = i;
    for (int bit = 0; bit < 8; ++bit) c = (c & 1u) ? 0xEDB88320u ^ (c >> 1) : c >> 1;
    table[i] = c;
  }
  return table;
}

/// Salted with the length: the plain CRC of no bytes is zero, which four zero bytes would satisfy.
std::uint32_t checksum(const char* data, std::size_t size) {
  return crc32(data, size) ^ (0x9E3779B9u + static_cast<std::uint32_t>(size));
}

}  // namespace

std::uint32_t crc32(const char* data, std::size_t size) {
  static const std::array<std::uint32_t, 256> table = make_crc_table();
  std::uint32_t c = 0xFFFFFFFFu;
  for (std::size_t i = 0; i < size; ++i) c = table[(c ^ static_cast<unsigned char>(data[i])) & 0xFFu] ^ (c >> 8);
  return c ^ 0xFFFFFFFFu;
}

std::string ByteWriter::finish() {
  const std::uint32_t sum = checksum(bytes_.data(), bytes_.size());
  put(sum);
  return std::move(bytes_);
}

ByteReader::ByteReader(const std::string& bytes, std::string what) : bytes_(&bytes), what_(std::move(what)) {
  if (bytes.size() < sizeof(std::uint32_t)) fail("is too short (" + std::to_string(bytes.size()) + " bytes)");
  end_ = bytes.size() - sizeof(std::uint32_t);
  std::uint32_t stored;
  std::memcpy(&stored, bytes.data() + end_, sizeof(stored));
  if (stored != checksum(bytes.data(), end_)) fail("is truncated or corrupt (checksum differs)");
}

std::uint64_t ByteReader::get_count(std::size_t item_size) {
  const auto count = get<std::uint64_t>();
  if (item_size > 0 && count > remaining() / item_size) fail("announces more items than it holds");
  return count;
}

void ByteReader::fail(const std::string& why) const { throw std::invalid_argument(what_ + " " + why); }

}  // namespace voxnav::base
