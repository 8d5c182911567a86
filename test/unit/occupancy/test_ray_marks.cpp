// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <random>
#include <set>

#include "instruction_sets.hpp"
#include "occupancy/ray_marks.hpp"
#include "scan_maker.hpp"

using namespace voxnav;  // NOLINT: test
using geometry::Index3;
using geometry::Vec3;
using occupancy::RayMarks;
using occupancy::ScanBox;

namespace {

const std::array<int, 3> kWindow{9, 7, 5};

void cast(RayMarks* marks, const ScanBox& box, const std::vector<geometry::Vec3f>& ends, const Vec3& origin) {
  marks->begin(box, ends, origin);
  for (int face = 0; face < RayMarks::kFaces; ++face) marks->cast(face);
}

std::set<Index3> marked(const ScanBox& box, const RayMarks& marks) {
  std::set<Index3> out;
  for (std::uint32_t block = 0; block < box.num_blocks(); ++block) {
    occupancy::VoxelBits bits{};
    if (marks.is_crossed(block)) marks.add_to(block, &bits);
    bool any = false;
    for (int i = 0; i < geometry::kBlockVolume; ++i) {
      if (((bits[static_cast<std::size_t>(i >> 6)] >> (i & 63)) & 1u) == 0) continue;
      out.insert(box.first_voxel(block) + geometry::voxel_at({0, 0, 0}, i));
      any = true;
    }
    EXPECT_EQ(any, marks.is_crossed(block));
  }
  return out;
}

/// Returns the length of the segment's part inside a voxel that is enlarged by `grow` on each side.
double length_inside(const Vec3& a, const Vec3& b, const Index3& voxel, double grow) {
  double begin = 0.0, end = 1.0;
  const Vec3 way = b - a;
  const Vec3 low = Vec3(voxel.x, voxel.y, voxel.z) - Vec3::Constant(grow);
  const Vec3 high = low + Vec3::Constant(1.0 + 2.0 * grow);
  for (int axis = 0; axis < 3; ++axis) {
    if (way[axis] == 0.0) {
      if (a[axis] < low[axis] || a[axis] > high[axis]) return 0.0;
      continue;
    }
    const double t0 = (low[axis] - a[axis]) / way[axis], t1 = (high[axis] - a[axis]) / way[axis];
    begin = std::max(begin, std::min(t0, t1));
    end = std::min(end, std::max(t0, t1));
  }
  return end > begin ? (end - begin) * way.norm() + 1e-9 : 0.0;  // a segment of length 0 counts as inside too
}

/// Expects that every voxel that the segment crosses is marked, and no voxel that it does not even touch.
void expect_segment(const std::set<Index3>& voxels, const Vec3& a, const Vec3& b) {
  constexpr double kTouch = 1e-3;
  for (const Index3& v : voxels) EXPECT_GT(length_inside(a, b, v, kTouch), 0.0) << v.x << " " << v.y << " " << v.z;
  const Index3 last = geometry::index_of(Vec3(kWindow[0], kWindow[1], kWindow[2]) * 16.0, 1.0);
  Index3 v;
  for (v.z = 0; v.z < last.z; ++v.z) {
    for (v.y = 0; v.y < last.y; ++v.y) {
      for (v.x = 0; v.x < last.x; ++v.x) {
        if (length_inside(a, b, v, -kTouch) > 4.0 * kTouch) {
          EXPECT_EQ(voxels.count(v), 1u);
        }
      }
    }
  }
}

Vec3 random_point(std::mt19937* rng) {
  Vec3 out;
  for (int axis = 0; axis < 3; ++axis) {
    out[axis] = std::uniform_real_distribution<double>(1.0, 16.0 * kWindow[static_cast<std::size_t>(axis)] - 1.0)(*rng);
  }
  return out.cast<float>().cast<double>();
}

}  // namespace

TEST(RayMarks, MarksWhatASegmentCrosses) {
  test::with_every_instruction_set([] {
    const ScanBox box(kWindow, {0, 0, 0}, {kWindow[0] - 1, kWindow[1] - 1, kWindow[2] - 1});
    std::mt19937 rng(3);
    RayMarks marks;
    for (int trial = 0; trial < 12; ++trial) {
      const Vec3 origin = random_point(&rng);
      Vec3 end = random_point(&rng);
      if (trial % 4 == 1) end[trial % 3] = origin[trial % 3];  // perpendicular to an axis
      if (trial % 4 == 2) end = origin + Vec3::Unit(trial % 3) * (end - origin)[trial % 3];
      if (trial == 11) end = origin;
      cast(&marks, box, {end.cast<float>()}, origin);
      expect_segment(marked(box, marks), origin, end);
    }
  });
}

TEST(RayMarks, ManyRaysMarkTheUnionOfTheirVoxels) {
  test::with_every_instruction_set([] {
    const ScanBox box(kWindow, {1, 0, 1}, {kWindow[0] - 1, kWindow[1] - 1, kWindow[2] - 2});
    std::mt19937 rng(4);
    const Vec3 origin(50.0, 40.0, 30.0);
    std::vector<geometry::Vec3f> ends;
    while (ends.size() < 37) {  // not a multiple of the number of rays that are walked at once
      const Vec3 end = random_point(&rng);
      if (end.x() >= 17.0 && end.z() >= 17.0 && end.z() < 16.0 * (kWindow[2] - 1) - 1.0)
        ends.emplace_back(end.cast<float>());
    }
    RayMarks all, one;
    cast(&all, box, ends, origin);
    std::set<Index3> expected;
    for (const geometry::Vec3f& end : ends) {
      cast(&one, box, {end}, origin);
      for (const Index3& voxel : marked(box, one)) expected.insert(voxel);
    }
    EXPECT_EQ(marked(box, all), expected);
  });
}

TEST(Processor, EveryInstructionSetGivesTheSameMap) {
  std::vector<std::string> maps;
  test::with_every_instruction_set([&] {
    occupancy::LocalMapConfig config;
    config.window_size_m = {26, 26, 14};
    config.max_range_m = 12.0;
    occupancy::LocalMap map(config);
    for (unsigned i = 0; i < 8; ++i) {
      test::insert_from(&map, Vec3(0.7 * i, 0.2, 0.1), test::random_points(i % 3, 3000, Vec3(0, 0, 0), 14.0));
    }
    maps.push_back(map.to_bytes());
  });
  for (const std::string& map : maps) EXPECT_EQ(map, maps[0]);
}
