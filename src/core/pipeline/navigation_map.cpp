// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/pipeline/navigation_map.hpp"

#include <cmath>
#include <stdexcept>
#include <utility>

#include "pipeline/navigation_view.hpp"

namespace voxnav::pipeline {
namespace {
constexpr int kMaxIgnored = 5;
}

std::vector<std::string> NavigationMapConfig::problems() const {
  std::vector<std::string> out;
  if (min_altitude_m >= max_altitude_m) out.emplace_back("min_altitude_m must be below max_altitude_m");
  if (max_height_m > 0.0 && min_height_m >= max_height_m) {
    out.emplace_back("min_height_m must be below max_height_m");
  }
  return out;
}

NavigationMap::NavigationMap(const NavigationMapConfig& config)
    : config_(base::checked(config)), terrain_(std::make_shared<TerrainSource>()) {}

NavigationMap::Applied NavigationMap::Layer::apply(const containers::GridUpdate& update, std::uint32_t next,
                                                   double resolution_m) {
  const bool is_fitting = grid != nullptr && grid->resolution_m() == resolution_m;
  if (!update.is_snapshot) {
    if (!is_fitting) return Applied::kNeedsSnapshot;
    // A snapshot from the service may arrive before changes that were sent earlier.
    if (static_cast<std::int32_t>(next - sequence) <= 0) {
      return ++num_ignored > kMaxIgnored ? Applied::kNeedsSnapshot : Applied::kIgnored;
    }
    if (next != sequence + 1) return Applied::kNeedsSnapshot;
  }
  // The grid is copied if a view holds it, since views must not see it change.
  std::shared_ptr<containers::StateGrid> changed = grid;
  if (!is_fitting || update.is_snapshot) {
    changed = std::make_shared<containers::StateGrid>(resolution_m);
  } else if (grid.use_count() > 2) {
    changed = std::make_shared<containers::StateGrid>(*grid);
  }
  containers::apply(update, changed.get());
  grid = changed;
  sequence = next;
  num_ignored = 0;
  return Applied::kApplied;
}

NavigationMap::Applied NavigationMap::apply_local(const containers::GridUpdate& update, std::uint32_t sequence,
                                                  double resolution_m) {
  const std::lock_guard<std::mutex> lock(mutex_);
  return local_.apply(update, sequence, resolution_m);
}

NavigationMap::Applied NavigationMap::apply_obstacles(const containers::GridUpdate& update, std::uint32_t sequence,
                                                      double resolution_m) {
  const std::lock_guard<std::mutex> lock(mutex_);
  return obstacles_.apply(update, sequence, resolution_m);
}

void NavigationMap::set_sightings(const SweepSightings& sightings) {
  if (!(sightings.resolution_m > 0.0)) throw std::invalid_argument("the resolution of sightings is not positive");
  for (const containers::MovingThing& thing : sightings.things) {
    const bool is_finite = thing.position.allFinite() && thing.velocity.allFinite() && thing.half_size_m.allFinite() &&
                           std::isfinite(thing.position_sigma_m) && std::isfinite(thing.velocity_sigma_mps);
    if (!is_finite) throw std::invalid_argument("a moving thing is not finite");
  }
  planning::SharedOthers others;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    others = others_O_;
  }
  auto placed = std::make_shared<const PlacedSightings>(config_, sightings, std::move(others));
  const std::lock_guard<std::mutex> lock(mutex_);
  sightings_ = std::move(placed);
}

void NavigationMap::set_others(std::vector<containers::OtherUav> others) {
  for (const containers::OtherUav& other : others) planning::require_valid(other);
  auto kept = std::make_shared<const std::vector<containers::OtherUav>>(std::move(others));
  const std::lock_guard<std::mutex> lock(mutex_);
  others_O_ = std::move(kept);
}

void NavigationMap::set_T_W_O(const geometry::Pose& T_W_O) {
  if (!geometry::is_valid(T_W_O)) throw std::invalid_argument("T_W_O is not a rigid transform");
  const std::lock_guard<std::mutex> lock(mutex_);
  T_W_O_ = T_W_O;
}

void NavigationMap::set_vehicle(const geometry::Vec3& position_O) {
  if (!position_O.allFinite()) throw std::invalid_argument("vehicle position is not finite");
  const std::lock_guard<std::mutex> lock(mutex_);
  vehicle_O_ = position_O;
}

void NavigationMap::set_fences(std::shared_ptr<const planning::Fences> fences_O) {
  const std::lock_guard<std::mutex> lock(mutex_);
  fences_O_ = std::move(fences_O);
}

void NavigationMap::set_altitudes(double min_m, double max_m) {
  const std::lock_guard<std::mutex> lock(mutex_);
  NavigationMapConfig changed = config_;
  changed.min_altitude_m = min_m;
  changed.max_altitude_m = max_m;
  config_ = base::checked(changed);
}

void NavigationMap::clear_local() {
  const std::lock_guard<std::mutex> lock(mutex_);
  local_ = Layer{};
  sightings_ = nullptr;
}

void NavigationMap::clear_obstacles() {
  const std::lock_guard<std::mutex> lock(mutex_);
  obstacles_ = Layer{};
}

std::shared_ptr<const planning::OccupancyView> NavigationMap::view() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (local_.grid == nullptr || !T_W_O_ || !vehicle_O_) return nullptr;
  const double resolution_m = local_.grid->resolution_m();
  if (obstacles_.grid == nullptr) {
    placed_ = nullptr;
  } else if (placed_ == nullptr || !placed_->is_of(obstacles_.grid.get(), *T_W_O_, resolution_m)) {
    placed_ = std::make_shared<PlacedObstacles>(obstacles_.grid, *T_W_O_, resolution_m);
  }
  if (fences_O_ == nullptr) {
    raster_ = nullptr;
  } else if (raster_ == nullptr || !raster_->is_of(fences_O_.get(), resolution_m)) {
    const planning::FenceMargins margins{config_.area_margin_m, config_.zone_distance_m};
    raster_ = std::make_shared<planning::FenceRaster>(fences_O_, margins, resolution_m);
  }
  NavigationView::Content content{local_.grid, placed_, raster_, sightings_, terrain_, *T_W_O_, *vehicle_O_};
  if (sightings_ != nullptr && sightings_->resolution_m() != resolution_m) content.sightings = nullptr;
  return std::make_shared<NavigationView>(config_, std::move(content));
}

NavigationMap::~NavigationMap() = default;

}  // namespace voxnav::pipeline
