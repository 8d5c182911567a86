// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <array>
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

TEST(Mesh, UnobservedSpaceHasNoTriangles) {
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

TEST(Mesh, FreeSpaceAloneHasNoTriangles) {
  test::ContentBuilder builder(kVoxel);
  for (int i = 0; i < 1000; ++i) builder.set_free({i % 10, i / 10 % 10, i / 100});
  EXPECT_TRUE(submap::extract_mesh(*Submap::from_content(builder.build(), Pose::Identity(), {})).triangles.empty());
}

TEST(Mesh, SizeIsBounded) { EXPECT_LT(submap::extract_mesh(*sphere_submap(), 50).triangles.size(), 60u); }

TEST(Mesh, PlyHoldsWhatItAnnounces) {
  Mesh mesh = submap::extract_mesh(*sphere_submap());
  for (const auto& p : mesh.vertices) mesh.colors.push_back(submap::color_of_height(p.z()));
  const std::string ply = submap::to_ply(mesh);
  const std::size_t header = ply.find("end_header\n") + std::strlen("end_header\n");
  EXPECT_EQ(ply.size() - header, mesh.vertices.size() * 15 + mesh.triangles.size() * 13);
  EXPECT_NE(submap::color_of(1), submap::color_of(2));
}

TEST(Mesh, HeightsHaveTheRainbowOfRviz) {
  const submap::HeightScale scale{-4.0, 6.0};
  EXPECT_EQ(submap::color_of_height(-4.0, scale), (submap::Color{255, 0, 0}));
  EXPECT_EQ(submap::color_of_height(-2.0, scale), (submap::Color{255, 255, 0}));
  EXPECT_EQ(submap::color_of_height(0.0, scale), (submap::Color{0, 255, 0}));
  EXPECT_EQ(submap::color_of_height(2.0, scale), (submap::Color{0, 255, 255}));
  EXPECT_EQ(submap::color_of_height(4.0, scale), (submap::Color{0, 0, 255}));
  EXPECT_EQ(submap::color_of_height(6.0, scale), (submap::Color{255, 0, 255}));
  EXPECT_EQ(submap::color_of_height(3.0, scale), (submap::Color{0, 128, 255}));
}

TEST(Mesh, HeightsBeyondTheScaleHaveTheColourOfItsEnd) {
  EXPECT_EQ(submap::color_of_height(-100.0), submap::color_of_height(-4.0));
  EXPECT_EQ(submap::color_of_height(100.0), submap::color_of_height(12.0));
  EXPECT_NE(submap::color_of_height(-4.0), submap::color_of_height(12.0));
}

namespace {

submap::SubmapEntry entry_of(std::uint32_t id, std::shared_ptr<const Submap> submap, const Pose& T_W_S) {
  submap::SubmapEntry entry;
  entry.id = id;
  entry.end_ns = id;
  entry.T_W_S = T_W_S;
  entry.submap = std::move(submap);
  return entry;
}

using Corner = std::array<int, 3>;

/// Counts the edges of a mesh in which vertices of different pieces at the same place are one.
std::map<std::pair<Corner, Corner>, int> welded_edges(const Mesh& mesh) {
  const auto corner = [&](std::uint32_t i) {
    const auto& p = mesh.vertices[i];
    return Corner{static_cast<int>(std::lround(p.x() * 1e3)), static_cast<int>(std::lround(p.y() * 1e3)),
                  static_cast<int>(std::lround(p.z() * 1e3))};
  };
  std::map<std::pair<Corner, Corner>, int> edges;
  for (const auto& t : mesh.triangles) {
    for (int i = 0; i < 3; ++i) ++edges[{corner(t[i]), corner(t[(i + 1) % 3])}];
  }
  return edges;
}

}  // namespace

TEST(MergedMesh, BlocksDrawnOneByOneMeetWithoutGaps) {
  submap::SubmapCollection collection({});
  collection.add(entry_of(1, sphere_submap(), Pose::Identity()));
  collection.update();
  Mesh mesh;
  for (const auto& item : collection.evidence().blocks())
    mesh.append(submap::extract_mesh(collection.evidence(), {item.first}));
  EXPECT_EQ(mesh.triangles.size(), submap::extract_mesh(*sphere_submap()).triangles.size());
  EXPECT_EQ(mesh.colors.size(), mesh.vertices.size());
  int open = 0;
  const auto edges = welded_edges(mesh);
  for (const auto& item : edges) open += edges.count({item.first.second, item.first.first}) == 0;
  EXPECT_EQ(open, 0);
}

TEST(MergedMesh, HoldsSharedSurfacesOnceAndRemovedSurfacesNever) {
  submap::SubmapCollection collection({});
  collection.add(entry_of(1, sphere_submap(), Pose::Identity()));
  const std::size_t once = submap::extract_mesh(&collection).triangles.size();
  collection.add(entry_of(2, sphere_submap(), Pose::Identity()));
  EXPECT_EQ(submap::extract_mesh(&collection).triangles.size(), once);
  test::ContentBuilder empty(kVoxel);
  for (int i = 0; i < 28 * 28 * 28; ++i) empty.set_free({i % 28 - 14, i / 28 % 28 - 14, i / 784 - 14});
  collection.add(entry_of(3, Submap::from_content(empty.build(), Pose::Identity(), {}), Pose::Identity()));
  EXPECT_TRUE(submap::extract_mesh(&collection).triangles.empty());
}

/// The mesh shows trunks, even those of one voxel's width, so that crowns do not float.
TEST(MergedMesh, HoldsEverySurfaceBesideObservedSpace) {
  const auto tree = [](const Vec3& p) {
    const double trunk = std::max(std::hypot(p.x() - 0.11, p.y() + 0.07) - 0.15, p.z() - 4.0);
    const double pole = std::hypot(p.x() - 3.07, p.y() - 1.93) - 0.04;
    return std::min({p.z() - 0.07, trunk, pole, (p - Vec3(0.1, 0.0, 4.6)).norm() - 1.6});
  };
  const auto field =
      Submap::from_content(test::content_from_sdf(tree, {-16, -16, -2}, {16, 16, 20}, kVoxel), Pose::Identity(), {});
  submap::SubmapCollection collection({});
  collection.add(entry_of(1, field, geometry::from_position_yaw({0.13, 0.07, 0.05}, 0.3)));
  const Mesh mesh = submap::extract_mesh(&collection);
  int thin = 0;
  for (const auto& p : collection.occupied_points()) {
    if (p.z() < 0.6f || p.head<2>().norm() > 5.f) continue;
    float nearest = 1e9f;
    for (const auto& q : mesh.vertices) nearest = std::min(nearest, (p - q).norm());
    EXPECT_LT(nearest, kVoxel) << p.transpose();
    ++thin;
  }
  EXPECT_GT(thin, 40);
}
