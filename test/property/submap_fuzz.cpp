// SPDX-License-Identifier: BSD-3-Clause
// Damaged submaps, handovers and map indices with matching checksums are refused with a reason, or do no harm whatever
// is done with them. With `--seconds=N` each test goes on for that long with other seeds; the sanitizers find more.
#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>

#include "content_builder.hpp"
#include "resealed.hpp"
#include "voxnav/submap/mesh.hpp"
#include "voxnav/submap/projective_integrator.hpp"
#include "voxnav/submap/submap_collection.hpp"

using namespace voxnav;  // NOLINT: test
using geometry::Pose;
using geometry::Vec3;
using submap::Submap;
using submap::SubmapCollection;

namespace {

double seconds_to_run = 0.0;

std::shared_ptr<const Submap> random_submap(unsigned seed) {
  submap::SubmapConfig config;
  config.max_surface_points = 50;
  config.certified = seed % 3 == 0;
  return Submap::from_content(test::random_content(seed, 24, 0.02, 0.3, 0.4),
                              geometry::from_position_yaw({1, 2, 3}, 0.5), config);
}

std::shared_ptr<const Submap> projective_submap() {
  submap::ProjectiveIntegrator integrator(submap::ProjectiveConfig{});
  std::vector<geometry::Vec3f> wall;
  wall.reserve(2000);
  for (int row = 0; row < 40; ++row) {
    for (int i = 0; i < 50; ++i) wall.emplace_back(4.f, 0.1f * static_cast<float>(i), 0.1f * static_cast<float>(row));
  }
  integrator.integrate(wall, Pose::Identity());
  return integrator.finish(submap::SubmapConfig{});
}

/// Returns a number of a kind on which programs often fail.
std::uint64_t nasty(std::mt19937* rng) {
  static const std::uint64_t values[] = {0,
                                         1,
                                         0x7F,
                                         0x80,
                                         0xFF,
                                         0x7FFFFFFF,
                                         0x80000000,
                                         0xFFFFFFFF,
                                         1ull << 26,
                                         0x7FF0000000000000,
                                         0x7FF8000000000000,
                                         0xFFFFFFFFFFFFFFFF,
                                         1ull << 62};
  return values[(*rng)() % (sizeof(values) / sizeof(values[0]))];
}

void damage(std::mt19937* rng, std::string* bytes) {
  const auto at = [&] {
    return bytes->empty() ? 0 : (*rng)() % ((*rng)() % 2 ? bytes->size() : std::min<std::size_t>(bytes->size(), 400));
  };
  switch ((*rng)() % 6) {
    case 0:
      (*bytes)[at()] = static_cast<char>((*rng)());
      break;
    case 1:
      (*bytes)[at()] ^= static_cast<char>(1u << ((*rng)() % 8));
      break;
    case 2: {
      const std::uint64_t value = nasty(rng);
      const std::size_t size = std::size_t{1} << ((*rng)() % 4);
      const std::size_t to = at();
      bytes->replace(to, std::min(size, bytes->size() - to), reinterpret_cast<const char*>(&value), size);
      break;
    }
    case 3:
      bytes->erase(at(), 1 + (*rng)() % 64);
      break;
    case 4:
      bytes->insert(at(), bytes->substr(at(), 1 + (*rng)() % 64));
      break;
    default:
      bytes->resize(bytes->size() - (*rng)() % std::min<std::size_t>(bytes->size(), 200));
  }
}

std::string damaged(std::mt19937* rng, std::string bytes) {
  for (unsigned i = 0; i < 1 + (*rng)() % 4 && bytes.size() > 8; ++i) damage(rng, &bytes);
  return bytes;
}

void use(const std::shared_ptr<const Submap>& submap, std::mt19937* rng) {
  const geometry::Aabb box = submap->known_bounds();
  const Vec3 low = box.empty() ? Vec3(-10, -10, -10) : box.min;
  const Vec3 high = box.empty() ? Vec3(10, 10, 10) : Vec3(box.max.cwiseMin(box.min + Vec3::Constant(40.0)));
  for (int i = 0; i < 10; ++i) {
    double distance = 0.0;
    Vec3 gradient = Vec3::Zero();
    if (submap->sample(test::random_in(rng, low, high), &distance, &gradient)) {
      ASSERT_TRUE(std::isfinite(distance) && gradient.allFinite());
    }
  }
  for (const auto& point : submap->surface_points()) ASSERT_TRUE(point.position.allFinite());
  ASSERT_EQ(Submap::from_bytes(submap->to_bytes())->to_bytes(), submap->to_bytes());
  submap::extract_mesh(*submap, 500);
  SubmapCollection collection({});
  submap::SubmapEntry entry;
  entry.submap = submap;
  entry.T_S_B = {{0, Pose::Identity()}};
  collection.add(entry);
  entry.id = 1;
  entry.T_W_S = geometry::from_position_yaw({0.7, 0.1, 0.2}, 0.3);
  collection.add(entry);
  collection.obstacles(1.0);
}

/// Calls attempt(rng) a fixed number of times, or for the time of --seconds, and prints the number of calls.
/// @return the number of calls
template <class Attempt>
int repeat(unsigned seed, int count, Attempt&& attempt) {
  std::mt19937 rng(seed);
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds_to_run / 3.0);
  int done = 0;
  for (; done < count || std::chrono::steady_clock::now() < end; ++done) attempt(&rng);
  std::printf("%d cases\n", done);
  return done;
}

}  // namespace

