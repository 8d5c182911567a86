// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "base/bytes.hpp"

using voxnav::base::ByteReader;
using voxnav::base::ByteWriter;

TEST(Bytes, RoundTrip) {
  ByteWriter writer;
  writer.put<std::uint16_t>(7);
  writer.put(2.5);
  const std::string bytes = writer.finish();
  ByteReader reader(bytes, "sample");
  EXPECT_EQ(reader.get<std::uint16_t>(), 7);
  EXPECT_EQ(reader.get<double>(), 2.5);
  EXPECT_EQ(reader.remaining(), 0u);
  EXPECT_THROW(reader.get<char>(), std::invalid_argument);
}

TEST(Bytes, EveryTruncationAndEveryFlippedByteIsRefused) {
  ByteWriter writer;
  for (int i = 0; i < 50; ++i) writer.put(i);
  const std::string good = writer.finish();
  for (std::size_t size = 0; size < good.size(); ++size) {
    EXPECT_THROW(ByteReader(good.substr(0, size), "sample"), std::invalid_argument) << size;
    std::string bad = good;
    bad[size] = static_cast<char>(bad[size] ^ 0x10);
    EXPECT_THROW(ByteReader(bad, "sample"), std::invalid_argument) << size;
  }
}

TEST(Bytes, ImplausibleCountIsRefused) {
  ByteWriter writer;
  writer.put<std::uint64_t>(1ull << 60);
  const std::string bytes = writer.finish();
  ByteReader reader(bytes, "sample");
  EXPECT_THROW(reader.get_count(8), std::invalid_argument);
}

/// Computes the checksum bit by bit, as CRC-32 is defined.
std::uint32_t plain_crc32(const std::string& bytes) {
  std::uint32_t c = 0xFFFFFFFFu;
  for (const char byte : bytes) {
    c ^= static_cast<unsigned char>(byte);
    for (int bit = 0; bit < 8; ++bit) c = (c & 1u) != 0 ? 0xEDB88320u ^ (c >> 1) : c >> 1;
  }
  return c ^ 0xFFFFFFFFu;
}

TEST(Bytes, ChecksumOfEveryLengthFollowsItsDefinition) {
  std::string bytes;
  for (int size = 0; size < 70; ++size) {
    EXPECT_EQ(voxnav::base::crc32(bytes.data(), bytes.size()), plain_crc32(bytes)) << size;
    bytes.push_back(static_cast<char>(size * 37 + 200));
  }
}

TEST(Bytes, ChecksumMatchesThePublishedCheckValue) { EXPECT_EQ(voxnav::base::crc32("123456789", 9), 0xCBF43926u); }

TEST(Bytes, AHeaderSaysWhatTheBytesHoldAndInWhichVersion) {
  constexpr voxnav::base::Format kSample{0x11223344, 1, "a sample"};
  const auto refusal = [&](std::uint32_t magic, std::uint32_t version) -> std::string {
    ByteWriter writer;
    writer.put_header({magic, version, ""});
    const std::string bytes = writer.finish();
    ByteReader reader(bytes, "file.x");
    try {
      reader.check_header(kSample);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    EXPECT_EQ(reader.remaining(), 0u);
    return "";
  };
  EXPECT_EQ(refusal(kSample.magic, 1), "");
  EXPECT_EQ(refusal(1, 1), "file.x is not a sample");
  EXPECT_EQ(refusal(kSample.magic, 0), "file.x has version 0 of its format; this program reads version 1 only");
  EXPECT_EQ(refusal(kSample.magic, 7), "file.x has version 7 of its format; this program reads version 1 only");
}
