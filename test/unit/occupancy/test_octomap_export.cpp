// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <octomap/octomap.h>

#include <cstdio>
#include <memory>
#include <sstream>

#include "scan_maker.hpp"
#include "voxnav/occupancy/octomap_export.hpp"

using namespace voxnav;  // NOLINT: test
using containers::VoxelState;
using geometry::Vec3;

namespace {

occupancy::LocalMap some_map() {
  occupancy::LocalMapConfig config;
  config.window_size_m = {30, 30, 20};
  occupancy::LocalMap map(config);
  const Vec3 origin(0.2, 0.2, 1.0);
  for (int i = 0; i < 4; ++i) test::insert_from(&map, origin, test::random_points(7, 400, origin, 9.0));
  return map;
}

VoxelState state_in(const octomap::OcTree& tree, const Vec3& p) {
  const octomap::OcTreeNode* node = tree.search(p.x(), p.y(), p.z());
  if (node == nullptr) return VoxelState::kUnknown;
  return node->getLogOdds() > 0.0f ? VoxelState::kOccupied : VoxelState::kFree;
}

void expect_same(const octomap::OcTree& tree, const occupancy::LocalMap& map) {
  for (double x = -10.0; x < 10.0; x += 0.4) {
    for (double y = -10.0; y < 10.0; y += 0.4) {
      for (double z = -3.2; z < 5.0; z += 0.4) {
        const Vec3 p(x + 0.2, y + 0.2, z + 0.2);
        ASSERT_EQ(state_in(tree, p), map.state(p)) << p.transpose();
      }
    }
  }
}

}  // namespace

TEST(OctomapExport, FilesReadBackWithOctomap) {
  const occupancy::LocalMap map = some_map();
  const std::string base = testing::TempDir() + "voxnav_octomap_export";
  occupancy::save_octomap(map, base + ".ot");
  occupancy::save_octomap(map, base + ".bt");
  std::unique_ptr<octomap::AbstractOcTree> read(octomap::AbstractOcTree::read(base + ".ot"));
  auto* full = dynamic_cast<octomap::OcTree*>(read.get());
  ASSERT_NE(full, nullptr);
  expect_same(*full, map);
  octomap::OcTree binary(0.4);
  ASSERT_TRUE(binary.readBinary(base + ".bt"));
  expect_same(binary, map);
  std::remove((base + ".ot").c_str());
  std::remove((base + ".bt").c_str());
}

TEST(OctomapExport, MessageDataIsReadable) {
  const occupancy::LocalMap map = some_map();
  for (const bool binary : {false, true}) {
    const auto data = occupancy::octomap_message_data(map, binary);
    std::stringstream stream(std::string(data.begin(), data.end()));
    octomap::OcTree tree(0.4);
    binary ? tree.readBinaryData(stream) : tree.readData(stream);
    expect_same(tree, map);
  }
}

TEST(OctomapExport, OtherEndingsAreRefused) {
  EXPECT_THROW(occupancy::save_octomap(some_map(), "/tmp/map.txt"), std::invalid_argument);
  EXPECT_THROW(occupancy::save_octomap(some_map(), "/nonexistent/map.ot"), std::runtime_error);
}

TEST(OctomapExport, ImportRestoresTheExportedStates) {
  const occupancy::LocalMap map = some_map();
  const std::string base = testing::TempDir() + "voxnav_octomap_import";
  for (const char* ending : {".ot", ".bt"}) {
    occupancy::save_octomap(map, base + ending);
    const occupancy::LocalMap read = occupancy::load_octomap(base + ending, map.config(), Vec3(0.2, 0.2, 1.0));
    EXPECT_EQ(read.snapshot().block_indices, map.snapshot().block_indices) << ending;
    EXPECT_EQ(read.snapshot().states, map.snapshot().states) << ending;
    std::remove((base + ending).c_str());
  }
  EXPECT_THROW(occupancy::load_octomap("/nonexistent/map.bt", map.config(), Vec3::Zero()), std::runtime_error);
}

TEST(OctomapExport, ImportKeepsToTheWindow) {
  octomap::OcTree tree(0.2);
  tree.setNodeValue(octomap::point3d(0.1F, 0.1F, 0.1F), 3.0F);
  tree.setNodeValue(octomap::point3d(90.1F, 0.1F, 0.1F), 3.0F);
  const std::string path = testing::TempDir() + "voxnav_octomap_window.ot";
  ASSERT_TRUE(tree.write(path));
  const occupancy::LocalMap read = occupancy::load_octomap(path, {}, Vec3::Zero());
  std::remove(path.c_str());
  EXPECT_EQ(read.config().resolution_m, 0.2);
  EXPECT_EQ(read.centers_above(0.8).size(), 3u);
  EXPECT_EQ(read.state(Vec3(0.1, 0.1, 0.1)), VoxelState::kOccupied);
}
