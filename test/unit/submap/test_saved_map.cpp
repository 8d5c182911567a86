// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <iterator>

#include "content_builder.hpp"
#include "resealed.hpp"
#include "voxnav/submap/submap_collection.hpp"

using namespace voxnav;  // NOLINT: test
using geometry::Pose;
using geometry::Vec3;
using submap::SubmapCollection;
using submap::SubmapCollectionConfig;
using submap::SubmapEntry;

namespace {

std::string new_directory(const std::string& name) {
  return ::testing::TempDir() + "voxnav_" + name + "_" + std::to_string(::getpid());
}

SubmapEntry entry_of(std::uint32_t id) {
  SubmapEntry entry;
  entry.id = id;
  entry.end_ns = 1000 * static_cast<base::StampNs>(id);
  entry.T_W_S = geometry::from_position_yaw({5.0 * id, 1.0, 0.0}, 0.1 * id);
  entry.T_S_B = {{1, Pose::Identity()}, {2, geometry::from_position_yaw({1, 2, 3}, 0.4)}};
  entry.submap = submap::Submap::from_content(test::random_content(id, 20, 0.02, 0.3, 0.4), Pose::Identity(), {});
  return entry;
}

std::string saved(const std::string& name, std::uint32_t count) {
  std::string directory = new_directory(name);
  SubmapCollection collection({});
  for (std::uint32_t id = 1; id <= count; ++id) collection.add(entry_of(id));
  collection.save(directory);
  return directory;
}

std::string read(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

void write(const std::string& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary | std::ios::trunc) << bytes;
}

}  // namespace

TEST(SavedMap, ATruncatedIndexGivesTheSubmapsBeforeItsEnd) {
  const std::string directory = saved("truncated", 6);
  const std::string path = directory + "/index.vxi";
  const std::string whole = read(path);
  std::size_t last = 0;
  for (std::size_t size = whole.size() / 6; size < whole.size(); size += whole.size() / 23) {
    write(path, whole.substr(0, size));
    EXPECT_THROW(SubmapCollection::load(directory), std::invalid_argument);
    std::vector<std::string> problems;
    std::size_t count = 0;
    try {
      const SubmapCollection part = SubmapCollection::load(directory, &problems);
      count = part.size();
      for (const SubmapEntry* entry : part.entries())
        EXPECT_EQ(entry->T_W_S.matrix(), entry_of(entry->id).T_W_S.matrix());
      EXPECT_EQ(problems.size(), 1u);
      EXPECT_NE(problems[0].find("of 6 submaps are intact"), std::string::npos) << problems[0];
    } catch (const std::invalid_argument&) {
      EXPECT_EQ(last, 0u) << "more bytes cannot give less";
    }
    EXPECT_GE(count, last);
    last = count;
  }
  EXPECT_GE(last, 5u);
}

TEST(SavedMap, ParentDirectoriesAreMadeAndAFileInTheirPlaceIsNamed) {
  const std::string top = new_directory("nested");
  SubmapCollection collection({});
  collection.add(entry_of(1));
  collection.save(top + "/a/b/");
  EXPECT_EQ(SubmapCollection::load(top + "/a/b").size(), 1u);
  const std::string file = top + "/a/b/index.vxi";
  try {
    collection.save(file);
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_EQ(std::string(error.what()).find(file + ": cannot be created: "), 0u) << error.what();
  }
}

TEST(SavedMap, FilesThatNoIndexNamesAreRemovedAndOthersAreNot) {
  const std::string directory = saved("unlisted", 2);
  write(directory + "/submap_000009_00000000.vxs", "left over");
  write(directory + "/notes.txt", "mine");
  SubmapCollection::load(directory).save(directory);
  EXPECT_EQ(read(directory + "/submap_000009_00000000.vxs"), "");
  EXPECT_EQ(read(directory + "/notes.txt"), "mine");
  EXPECT_EQ(SubmapCollection::load(directory).size(), 2u);
}

TEST(SavedMap, BendsAreKept) {
  const std::string directory = new_directory("bent");
  SubmapCollection collection({});
  SubmapEntry entry = entry_of(1);
  entry.bend.T_S_begin = geometry::from_position_yaw({0.1, 0.2, 0.3}, 0.01);
  entry.bend.T_S_end = geometry::from_position_yaw({-0.4, 0.0, 0.1}, -0.02);
  collection.add(entry);
  collection.save(directory);
  const SubmapCollection loaded = SubmapCollection::load(directory);
  EXPECT_EQ(loaded.find(1)->bend.T_S_begin.matrix(), entry.bend.T_S_begin.matrix());
  EXPECT_EQ(loaded.find(1)->bend.T_S_end.matrix(), entry.bend.T_S_end.matrix());
}

