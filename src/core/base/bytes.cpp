// SPDX-License-Identifier: BSD-3-Clause
#include "base/bytes.hpp"

#include <array>

namespace voxnav::base {
namespace {

constexpr std::size_t kSlices = 8;
/// Table k holds what a byte does to the checksum once k more bytes have followed it.
using CrcTables = std::array<std::array<std::uint32_t, 256>, kSlices>;

CrcTables make_crc_tables() {
  CrcTables tables{};
  for (std::uint32_t i = 0; i < 256; ++i) {
    std::uint32_t c = i;
    for (int bit = 0; bit < 8; ++bit) c = (c & 1u) ? 0xEDB88320u ^ (c >> 1) : c >> 1;
    tables[0][i] = c;
  }
  for (std::size_t k = 1; k < kSlices; ++k) {
    for (std::size_t i = 0; i < 256; ++i) {
      const std::uint32_t before = tables[k - 1][i];
      tables[k][i] = tables[0][before & 0xFFu] ^ (before >> 8);
    }
  }
  return tables;
}

/// The checksum starts from the length, because the plain CRC of no bytes is zero, which a file of four zero bytes
/// would satisfy.
std::uint32_t checksum(const char* data, std::size_t size) {
  return crc32(data, size) ^ (0x9E3779B9u + static_cast<std::uint32_t>(size));
}

}  // namespace

/// The loop takes eight bytes at once. Source: Kounavis and Berry, A Systematic Approach to Building High Performance
/// Software-Based CRC Generators, ISCC 2005 (slicing-by-8).
std::uint32_t crc32(const char* data, std::size_t size) {
  static const CrcTables tables = make_crc_tables();
  const auto byte = [data](std::size_t i) { return static_cast<std::uint32_t>(static_cast<unsigned char>(data[i])); };
  std::uint32_t c = 0xFFFFFFFFu;
  std::size_t i = 0;
  for (; i + kSlices <= size; i += kSlices) {
    const std::uint32_t low = c ^ (byte(i) | byte(i + 1) << 8 | byte(i + 2) << 16 | byte(i + 3) << 24);
    c = tables[7][low & 0xFFu] ^ tables[6][(low >> 8) & 0xFFu] ^ tables[5][(low >> 16) & 0xFFu] ^ tables[4][low >> 24] ^
        tables[3][byte(i + 4)] ^ tables[2][byte(i + 5)] ^ tables[1][byte(i + 6)] ^ tables[0][byte(i + 7)];
  }
  for (; i < size; ++i) c = tables[0][(c ^ byte(i)) & 0xFFu] ^ (c >> 8);
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

void ByteReader::check_header(const Format& format) {
  if (get<std::uint32_t>() != format.magic) fail(std::string("is not ") + format.name);
  const auto version = get<std::uint32_t>();
  if (version == format.version) return;
  fail("has version " + std::to_string(version) + " of its format; this program reads version " +
       std::to_string(format.version) + " only");
}

std::uint64_t ByteReader::get_count(std::size_t item_size) {
  const auto count = get<std::uint64_t>();
  if (item_size > 0 && count > remaining() / item_size) fail("announces more items than it holds");
  return count;
}

void ByteReader::fail(const std::string& why) const { throw std::invalid_argument(what_ + " " + why); }

}  // namespace voxnav::base
