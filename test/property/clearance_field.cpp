// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/planning/clearance_field.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>

#include "box_grid.hpp"
#include "planning/segment_box.hpp"

using namespace voxnav;  // NOLINT: test
using containers::VoxelState;
using geometry::Index3;
using geometry::Vec3;
using planning::ClearanceField;
using planning::ClearanceFieldConfig;

namespace {

constexpr double kResolution = 0.5;
constexpr int kLow = -19;
constexpr int kHigh = 21;

/// A map with obstacles that were grown elsewhere already (soft) and limits (hard), and bounds of its own.
class LimitedView : public planning::StateGridView {
 public:
  explicit LimitedView(std::shared_ptr<const containers::StateGrid> grid) : StateGridView(std::move(grid)) {}

  geometry::Aabb bounds() const override { return bounds_; }
  std::vector<Index3> known_blocks() const override {
    std::vector<Index3> out = StateGridView::known_blocks();
    for (const auto* limits : {&hard_, &soft_}) {
      for (const auto& entry : *limits) out.push_back(geometry::block_of(entry.first));
    }
    return out;
  }
  bool forbidden(const Index3& block, planning::BlockMask* hard, planning::BlockMask* soft) const override {
    const auto mark = [&](const std::map<Index3, bool>& limits, planning::BlockMask* mask) {
      for (const auto& entry : limits) {
        if (geometry::block_of(entry.first) == block) mask->set(geometry::offset_in_block(entry.first));
      }
    };
    mark(hard_, hard);
    mark(soft_, soft);
    return hard->any() || soft->any();
  }

  geometry::Aabb bounds_;
  std::map<Index3, bool> hard_, soft_;
};

/// What the field must say, straight from its definition.
class BruteForce {
 public:
  BruteForce(const LimitedView& view, const ClearanceFieldConfig& config) : view_(view), config_(config) {
    for (int z = -kHalf; z < kHalf; ++z) {
      for (int y = -kHalf; y < kHalf; ++y) {
        for (int x = -kHalf; x < kHalf; ++x) states_[at({x, y, z})] = view.state(Index3{x, y, z});
      }
    }
  }

  int squared_to(const Index3& voxel, VoxelState state) const {
    const double radius = state == VoxelState::kOccupied
                              ? config_.radius_m
                              : std::max(config_.unknown_radius_m, config_.safety_distance_m);
    const double limit = 4.0 * std::pow(radius / kResolution, 2) + 1e-6;
    const int reach = static_cast<int>(radius / kResolution) + 1;
    int best = ClearanceField::kFar;
    for (int z = -reach; z <= reach; ++z) {
      for (int y = -reach; y <= reach; ++y) {
        for (int x = -reach; x <= reach; ++x) {
          if (states_[at(voxel + Index3{x, y, z})] != state) continue;
          const auto face = [](int k) { return k == 0 ? 0 : 2 * std::abs(k) - 1; };
          const int squared = face(x) * face(x) + face(y) * face(y) + face(z) * face(z);
          if (squared <= limit) best = std::min(best, squared);
        }
      }
    }
    return best;
  }

  bool is_flyable(const Index3& voxel) const {
    signed char& known = flyable_[at(voxel)];
    if (known < 0) known = compute_flyable(voxel) ? 1 : 0;
    return known > 0;
  }

  bool compute_flyable(const Index3& voxel) const {
    const VoxelState state = states_[at(voxel)];
    if (state == VoxelState::kOccupied || !view_.bounds_.contains(geometry::center_of(voxel, kResolution)))
      return false;
    if (state == VoxelState::kUnknown && !config_.unknown_is_flyable) return false;
    const double needed = 4.0 * std::pow(config_.safety_distance_m / kResolution, 2) - 1e-3;
    if (squared_to(voxel, VoxelState::kOccupied) < needed || view_.hard_.count(voxel) > 0) return false;
    return view_.soft_.count(voxel) == 0 || squared_to(voxel, VoxelState::kUnknown) >= std::max(needed, 0.5);
  }

