// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <random>

#include "raw_cloud.hpp"
#include "voxnav/cloud/cloud_filter.hpp"
#include "voxnav/cloud/cloud_layout.hpp"

namespace {

using namespace voxnav;  // NOLINT: test
using cloud::CloudLayout;
using cloud::FieldType;
using test::RawCloud;

std::string problem_of(const RawCloud& c) { return c.layout.problem(c.bytes.size()); }

TEST(CloudLayout, AcceptsTheLayoutsOfDrivers) {
  EXPECT_EQ(problem_of(RawCloud(16, 32, 16, test::xyzi_fields())), "");
  EXPECT_EQ(problem_of(RawCloud(16, 32, 29, test::gazebo_fields())), "");
  EXPECT_EQ(problem_of(RawCloud(16, 32, 48, test::ouster_fields())), "");
}

TEST(CloudLayout, AcceptsEmptyCloudsWithOrWithoutFields) {
  EXPECT_EQ(problem_of(RawCloud(1, 0, 16, test::xyzi_fields())), "");
  EXPECT_EQ(CloudLayout().problem(0), "");
  EXPECT_NO_THROW(cloud::RawCloudView(CloudLayout(), nullptr, 0));
}

TEST(CloudLayout, NamesWhatIsMissing) {
  RawCloud c(1, 2, 16, test::xyzi_fields());
  c.layout.fields.erase(c.layout.fields.begin() + 2);
  EXPECT_EQ(problem_of(c), "field 'z' is missing (the cloud has: x, y, intensity)");
}

TEST(CloudLayout, NamesAWrongType) {
  RawCloud c(1, 2, 16, test::xyzi_fields());
  c.layout.fields[1].type = FieldType::kInt16;
  EXPECT_EQ(problem_of(c), "field 'y' is int16, must be float32 or float64");
  c.layout.fields[1].type = static_cast<FieldType>(11);
  EXPECT_EQ(problem_of(c), "field 'y' has unknown datatype 11");
}

TEST(CloudLayout, RefusesSizesThatDoNotFit) {
  RawCloud c(4, 8, 16, test::xyzi_fields());
  EXPECT_EQ(c.layout.problem(511), "data has 511 bytes, 4 x 8 points of 16 bytes need 512");
  c.layout.row_step = 100;
  EXPECT_NE(problem_of(c).find("row_step 100 is shorter"), std::string::npos);
  c.layout.row_step = 1 << 30;
  EXPECT_NE(problem_of(c).find("data has 512 bytes"), std::string::npos);
  c.layout.row_step = 0;
  c.layout.point_step = 12;
  EXPECT_NE(problem_of(c).find("'intensity' ends at byte 16"), std::string::npos);
  c.layout.point_step = 0;
  EXPECT_EQ(problem_of(c), "point_step is 0");
}

TEST(CloudLayout, RefusesProductsThatOverflow32Bits) {
  RawCloud c(1, 1, 16, test::xyzi_fields());
  c.layout.width = 1u << 28;  // times 16 bytes this is 2^32
  EXPECT_NE(problem_of(c), "");
  c.layout.width = 0x10000;
  c.layout.height = 0x10000;
  EXPECT_NE(problem_of(c), "");
  c.layout.width = 2;
  c.layout.height = 1;
  c.layout.fields[3].offset = 0xFFFFFFFCu;
  EXPECT_NE(problem_of(c), "");
}

TEST(CloudLayout, ReadsPaddedRowsAndEveryNumberType) {
  RawCloud c(2, 1, 13,
             {{"x", 1, FieldType::kFloat32, 1}, {"y", 5, FieldType::kFloat32, 1}, {"z", 9, FieldType::kFloat32, 0}});
  c.layout.row_step = 20;
  c.bytes.assign(40, 0xEE);
  const float xyz[3] = {1.5F, -2.0F, 3.0F};
  std::memcpy(c.bytes.data() + 21, xyz, 12);
  EXPECT_EQ(cloud::read_number(c.view().row(1), c.view().access().y), -2.0);
  const std::int16_t value = -300;
  EXPECT_EQ(cloud::read_number(reinterpret_cast<const std::uint8_t*>(&value), {0, FieldType::kInt16}), -300.0);
  const double wide = 1e300;
  EXPECT_EQ(cloud::read_number(reinterpret_cast<const std::uint8_t*>(&wide), {0, FieldType::kFloat64}), 1e300);
}

std::uint32_t random_size(std::mt19937* random) {
  const std::uint32_t sizes[] = {0, 1, 2, 3, 4, 7, 8, 12, 16, 29, 48, 100, 0x7FFFFFFFu, 0xFFFFFFFFu};
  return sizes[(*random)() % std::size(sizes)];
}

CloudLayout random_layout(std::mt19937* random) {
  CloudLayout layout;
  layout.height = random_size(random);
  layout.width = random_size(random);
  layout.point_step = random_size(random);
  layout.row_step = random_size(random);
  const char* names[] = {"x", "y", "z", "intensity", "t", "time", "ring"};
  for (const char* name : names) {
    if ((*random)() % 16 == 0) continue;
    layout.fields.push_back({name, random_size(random) % 64,
                             static_cast<FieldType>((*random)() % 3 == 0 ? (*random)() % 10 : 7),
                             (*random)() % 4 == 0 ? random_size(random) : 1});
  }
  return layout;
}

// Under the sanitizers this test finds any read beyond the data; without them it checks that every point is counted.
TEST(CloudLayout, FuzzedLayoutsAreRefusedOrReadInside) {
  std::mt19937 random(7);
  int accepted = 0;
  for (int i = 0; i < 20000; ++i) {
    const CloudLayout layout = random_layout(&random);
    std::vector<std::uint8_t> bytes(random() % 4000);
    for (std::uint8_t& b : bytes) b = static_cast<std::uint8_t>(random());
    if (!layout.problem(bytes.size()).empty()) {
      EXPECT_THROW(cloud::RawCloudView(layout, bytes.data(), bytes.size()), std::invalid_argument);
      continue;
    }
    ++accepted;
    cloud::CloudFilter filter{cloud::CloudFilterConfig()};
    const auto counts = filter.apply(cloud::RawCloudView(layout, bytes.data(), bytes.size())).counts;
    std::uint64_t sum = 0;
    for (const auto& reason : counts.reasons()) sum += reason.second;
    EXPECT_EQ(sum, layout.num_points());
  }
  EXPECT_GT(accepted, 100);
}

}  // namespace
