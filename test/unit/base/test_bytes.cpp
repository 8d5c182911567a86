// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "voxnav/base/bytes.hpp"

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

TEST(Bytes, ChecksumMatchesThePublishedCheckValue) { EXPECT_EQ(voxnav::base::crc32("123456789", 9), 0xCBF43926u); }
