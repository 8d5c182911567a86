// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cstring>
#include <map>

#include "content_builder.hpp"
#include "voxnav/submap/mesh.hpp"

using namespace voxnav;  // NOLINT: test
using geometry::Pose;
using geometry::Vec3;
using submap::Mesh;
using submap::Submap;

namespace {

constexpr double kVoxel = 0.4;
const Vec3 kCenter(0.13, 0.07, -0.05);

std::shared_ptr<Submap> sphere_submap() {
  const auto sphere = [](const Vec3& p) { return (p - kCenter).norm() - 3.0; };
  return Submap::from_content(test::content_from_sdf(sphere, {-14, -14, -14}, {14, 14, 14}, kVoxel), Pose::Identity(),
                              {});
}

Vec3 vertex(const Mesh& mesh, std::uint32_t i) { return mesh.vertices[i].cast<double>(); }

}  // namespace

TEST(Mesh, OfASphereIsClosedAndOriented) {
  const Mesh mesh = submap::extract_mesh(*sphere_submap());
  ASSERT_GT(mesh.triangles.size(), 500u);
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  double volume = 0.0;
  for (const auto& t : mesh.triangles) {
    for (int i = 0; i < 3; ++i) ++edges[{t[i], t[(i + 1) % 3]}];
    volume +=
        (vertex(mesh, t[0]) - kCenter).dot((vertex(mesh, t[1]) - kCenter).cross(vertex(mesh, t[2]) - kCenter)) / 6.0;
  }
  for (const auto& [edge, count] : edges) {
    ASSERT_EQ(count, 1);
    ASSERT_EQ(edges.count({edge.second, edge.first}), 1u) << "open edge";
  }
  EXPECT_NEAR(volume, 4.0 / 3.0 * M_PI * 27.0, 0.1 * 113.0);
}

TEST(Mesh, VerticesLieOnTheSurface) {
  const Mesh mesh = submap::extract_mesh(*sphere_submap());
  double sum = 0.0;
  for (const auto& p : mesh.vertices) sum += std::abs((p.cast<double>() - kCenter).norm() - 3.0);
  EXPECT_LT(sum / static_cast<double>(mesh.vertices.size()), 0.15 * kVoxel);
}

TEST(Mesh, NothingFloatsWhereSpaceIsUnobserved) {
  const auto content = test::random_content(5, 40, 0.01, 0.4, kVoxel);
  const auto field = Submap::from_content(content, Pose::Identity(), {});
  const Mesh mesh = submap::extract_mesh(*field);
  ASSERT_FALSE(mesh.triangles.empty());
  const auto points = field->occupied_points();
  for (const auto& p : mesh.vertices) {
    float nearest = 1e9f;
    for (const auto& q : points) nearest = std::min(nearest, (p - q).norm());
    ASSERT_LT(nearest, 2.0 * std::sqrt(3.0) * kVoxel);
  }
}

TEST(Mesh, FreeSpaceAloneHasNone) {
  test::ContentBuilder builder(kVoxel);
  for (int i = 0; i < 1000; ++i) builder.set_free({i % 10, i / 10 % 10, i / 100});
  EXPECT_TRUE(submap::extract_mesh(*Submap::from_content(builder.build(), Pose::Identity(), {})).triangles.empty());
}

TEST(Mesh, SizeIsBounded) { EXPECT_LT(submap::extract_mesh(*sphere_submap(), 50).triangles.size(), 60u); }

TEST(Mesh, PlyHoldsWhatItAnnounces) {
  Mesh mesh;
  mesh.append(submap::extract_mesh(*sphere_submap()), geometry::from_position_yaw({1, 2, 3}, 1.0), {1, 2, 3});
  const std::string ply = submap::to_ply(mesh);
  const std::size_t header = ply.find("end_header\n") + std::strlen("end_header\n");
  EXPECT_EQ(ply.size() - header, mesh.vertices.size() * 15 + mesh.triangles.size() * 13);
  EXPECT_NE(submap::color_of(1), submap::color_of(2));
}
