// SPDX-License-Identifier: BSD-3-Clause
// Files that OctoMap itself writes and reads, with leaves of every size and far from the origin.
#include <gtest/gtest.h>
#include <octomap/octomap.h>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <limits>
#include <memory>
#include <random>
#include <sstream>

#include "occupancy/octomap_file.hpp"
#include "voxnav/occupancy/octomap_export.hpp"

using namespace voxnav;  // NOLINT: test
using containers::VoxelState;
using geometry::Index3;
using geometry::Vec3;

namespace {

constexpr double kResolution_m = 0.2;
constexpr int kOrigin = 1 << 15;

/// A file that is removed when the test ends.
struct TemporaryFile {
  explicit TemporaryFile(const std::string& name) : path(testing::TempDir() + "voxnav_octomap_" + name) {}
  ~TemporaryFile() { std::remove(path.c_str()); }
  std::string path;
};

/// Returns a tree in which one leaf stands for all 2^48 voxels.
std::unique_ptr<octomap::OcTree> single_leaf(float log_odds) {
  auto tree = std::make_unique<octomap::OcTree>(kResolution_m);
  std::stringstream bytes;
  bytes.write(reinterpret_cast<const char*>(&log_odds), sizeof(log_odds));
  bytes.put(0);
  tree->readData(bytes);
  return tree;
}

/// Splits the tree towards a key down to the finest level. Each branch beside the path is a leaf or unknown, at random.
void split_towards(const octomap::OcTreeKey& key, std::mt19937* random, octomap::OcTree* tree) {
  octomap::OcTreeNode* node = tree->getRoot();
  for (int depth = 0; depth < 16; ++depth) {
    const unsigned child = octomap::computeChildIdx(key, 15 - depth);
    for (unsigned i = 0; i < 8; ++i) {
      if (tree->nodeChildExists(node, i) || (i != child && (*random)() % 3 == 0)) continue;
      tree->createNodeChild(node, i)->setLogOdds((*random)() % 2 ? 2.0F : -2.0F);
    }
    node = tree->getNodeChild(node, child);
  }
}

VoxelState state_in(const octomap::OcTree& tree, const Index3& voxel) {
  const int key[3] = {voxel.x + kOrigin, voxel.y + kOrigin, voxel.z + kOrigin};
  for (const int k : key) {
    if (k < 0 || k >= 2 * kOrigin) return VoxelState::kUnknown;
  }
  const octomap::OcTreeNode* node = tree.search(octomap::OcTreeKey(key[0], key[1], key[2]));
  if (node == nullptr) return VoxelState::kUnknown;
  return node->getLogOdds() > 0.0F ? VoxelState::kOccupied : VoxelState::kFree;
}

std::uint64_t voxels_in(const octomap::OcTree& tree) {
  std::uint64_t out = 0;
  for (auto leaf = tree.begin_leafs(); leaf != tree.end_leafs(); ++leaf) {
    const auto side = static_cast<std::uint64_t>(std::llround(leaf.getSize() / kResolution_m));
    out += side * side * side;
  }
  return out;
}

occupancy::LocalMapConfig small_window() {
  occupancy::LocalMapConfig config;
  config.resolution_m = kResolution_m;
  config.window_size_m = {9.0, 9.0, 9.0};
  return config;
}

/// Compares every voxel of the window, and the counts, with the tree of OctoMap.
void expect_loaded(const octomap::OcTree& tree, const std::string& path, const Vec3& center) {
  occupancy::OctomapCounts counts;
  const occupancy::LocalMap map = occupancy::load_octomap(path, small_window(), center, &counts);
  const Index3 middle = geometry::block_of(geometry::index_of(center, kResolution_m));
  const int n = map.config().window_blocks()[0];
  std::uint64_t num_known = 0;
  for (int i = 0; i < n * n * n; ++i) {
    const Index3 block = middle + Index3{i % n - n / 2, i / n % n - n / 2, i / n / n - n / 2};
    for (int offset = 0; offset < geometry::kBlockVolume; ++offset) {
      const Index3 voxel = geometry::voxel_at(block, offset);
      const VoxelState expected = state_in(tree, voxel);
      num_known += expected != VoxelState::kUnknown;
      ASSERT_EQ(map.state(geometry::center_of(voxel, kResolution_m)), expected)
          << voxel.x << " " << voxel.y << " " << voxel.z;
    }
  }
  EXPECT_EQ(counts.in_file, voxels_in(tree));
  EXPECT_EQ(counts.in_file - counts.outside_window, num_known);
  EXPECT_EQ(counts.not_finite, 0u);
}

std::unique_ptr<octomap::OcTree> read_by_octomap(const std::string& path) {
  auto tree = std::make_unique<octomap::OcTree>(kResolution_m);
  if (path.substr(path.size() - 3) == ".bt") {
    EXPECT_TRUE(tree->readBinary(path));
    return tree;
  }
  std::unique_ptr<octomap::AbstractOcTree> read(octomap::AbstractOcTree::read(path));
  EXPECT_NE(dynamic_cast<octomap::OcTree*>(read.get()), nullptr);
  return std::unique_ptr<octomap::OcTree>(static_cast<octomap::OcTree*>(read.release()));
}

std::string bytes_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// Returns why a file cannot be read; empty if it can.
std::string problem_of(const std::string& path) {
  try {
    occupancy::read_octomap(path);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

/// Returns a map with a few surfaces and free voxels around a place.
occupancy::LocalMap map_around(const Vec3& center) {
  occupancy::LocalMap map(small_window());
  map.place_window(center);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> offset(-4.0, 4.0);
  std::vector<occupancy::LocalMap::VoxelLogOdds> voxels;
  voxels.reserve(3000);
  for (int i = 0; i < 3000; ++i) {
    voxels.push_back({center + Vec3(offset(random), offset(random), offset(random)), i % 3 == 0 ? 3.0 : -1.5});
  }
  map.assign(voxels);
  return map;
}

void expect_same(const occupancy::LocalMap& a, const occupancy::LocalMap& b) {
  EXPECT_GT(a.snapshot().states.size(), 0u);
  EXPECT_EQ(a.snapshot().block_indices, b.snapshot().block_indices);
  EXPECT_EQ(a.snapshot().states, b.snapshot().states);
}

}  // namespace

TEST(OctomapFiles, LeavesOfEverySizeAreClippedToTheWindow) {
  std::mt19937 random(11);
  const TemporaryFile file("leaves.ot");
  for (int trial = 0; trial < 4; ++trial) {
    const auto tree = single_leaf(-2.0F);
    for (unsigned i = 0; i < 8; ++i) tree->createNodeChild(tree->getRoot(), i)->setLogOdds(i % 2 ? 2.0F : -2.0F);
    constexpr unsigned kKeys = 2 * kOrigin;
    const octomap::OcTreeKey near(random() % kKeys, random() % kKeys, random() % kKeys);
    split_towards(near, &random, tree.get());
    split_towards({kOrigin, kOrigin, kOrigin}, &random, tree.get());
    ASSERT_TRUE(tree->write(file.path));
    const octomap::point3d corner = tree->keyToCoord(near);
    const Vec3 at(corner.x(), corner.y(), corner.z());
    for (const Vec3& center : {at, Vec3(at + Vec3(3.0, -2.0, 1.0)), Vec3(0, 0, 0), Vec3(200, -100, 50)}) {
      expect_loaded(*tree, file.path, center);
    }
  }
}

TEST(OctomapFiles, OneLeafForEverythingFillsTheWindow) {
  const auto tree = single_leaf(-2.0F);
  const TemporaryFile file("everything.ot");
  ASSERT_TRUE(tree->write(file.path));
  EXPECT_EQ(voxels_in(*tree), std::uint64_t{1} << 48);
  expect_loaded(*tree, file.path, Vec3(1, 2, 3));
}

TEST(OctomapFiles, WindowsAcrossAndBeyondTheKeysOfTheFile) {
  const auto tree = single_leaf(2.0F);
  const TemporaryFile file("edge.bt");
  ASSERT_TRUE(tree->writeBinary(file.path));
  const double edge_m = kOrigin * kResolution_m;
  expect_loaded(*tree, file.path, Vec3(edge_m - 1.0, 0, 0));
  expect_loaded(*tree, file.path, Vec3(-edge_m, edge_m, -edge_m));
  expect_loaded(*tree, file.path, Vec3(5.0e5, 5.5e6, 300.0));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(occupancy::load_octomap(file.path, small_window(), Vec3(nan, 0, 0)), std::invalid_argument);
  EXPECT_THROW(occupancy::load_octomap(file.path, small_window(), Vec3(1e15, 0, 0)), std::invalid_argument);
}

TEST(OctomapFiles, EmptyTreesAndBrokenLogOdds) {
  const TemporaryFile file("odd.ot");
  octomap::OcTree empty(kResolution_m);
  ASSERT_TRUE(empty.write(file.path));
  expect_loaded(empty, file.path, Vec3::Zero());
  ASSERT_TRUE(single_leaf(std::numeric_limits<float>::quiet_NaN())->write(file.path));
  occupancy::OctomapCounts counts;
  const occupancy::LocalMap map = occupancy::load_octomap(file.path, small_window(), Vec3::Zero(), &counts);
  EXPECT_EQ(map.state(Vec3::Zero()), VoxelState::kUnknown);
  EXPECT_EQ(counts.not_finite, std::uint64_t{1} << 48);
  EXPECT_EQ(counts.outside_window, 0u);
}

TEST(OctomapFiles, MapsFarFromTheOriginAreWrittenWithAStatedShift) {
  for (const Vec3& center :
       {Vec3(5.0e5, 5.5e6, 300.0), Vec3(kOrigin * kResolution_m, 0, 0), Vec3(-7.0e4, 10, -8.0e3)}) {
    const occupancy::LocalMap map = map_around(center);
    for (const char* name : {"far.ot", "far.bt"}) {
      const TemporaryFile file(name);
      const auto shift_m = occupancy::save_octomap(map, file.path);
      ASSERT_TRUE(shift_m);
      const auto tree = read_by_octomap(file.path);
      std::size_t num_known = 0;
      map.for_known([&](const occupancy::LocalMap::KnownVoxel& voxel) {
        const Vec3 in_file = geometry::center_of(voxel.index, kResolution_m) - *shift_m;
        ASSERT_EQ(state_in(*tree, geometry::index_of(in_file, kResolution_m)), voxel.state);
        ++num_known;
      });
      EXPECT_EQ(voxels_in(*tree), num_known);
      expect_same(map, occupancy::load_octomap(file.path, map.config(), center));
    }
    EXPECT_THROW(occupancy::octomap_message_data(map, true), std::length_error);
  }
}

TEST(OctomapFiles, MapsWithinReachAreNotShifted) {
  const double edge_m = kOrigin * kResolution_m;
  const TemporaryFile file("near.ot");
  for (const Vec3& center : {Vec3(0, 0, 0), Vec3(edge_m - 5.0, 5.0 - edge_m, 0)}) {
    const occupancy::LocalMap map = map_around(center);
    EXPECT_FALSE(occupancy::save_octomap(map, file.path));
    expect_same(map, occupancy::load_octomap(file.path, map.config(), center));
    EXPECT_FALSE(occupancy::octomap_message_data(map, true).empty());
  }
}

TEST(OctomapFiles, MapsWiderThanAnOctomapAreRefused) {
  occupancy::OctomapSource source;
  source.blocks = {{0, -2500, 0}, {0, 2500, 0}};
  try {
    occupancy::octomap_nodes(source, occupancy::OctomapForm::kFull);
    FAIL() << "accepted";
  } catch (const std::length_error& error) {
    EXPECT_STREQ(error.what(), "the map is 80016 voxels wide along y, and an OctoMap holds 65536");
  }
}

TEST(OctomapFiles, BrokenFilesAreRefusedWithAReason) {
  const TemporaryFile file("broken.ot");
  ASSERT_FALSE(occupancy::save_octomap(map_around(Vec3::Zero()), file.path));
  const std::string whole = bytes_of(file.path);
  const std::size_t data = whole.find("data\n") + 5;
  const std::vector<std::pair<std::string, std::string>> cases = {
      {whole.substr(0, whole.size() - 3), "it ends in the middle of its nodes"},
      {whole.substr(0, data), "it ends in the middle of its nodes"},
      {whole + "abc", "3 bytes after them"},
      {whole.substr(0, data) + std::string(200, '\xff'), "it has nodes below the voxels"},
      {"", "it is no file of OctoMap"},
      {"# Octomap OcTree file\nid ColorOcTree\nsize 1\nres 0.4\ndata\n", "'ColorOcTree', not an OcTree"},
      {"# Octomap OcTree file\nid OcTree\nsize 1\nres -1\ndata\n", "it has no resolution"},
      {"# Octomap OcTree file\nid OcTree\nsize many\nres 1\ndata\n", "bad line in its header: size many"},
  };
  for (const auto& [bytes, reason] : cases) {
    std::ofstream(file.path, std::ios::binary) << bytes;
    EXPECT_NE(problem_of(file.path).find(reason), std::string::npos) << problem_of(file.path);
    EXPECT_NE(problem_of(file.path).find(file.path), std::string::npos);
  }
}

TEST(OctomapFiles, NoBytesAtAllMakeTheReaderFail) {
  const TemporaryFile file("noise.bt");
  std::mt19937 random(5);
  for (int trial = 0; trial < 300; ++trial) {
    std::string bytes = "# Octomap OcTree binary file\nid OcTree\nsize 9\nres 0.2\ndata\n";
    for (unsigned i = random() % 200; i > 0; --i) bytes += static_cast<char>(random());
    std::ofstream(file.path, std::ios::binary) << bytes;
    problem_of(file.path);  // any answer will do
  }
}
