// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <octomap/octomap.h>

#include <cstdio>
#include <memory>
#include <sstream>

#include "scan_maker.hpp"
#include "steps.hpp"
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

/// A map of whole blocks and half blocks that are free or occupied, which OctoMap makes one leaf each, and larger ones.
occupancy::LocalMap blocks_of_one_state() {
  occupancy::LocalMapConfig config;
  config.window_size_m = {70, 70, 40};
  occupancy::LocalMap map(config);
  map.place_window(Vec3::Zero());
  std::vector<occupancy::LocalMap::VoxelLogOdds> voxels;
  for (int x = -32; x < 32; ++x) {
    for (int y = -32; y < 40; ++y) {
      for (int z = -32; z < 16; ++z) voxels.push_back({geometry::center_of({x, y, z}, 0.4), y < 24 ? -2.0 : 2.0});
    }
  }
  map.assign(voxels);
  return map;
}

std::string text(const std::vector<std::int8_t>& bytes) { return {bytes.begin(), bytes.end()}; }

VoxelState state_in(const octomap::OcTree& tree, const Vec3& p) {
  const octomap::OcTreeNode* node = tree.search(p.x(), p.y(), p.z());
  if (node == nullptr) return VoxelState::kUnknown;
  return node->getLogOdds() > 0.0f ? VoxelState::kOccupied : VoxelState::kFree;
}

void expect_same(const octomap::OcTree& tree, const occupancy::LocalMap& map) {
  for (const double x : test::steps(-10.0, 10.0, 0.4)) {
    for (const double y : test::steps(-10.0, 10.0, 0.4)) {
      for (const double z : test::steps(-3.2, 5.0, 0.4)) {
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

TEST(OctomapExport, MessageDataIsThatOfAPrunedOctreeByteForByte) {
  for (const occupancy::LocalMap& map : {some_map(), blocks_of_one_state()}) {
    octomap::OcTree full(0.4), binary(0.4);
    full.setClampingThresMin(map.config().prob_clamp_min);
    full.setClampingThresMax(map.config().prob_clamp_max);
    std::size_t num_known = 0;
    map.for_known([&](const occupancy::LocalMap::KnownVoxel& voxel) {
      const Vec3 p = geometry::center_of(voxel.index, 0.4);
      full.setNodeValue(p.x(), p.y(), p.z(), static_cast<float>(voxel.log_odds), true);
      binary.setNodeValue(p.x(), p.y(), p.z(), voxel.state == VoxelState::kOccupied ? 2.0F : -2.0F, true);
      ++num_known;
    });
    ASSERT_GT(num_known, 1000u);
    std::stringstream full_bytes, binary_bytes;
    full.updateInnerOccupancy();
    full.prune();
    full.writeData(full_bytes);
    binary.updateInnerOccupancy();
    binary.prune();
    binary.writeBinaryData(binary_bytes);
    EXPECT_EQ(text(occupancy::octomap_message_data(map, false)), full_bytes.str());
    EXPECT_EQ(text(occupancy::octomap_message_data(map, true)), binary_bytes.str());
  }
}

TEST(OctomapExport, AnEmptyMapHasNoNodes) {
  const occupancy::LocalMap map{occupancy::LocalMapConfig{}};
  EXPECT_TRUE(occupancy::octomap_message_data(map, false).empty());
  EXPECT_TRUE(occupancy::octomap_message_data(map, true).empty());
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
