// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cstring>

#include "voxnav/base/ply.hpp"

using voxnav::base::PlyWriter;

TEST(PlyWriter, HeaderComesFirstAndRowsFollowInTheOrderOfTheElements) {
  PlyWriter out;
  out.comment("a triangle");
  out.element("vertex", 2, {"float x", "uchar red"});
  for (int i = 0; i < 2; ++i) {
    out.put(1.5f);
    out.put<std::uint8_t>(static_cast<std::uint8_t>(7 + i));
  }
  out.element("face", 1, {"list uchar uint vertex_indices"});
  out.put<std::uint8_t>(0);
  const std::string header =
      "ply\nformat binary_little_endian 1.0\ncomment a triangle\nelement vertex 2\nproperty float x\n"
      "property uchar red\nelement face 1\nproperty list uchar uint vertex_indices\nend_header\n";
  const std::string bytes = out.finish();
  ASSERT_EQ(bytes.substr(0, header.size()), header);
  ASSERT_EQ(bytes.size(), header.size() + std::size_t{2} * 5 + 1);
  float x = 0.f;
  std::memcpy(&x, bytes.data() + header.size() + 5, sizeof(x));
  EXPECT_EQ(x, 1.5f);
  EXPECT_EQ(bytes[header.size() + 9], 8);
  EXPECT_EQ(out.finish(), "ply\nformat binary_little_endian 1.0\nend_header\n");
}

TEST(PlyWriter, AFileThatCannotBeWrittenIsNamed) {
  PlyWriter out;
  try {
    out.save("/nonexistent/cloud.ply");
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_STREQ(error.what(), "/nonexistent/cloud.ply: cannot be written");
  }
}