  /// Floods each part through faces. Blocks of which nothing is known count as one part if unknown voxels are flyable.
  std::map<Index3, int> parts() const {
    std::map<Index3, int> out;
    const std::vector<Index3> unheld = config_.unknown_is_flyable ? voxels_of_unheld_blocks() : std::vector<Index3>();
    int num_parts = 0;
    bool has_met_unheld = false;
    for (const Index3& seed : domain()) {
      if (out.count(seed) > 0 || !is_flyable(seed)) continue;
      std::vector<Index3> open = {seed};
      out[seed] = ++num_parts;
      const auto reach = [&](const Index3& next) {
        if (is_flyable(next) && out.emplace(next, num_parts).second) open.push_back(next);
      };
      while (!open.empty()) {
        const Index3 here = open.back();
        open.pop_back();
        for (const Index3& step : {Index3{1, 0, 0}, Index3{0, 1, 0}, Index3{0, 0, 1}}) {
          reach(here + step);
          reach(here - step);
        }
        if (!has_met_unheld && std::binary_search(unheld.begin(), unheld.end(), here)) {
          has_met_unheld = true;
          for (const Index3& other : unheld) reach(other);
        }
      }
    }
    return out;
  }

  static std::vector<Index3> domain() {
    std::vector<Index3> out;
    for (int z = kLow; z < kHigh; ++z) {
      for (int y = kLow; y < kHigh; ++y) {
        for (int x = kLow; x < kHigh; ++x) out.push_back({x, y, z});
      }
    }
    return out;
  }

 private:
  static constexpr int kHalf = 40;
  static constexpr std::size_t kNumVoxels = std::size_t{8} * kHalf * kHalf * kHalf;
  static std::size_t at(const Index3& v) {
    const auto part = [](int coordinate) { return static_cast<std::size_t>(coordinate) + kHalf; };
    return (part(v.z) * 2 * kHalf + part(v.y)) * 2 * kHalf + part(v.x);
  }

  /// The flyable voxels, sorted, of blocks that hold nothing and are far from everything.
  std::vector<Index3> voxels_of_unheld_blocks() const {
    std::map<Index3, bool> is_held;
    for (const Index3& block : view_.known_blocks()) is_held[block] = true;
    std::vector<Index3> out;
    for (const Index3& voxel : domain()) {
      const Index3 block = geometry::block_of(voxel);
      if (is_held.count(block) == 0) {
        bool& is = is_held[block];
        for (int i = 0; i < geometry::kBlockVolume && !is; ++i) {
          const Index3 v = geometry::voxel_at(block, i);
          is = std::max({v.x, v.y, v.z}) < 24 && std::min({v.x, v.y, v.z}) >= -24 &&
               squared_to(v, VoxelState::kOccupied) != ClearanceField::kFar;
        }
      }
      if (!is_held[block] && is_flyable(voxel)) out.push_back(voxel);
    }
    return out;
  }

  const LimitedView& view_;
  const ClearanceFieldConfig& config_;
  std::vector<VoxelState> states_ = std::vector<VoxelState>(kNumVoxels);
  mutable std::vector<signed char> flyable_ = std::vector<signed char>(kNumVoxels, -1);
};

class Scene {
 public:
  explicit Scene(int seed) : rng_(static_cast<unsigned>(seed)) {
    grid = test::box_grid({-16, -16, -16}, {15, 15, 15}, kResolution);
    view = std::make_shared<LimitedView>(grid);
    move_bounds();
  }

  void change() {
    const int kind = number(9);
    if (kind == 0) grid->erase_block(geometry::block_of(voxel()));
    if (kind == 1) move_bounds();
    if (kind == 2) view->hard_ = {{voxel(), true}, {voxel(), true}};
    if (kind == 3) {
      view->soft_.clear();
      for (int i = 0; i < 60; ++i) view->soft_[voxel()] = true;
    }
    const auto state = static_cast<VoxelState>(number(3));
    if (kind == 4 || kind == 5) {  // a wall or a slit
      const Index3 at = voxel();
      const bool is_x = number(2) == 0;
      test::fill(grid.get(), {is_x ? at.x : -16, is_x ? -16 : at.y, -16}, {is_x ? at.x : 15, is_x ? 15 : at.y, 15},
                 state);
    }
    for (int i = 0; i < (kind == 6 ? 300 : 3); ++i) grid->set(voxel(), static_cast<VoxelState>(number(3)));
    if (kind > 6) test::fill(grid.get(), {-4, -4, -4}, {number(9), number(9), number(9)}, VoxelState::kFree);
  }

