// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <vector>

#include "voxnav/geometry/points_view.hpp"

using namespace voxnav::geometry;  // NOLINT: test

TEST(PointsView, ReadsPointsOfAnyLayoutInPlace) {
  const std::vector<float> rows{1, 2, 3, 90, 4, 5, 6, 91};
  const PointsView view(rows.data(), 2, 4);
  ASSERT_EQ(view.size(), 2u);
  EXPECT_EQ(Vec3f(view[0]), Vec3f(1, 2, 3));
  EXPECT_EQ(Vec3f(view[1]), Vec3f(4, 5, 6));
  EXPECT_EQ(Vec3f(view.part(1, 1)[0]), Vec3f(4, 5, 6));
}

TEST(PointsView, TransformsPointsInPlace) {
  std::vector<float> rows{1, 2, 3};
  view_of_rows(&rows)[0] += Vec3f(10, 0, 0);
  EXPECT_EQ(rows, (std::vector<float>{11, 2, 3}));
}

TEST(PointsView, OfAnEmptyListIsEmpty) {
  EXPECT_TRUE(PointsView().empty());
  EXPECT_TRUE(view_of(std::vector<Vec3f>{}).empty());
  EXPECT_TRUE(view_of_rows(std::vector<float>{}).empty());
  EXPECT_TRUE(PointsView().part(0, 0).empty());
}

TEST(PointsView, APointWithoutRoomForItsCoordinatesIsRefused) {
  const std::vector<float> rows{1, 2};
  EXPECT_THROW(PointsView(rows.data(), 1, 2), std::invalid_argument);
}