TEST(SavedMap, AnIndexOfAnotherVersionIsNamedWithItsVersionAndTheOneThatIsRead) {
  const std::string directory = saved("other_index", 2);
  const std::string path = directory + "/index.vxi";
  write(path, test::as_version(3, read(path)));
  const std::string wanted = path + " has version 3 of its format; this program reads version 1 only";
  EXPECT_EQ(test::refusal_of([&] { SubmapCollection::load(directory); }), wanted);
  // Only damaged indices are recovered. Records of another version may mean something else, so none of them is used.
  std::vector<std::string> problems;
  EXPECT_EQ(test::refusal_of([&] { SubmapCollection::load(directory, &problems); }), wanted);
}

TEST(SavedMap, ASubmapFileOfAnotherVersionIsNamedAndLosesThatSubmapOnly) {
  const std::string directory = saved("other_submap", 1);
  const std::string intact = entry_of(1).submap->to_bytes();
  const std::uint32_t sum = base::crc32(intact.data(), intact.size());
  char name[48];
  std::snprintf(name, sizeof(name), "/submap_%06u_%08x.vxs", 1u, sum);
  const std::string path = directory + name;
  ASSERT_EQ(read(path), intact);
  write(path, test::as_version(5, intact));
  const std::string wanted = path + ": submap has version 5 of its format; this program reads version 1 only";
  EXPECT_EQ(test::refusal_of([&] { SubmapCollection::load(directory); }), wanted);
  std::vector<std::string> problems;
  EXPECT_EQ(SubmapCollection::load(directory, &problems).size(), 0u);
  EXPECT_EQ(problems, std::vector<std::string>{wanted});
}

TEST(SavedMap, ADamagedEntryLosesThatSubmapOnly) {
  const std::string directory = saved("broken", 5);
  const std::string path = directory + "/index.vxi";
  const std::string whole = read(path);
  for (std::size_t at = whole.size() / 4; at < whole.size() - 8; at += whole.size() / 11) {
    std::string broken = whole;
    broken[at] = static_cast<char>(broken[at] ^ 0x10);
    write(path, broken);
    std::vector<std::string> problems;
    EXPECT_EQ(SubmapCollection::load(directory, &problems).size(), 4u) << at;
    EXPECT_EQ(problems.size(), 1u);
  }
}

TEST(SavedMap, LimitsAndPagingAreThoseOfTheReader) {
  const std::string directory = saved("paging", 8);
  SubmapCollectionConfig config;
  config.page_dir = ::testing::TempDir();
  config.max_resident_mb = 1.0;
  config.max_submaps = 6;
  const SubmapCollection loaded = SubmapCollection::load(directory, nullptr, &config);
  EXPECT_EQ(loaded.config().page_dir, config.page_dir);
  EXPECT_EQ(loaded.size(), 6u);
  config.resolution_m = 0.2;
  EXPECT_THROW(SubmapCollection::load(directory, nullptr, &config), std::invalid_argument);
}

TEST(SavedMap, ALaterFlightIsNewerWhateverItsStamps) {
  SubmapCollection first({});
  test::ContentBuilder with_box(0.4);
  test::ContentBuilder without_box(0.4);
  for (int i = 0; i < 1000; ++i) {
    with_box.set_free({i % 10, i / 10 % 10, i / 100});
    without_box.set_free({i % 10, i / 10 % 10, i / 100});
  }
  for (int i = 0; i < 27; ++i) with_box.set_occupied({4 + i % 3, 4 + i / 3 % 3, 4 + i / 9});
  SubmapEntry entry;
  entry.id = 3;
  entry.end_ns = 1000000;
  entry.submap = submap::Submap::from_content(with_box.build(), Pose::Identity(), {});
  first.add(entry);
  SubmapCollection second({});
  entry.end_ns = 5;
  entry.submap = submap::Submap::from_content(without_box.build(), Pose::Identity(), {});
  second.add(entry);
  first.merge(second, Pose::Identity());
  EXPECT_TRUE(first.occupied_points().empty());
  const std::string directory = new_directory("flights");
  first.save(directory);
  EXPECT_TRUE(SubmapCollection::load(directory).occupied_points().empty());
}
