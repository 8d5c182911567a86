// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <vector>

#include "instruction_sets.hpp"
#include "kernels/free_distances.hpp"
#include "kernels/neighborhood.hpp"

using namespace voxnav;  // NOLINT: test
using kernels::kWindowBlockSide;
using kernels::kWindowHalo;
using kernels::kWindowSide;

namespace {

/// A window of random voxels around an inclined surface, with surface points inside the occupied ones.
struct RandomWindow {
  std::vector<std::uint32_t> free = std::vector<std::uint32_t>(std::size_t{kWindowSide} * kWindowSide);
  std::vector<std::uint32_t> occupied = free;
  std::vector<std::uint16_t> first = std::vector<std::uint16_t>(std::size_t{kWindowSide} * kWindowSide);
  std::vector<kernels::WindowPoint> points;
  std::vector<geometry::Index3> voxels;

  RandomWindow(unsigned seed, float clutter) {
    std::mt19937 rng(seed);
    std::uniform_real_distribution<float> share(0.0f, 1.0f), slope(-0.7f, 0.7f);
    const float slope_x = slope(rng), slope_y = slope(rng);
    for (int z = -kWindowHalo; z < kWindowBlockSide + kWindowHalo; ++z) {
      for (int y = -kWindowHalo; y < kWindowBlockSide + kWindowHalo; ++y) {
        const std::size_t row = kernels::VoxelWindow::row(y, z);
        first[row] = static_cast<std::uint16_t>(points.size());
        for (int x = -kWindowHalo; x < kWindowBlockSide + kWindowHalo; ++x) {
          const float height =
              static_cast<float>(z) - 8.0f - slope_x * static_cast<float>(x - 8) - slope_y * static_cast<float>(y - 8);
          const bool is_occupied = std::abs(height) < 0.5f || share(rng) < clutter;
          const bool is_free = !is_occupied && height > 0.0f && share(rng) > clutter;
          if (is_free) free[row] |= 1u << (x + kWindowHalo);
          if (is_occupied) add(x, y, z, share(rng) - 0.5f, row);
        }
      }
    }
  }
  kernels::VoxelWindow view() const {
    return {free.data(), occupied.data(), first.data(), points.data(), points.size()};
  }

 private:
  void add(int x, int y, int z, float off, std::size_t row) {
    occupied[row] |= 1u << (x + kWindowHalo);
    const float px = static_cast<float>(x) + off, py = static_cast<float>(y) - 0.5f * off;
    const float pz = static_cast<float>(z) + 0.9f * off;
    points.push_back({px, py, pz, 1.0f, py, pz, px, 0.0f});
    voxels.push_back({x, y, z});
  }
};

bool is_inside(const geometry::Index3& v) {
  const auto is_in = [](int c) { return c >= -1 && c <= kWindowBlockSide; };
  return is_in(v.x) && is_in(v.y) && is_in(v.z);
}

}  // namespace

TEST(FreeDistances, EqualTheReference) {
  const auto squared = std::make_unique<kernels::SquaredDistances>();
  test::with_every_instruction_set([&] {
    for (unsigned seed = 0; seed < 6; ++seed) {
      const RandomWindow window(seed, seed % 2 == 0 ? 0.0f : 0.03f);
      for (const float band : {1.5f, 3.0f, 3.5f, 4.25f, 6.0f}) {
        std::vector<std::int16_t> codes(kernels::kTableVoxels, kernels::kNoDistance), expected(codes.size());
        kernels::measure_free(window.view(), band, band / 32767.0f, squared.get(), codes.data());
        kernels::reference::measure_free(window.view(), band, band / 32767.0f, expected.data());
        ASSERT_EQ(codes, expected) << seed << " " << band;
        EXPECT_GT(codes.size() - static_cast<std::size_t>(std::count(codes.begin(), codes.end(), kernels::kNoDistance)),
                  100u);
      }
    }
  });
}

TEST(Neighborhood, SumsAndPlanesEqualTheReference) {
  test::with_every_instruction_set([] {
    int num_planes = 0, num_others = 0;
    for (unsigned seed = 0; seed < 6; ++seed) {
      const RandomWindow window(seed, 0.01f * static_cast<float>(seed));
      std::array<geometry::Index3, kernels::kTogether> asked;
      std::size_t count = 0;
      for (const auto& voxel : window.voxels) {
        if (!is_inside(voxel)) continue;
        asked[count++] = voxel;
        if (count < kernels::kTogether) continue;
        count = 0;
        kernels::NeighborhoodBatch batch;
        kernels::PlaneNormals normals;
        kernels::look_around(window.view(), asked, &batch);
        kernels::fit_planes(batch, &normals);
        for (std::size_t i = 0; i < kernels::kTogether; ++i) {
          const kernels::Neighborhood expected = kernels::reference::look_around(window.view(), asked[i]);
          ASSERT_EQ(batch[i].towards_free, expected.towards_free);
          ASSERT_EQ(batch[i].sum, expected.sum);
          for (std::size_t k = 0; k < 3; ++k) {
            ASSERT_EQ(batch[i].squares[k], expected.squares[k]);
            ASSERT_EQ(batch[i].products[k], expected.products[k]);
          }
          const std::array<float, 3> normal = kernels::reference::fit_plane(expected);
          for (std::size_t k = 0; k < 3; ++k) ASSERT_EQ(normals[k][i], normal[k]);
          ++(normal == std::array<float, 3>{} ? num_others : num_planes);
        }
      }
    }
    EXPECT_GT(num_planes, 100);
    EXPECT_GT(num_others, 100);
  });
}