TEST(SubmapFuzz, DamagedSubmapsAreRefusedOrHarmless) {
  std::vector<std::string> originals = {projective_submap()->to_bytes()};
  for (unsigned seed = 1; seed < 4; ++seed) originals.push_back(random_submap(seed)->to_bytes());
  int refused = 0;
  const int done = repeat(1, 400, [&](std::mt19937* rng) {
    const std::string bytes = damaged(rng, originals[(*rng)() % originals.size()]);
    try {
      use(Submap::from_bytes((*rng)() % 16 == 0 ? bytes : test::resealed(bytes)), rng);
    } catch (const std::invalid_argument& error) {
      ASSERT_GT(std::string(error.what()).size(), 10u);
      ++refused;
    }
  });
  EXPECT_GT(refused, done / 4);
  EXPECT_LT(refused, done);
}

TEST(SubmapFuzz, DamagedHandoversAreRefusedOrHarmless) {
  const std::string original = test::random_content(3, 24, 0.02, 0.3, 0.4).to_bytes();
  int refused = 0;
  const int done = repeat(2, 300, [&](std::mt19937* rng) {
    try {
      const auto content = occupancy::MapContent::from_bytes(test::resealed(damaged(rng, original)));
      use(Submap::from_content(content, geometry::from_position_yaw({1, 2, 3}, 0.5), {}), rng);
    } catch (const std::invalid_argument&) {
      ++refused;
    }
  });
  EXPECT_GT(refused, done / 4);
}

TEST(SubmapFuzz, DamagedIndicesAreRefusedOrGiveWhatIsIntact) {
  const std::string directory = ::testing::TempDir() + "voxnav_fuzz_" + std::to_string(::getpid());
  SubmapCollection collection({});
  for (std::uint32_t id = 0; id < 3; ++id) {
    submap::SubmapEntry entry;
    entry.id = id;
    entry.end_ns = id;
    entry.T_W_S = geometry::from_position_yaw({3.0 * id, 1.0, 2.0}, 0.1 * id);
    entry.T_S_B = {{5, Pose::Identity()}};
    entry.submap = random_submap(id + 1);
    collection.add(entry);
  }
  collection.save(directory);
  const std::string path = directory + "/index.vxi";
  std::ifstream in(path, std::ios::binary);
  const std::string original{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  int recovered = 0;
  repeat(3, 150, [&](std::mt19937* rng) {
    const std::string bytes = damaged(rng, original);
    std::ofstream(path, std::ios::binary | std::ios::trunc) << ((*rng)() % 2 ? bytes : test::resealed(bytes));
    try {
      std::vector<std::string> problems;
      const auto loaded = SubmapCollection::load(directory, &problems);
      for (const submap::SubmapEntry* entry : loaded.entries()) {
        const auto* saved = collection.find(entry->id);
        ASSERT_NE(saved, nullptr);
        ASSERT_EQ(entry->T_W_S.matrix(), saved->T_W_S.matrix());
        ASSERT_EQ(entry->end_ns, saved->end_ns);
      }
      ASSERT_TRUE(loaded.size() == 3 || !problems.empty());
      recovered += !problems.empty();
    } catch (const std::exception& error) {
      ASSERT_NE(std::string(error.what()).find("index.vxi"), std::string::npos) << error.what();
    }
  });
  EXPECT_GT(recovered, 20);
}

int main(int argc, char** argv) {
  ::testing::InitGoogleTest(&argc, argv);
  const std::string flag = "--seconds=";
  if (argc > 1 && flag.compare(0, flag.size(), argv[1], flag.size()) == 0)
    seconds_to_run = std::atof(argv[1] + flag.size());
  return RUN_ALL_TESTS();
}