  std::shared_ptr<containers::StateGrid> grid;
  std::shared_ptr<LimitedView> view;

 private:
  int number(int below) { return static_cast<int>(rng_() % static_cast<unsigned>(below)); }
  Index3 voxel() { return {number(32) - 16, number(32) - 16, number(32) - 16}; }
  void move_bounds() {
    view->bounds_.min = Vec3(-8.0 - 0.5 * number(3), -8.0, -8.0 + number(6));
    view->bounds_.max = Vec3(8.0, 8.0 + 0.5 * number(3), 8.0 - number(4));
  }

  std::mt19937 rng_;
};

void expect_equal(const ClearanceField& field, const LimitedView& view) {
  const BruteForce expected(view, field.config());
  const std::map<Index3, int> parts = expected.parts();
  std::map<int, std::uint32_t> label_of_part;
  std::map<std::uint32_t, int> part_of_label;
  for (const Index3& voxel : BruteForce::domain()) {
    const Vec3 center = geometry::center_of(voxel, kResolution);
    if (view.bounds_.contains(center)) {
      ASSERT_EQ(field.squared_to_occupied(voxel), expected.squared_to(voxel, VoxelState::kOccupied));
      ASSERT_EQ(field.squared_to_unknown(voxel), expected.squared_to(voxel, VoxelState::kUnknown));
    }
    const std::uint32_t label = field.component(center);
    const auto part = parts.find(voxel);
    ASSERT_EQ(label != 0, part != parts.end()) << "voxel " << voxel.x << " " << voxel.y << " " << voxel.z;
    if (label == 0) continue;
    ASSERT_EQ(label_of_part.emplace(part->second, label).first->second, label);
    ASSERT_EQ(part_of_label.emplace(label, part->second).first->second, part->second);
  }
}

}  // namespace

TEST(ClearanceFieldProperty, EqualsBruteForceAfterAnySequenceOfUpdates) {
  for (int seed = 0; seed < 6; ++seed) {
    ClearanceFieldConfig config;
    config.safety_distance_m = seed == 4 ? 0.0 : 0.5 + 0.25 * (seed % 3);
    config.radius_m = config.safety_distance_m + 0.3 * seed;
    config.unknown_radius_m = 0.4 * (5 - seed);
    config.unknown_is_flyable = seed % 2 == 1;
    Scene scene(seed);
    ClearanceField field(config);
    for (int step = 0; step < 12; ++step) {
      if (step > 0) scene.change();
      field.update(*scene.view);
      if (step % 3 != 2) continue;
      SCOPED_TRACE("seed " + std::to_string(seed) + " step " + std::to_string(step));
      expect_equal(field, *scene.view);
      if (::testing::Test::HasFatalFailure()) return;
    }
  }
}

TEST(ClearanceFieldProperty, ClearanceIsTheDistanceToTheNearestBox) {
  Scene scene(7);
  for (int i = 0; i < 8; ++i) scene.change();
  ClearanceFieldConfig config;
  config.safety_distance_m = 0.5;
  config.radius_m = 3.0;
  ClearanceField field(config);
  field.update(*scene.view);
  std::vector<geometry::Aabb> boxes;
  for (const Index3& block : scene.grid->sorted_block_indices()) {
    for (int offset = 0; offset < geometry::kBlockVolume; ++offset) {
      const Index3 voxel = geometry::voxel_at(block, offset);
      if (scene.grid->state(voxel) != VoxelState::kOccupied) continue;
      const Vec3 low = Vec3(voxel.x, voxel.y, voxel.z) * kResolution;
      boxes.push_back({low, low + Vec3::Constant(kResolution)});
    }
  }
  std::mt19937 rng(1);
  std::uniform_real_distribution<double> coordinate(-9.0, 9.0);
  int num_near = 0;
  for (int i = 0; i < 1000; ++i) {
    const Vec3 point(coordinate(rng), coordinate(rng), coordinate(rng));
    double expected = config.radius_m;
    for (const geometry::Aabb& box : boxes) {
      expected = std::min(expected, std::sqrt(planning::squared_distance(point, box)));
    }
    num_near += expected < config.radius_m;
    ASSERT_NEAR(field.clearance(point), expected, 1e-12);
  }
  EXPECT_GT(num_near, 100);
}
