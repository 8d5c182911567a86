// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/occupancy/moving_things.hpp"

#include <algorithm>
#include <deque>
#include <optional>

#include "occupancy/moving/followed_thing.hpp"

namespace voxnav::occupancy {
namespace {

/// The number of things that are followed at most, and of voxels that one remembers before it is known to move.
constexpr std::size_t kMaxTracks = 256;
constexpr std::size_t kMaxVoxels = 2000;
/// Hits nearer than a cell are connected; cells are not smaller than this.
constexpr double kCell_m = 0.4;
/// What is not known to move and not seen for this long is forgotten.
constexpr double kForgotten_s = 0.35;
/// Sweeps of several sensors overtake each other by less than this.
constexpr double kJump_s = 1.0;
/// Of the voxels that a thing has left, at least so many and this share must be seen to be empty.
constexpr int kFewestEmpty = 3;
constexpr double kEmptyShare = 0.6;
/// Hits beside surfaces that are this near to a moving thing are its own.
constexpr double kReach_m = 0.6;
/// The velocity of the vehicle is taken over this time.
constexpr double kVelocity_s = 0.3;

/// The velocity of the vehicle from its places.
class VehicleMotion {
 public:
  void add(base::StampNs stamp_ns, const geometry::Vec3& position) {
    places_.push_back({stamp_ns, position});
    while (places_.size() > 2 && base::to_seconds(stamp_ns - places_[1].stamp_ns) >= kVelocity_s) places_.pop_front();
  }
  geometry::Vec3 velocity() const {
    const double time_s = base::to_seconds(places_.back().stamp_ns - places_.front().stamp_ns);
    if (time_s <= 0.0) return geometry::Vec3::Zero();
    return (places_.back().position - places_.front().position) / time_s;
  }
  void clear() { places_.clear(); }

 private:
  struct Place {
    base::StampNs stamp_ns;
    geometry::Vec3 position;
  };
  std::deque<Place> places_;
};

void append_voxels(const HitCluster& cluster, const std::vector<NewHit>& hits, std::vector<geometry::Index3>* out) {
  for (const std::size_t i : cluster.hits) out->push_back(hits[i].voxel);
}

bool is_within(const geometry::Aabb& box, double size_m) { return ((box.max - box.min).array() <= size_m).all(); }

}  // namespace

std::vector<std::string> MovingThingsConfig::problems() const {
  std::vector<std::string> out;
  if (min_speed_mps >= max_speed_mps) out.emplace_back("min_speed_mps must be below max_speed_mps");
  return out;
}

/// Whether scans see through most of the voxels that a thing hit before and does not hit any more. Something that moved
/// leaves empty space; of static things at whose edges hits wander, beams do not pass where the hits were.
bool leaves_empty_space(const FollowedThing& track, const LocalMap& map) {
  int num_left = 0, num_empty = 0;
  for (const geometry::Index3& voxel : track.voxels) {
    const auto sight = map.sight_of_new(voxel);
    if (!sight || sight->scans_since_hit == 0) continue;
    ++num_left;
    num_empty += sight->is_seen_through ? 1 : 0;
  }
  return num_empty >= kFewestEmpty && num_empty >= kEmptyShare * num_left;
}

struct MovingThings::Impl {
  explicit Impl(const MovingThingsConfig& checked) : config(checked) {}

  void clear();
  void follow(const std::vector<NewHit>& hits, double cell_m);
  FollowedThing* track_for(const HitCluster& cluster);
  void join(FollowedThing* track, std::vector<const HitCluster*> clusters, const std::vector<NewHit>& hits);
  void remember(FollowedThing* track, const HitCluster& seen, const std::vector<NewHit>& hits);
  void judge(FollowedThing* track, const LocalMap& map);
  void attribute_hits_beside(const std::vector<NewHit>& hits);
  void forget();

  MovingThingsConfig config;
  std::vector<FollowedThing> tracks;  // by rising id
  std::vector<MovingThing> things;
  std::vector<geometry::Index3> moving_voxels, static_voxels;  // what update() has to tell the map
  std::vector<geometry::Aabb> bodies;                          // where moving things are
  VehicleMotion vehicle;
  std::optional<base::StampNs> stamp_ns;
  std::uint32_t next_id = 1;
  std::size_t num_not_followed = 0;
};

void MovingThings::Impl::clear() {
  tracks.clear();
  things.clear();
  vehicle.clear();
  stamp_ns.reset();
}

/// Returns the track whose expected middle is nearest among those that expect hits where the cluster is. Tracks that
/// are known to move come first.
FollowedThing* MovingThings::Impl::track_for(const HitCluster& cluster) {
  FollowedThing* best = nullptr;
  double best_m = 0.0;
  for (FollowedThing& track : tracks) {
    if (!track.expected_box(*stamp_ns).intersects(cluster.box)) continue;
    const double distance_m = (track.expected_center(*stamp_ns) - cluster.center).norm();
    const bool is_better = best == nullptr || track.is_moving != best->is_moving ? track.is_moving || best == nullptr
                                                                                 : distance_m < best_m;
    if (!is_better) continue;
    best = &track;
    best_m = distance_m;
  }
  return best;
}

/// Gives a track the nearest cluster, and others as long as they may be parts of the same thing: a trunk before it
/// may cut what is seen of it in two.
void MovingThings::Impl::join(FollowedThing* track, std::vector<const HitCluster*> clusters,
                              const std::vector<NewHit>& hits) {
  const geometry::Vec3 expected = track->expected_center(*stamp_ns);
  std::stable_sort(clusters.begin(), clusters.end(), [&](const HitCluster* a, const HitCluster* b) {
    return (a->center - expected).squaredNorm() < (b->center - expected).squaredNorm();
  });
  HitCluster seen;
  for (const HitCluster* cluster : clusters) {
    HitCluster joint = seen;
    joint.add(*cluster);
    if (track->may_have(joint.box, config.max_size_m)) seen = std::move(joint);
  }
  if (seen.hits.empty()) return;
  track->see(*stamp_ns, seen);
  remember(track, seen, hits);
}

/// Records which voxels a track hit. Of one that moves, only the newest have to be known: the map knows the others.
void MovingThings::Impl::remember(FollowedThing* track, const HitCluster& seen, const std::vector<NewHit>& hits) {
  if (track->is_moving) {
    track->voxels.clear();
    append_voxels(seen, hits, &track->voxels);
    append_voxels(seen, hits, &moving_voxels);
    return;
  }
  for (const std::size_t i : seen.hits) {
    if (hits[i].is_first && track->voxels.size() < kMaxVoxels) track->voxels.push_back(hits[i].voxel);
  }
}

void MovingThings::Impl::follow(const std::vector<NewHit>& hits, double cell_m) {
  const std::vector<HitCluster> clusters = connected_hits(hits, cell_m);
  std::vector<std::vector<const HitCluster*>> taken(tracks.size());
  std::vector<const HitCluster*> others;
  for (const HitCluster& cluster : clusters) {
    const FollowedThing* track = track_for(cluster);
    if (track == nullptr) {
      others.push_back(&cluster);
    } else {
      taken[static_cast<std::size_t>(track - tracks.data())].push_back(&cluster);
    }
  }
  for (std::size_t i = 0; i < taken.size(); ++i) join(&tracks[i], std::move(taken[i]), hits);
  for (const HitCluster* cluster : others) {
    if (!is_within(cluster->box, config.max_size_m)) continue;
    if (tracks.size() >= kMaxTracks) {
      ++num_not_followed;
      continue;
    }
    tracks.emplace_back(next_id++, *stamp_ns, *cluster);
    append_voxels(*cluster, hits, &tracks.back().voxels);
  }
}

/// Gives moving things the hits close to them that lie beside surfaces: feet on the ground, a shoulder at a bush.
void MovingThings::Impl::attribute_hits_beside(const std::vector<NewHit>& hits) {
  bodies.clear();
  for (const FollowedThing& track : tracks) {
    if (!track.is_moving) continue;
    if (track.unseen_s(*stamp_ns) > 0.0) {
      bodies.push_back(track.expected_box(*stamp_ns));
      continue;
    }
    const geometry::Aabb reach = track.seen_box().padded(kReach_m);
    bodies.push_back(reach);
    for (const NewHit& hit : hits) {
      if (!hit.is_clear && reach.contains(hit.point.cast<double>())) moving_voxels.push_back(hit.voxel);
    }
  }
}

/// Decides whether a thing moves or stands, and lists its voxels accordingly.
void MovingThings::Impl::judge(FollowedThing* track, const LocalMap& map) {
  if (track->is_moving && track->stands(*stamp_ns, config.stands_after_s)) {
    track->is_moving = false;
    static_voxels.insert(static_voxels.end(), track->voxels.begin(), track->voxels.end());
  } else if (!track->is_moving && track->agrees_to_move(config, vehicle.velocity()) &&
             leaves_empty_space(*track, map)) {
    track->is_moving = true;
    moving_voxels.insert(moving_voxels.end(), track->voxels.begin(), track->voxels.end());
  }
}

void MovingThings::Impl::forget() {
  const auto is_over = [&](const FollowedThing& track) {
    return track.unseen_s(*stamp_ns) > (track.is_moving ? config.lost_after_s : kForgotten_s);
  };
  tracks.erase(std::remove_if(tracks.begin(), tracks.end(), is_over), tracks.end());
}

MovingThings::MovingThings(const MovingThingsConfig& config) : impl_(std::make_unique<Impl>(base::checked(config))) {}
MovingThings::~MovingThings() = default;
MovingThings::MovingThings(MovingThings&&) noexcept = default;
MovingThings& MovingThings::operator=(MovingThings&&) noexcept = default;

void MovingThings::update(LocalMap* map, base::StampNs stamp_ns, const geometry::Vec3& position) {
  Impl& impl = *impl_;
  if (!impl.config.is_enabled) return;
  if (impl.stamp_ns && stamp_ns < *impl.stamp_ns - base::from_seconds(kJump_s)) impl.clear();
  impl.stamp_ns = std::max(stamp_ns, impl.stamp_ns.value_or(stamp_ns));
  impl.vehicle.add(*impl.stamp_ns, position);
  impl.moving_voxels.clear();
  impl.static_voxels.clear();
  impl.follow(map->new_hits(), std::max(kCell_m, map->config().resolution_m));
  for (FollowedThing& track : impl.tracks) impl.judge(&track, *map);
  impl.attribute_hits_beside(map->new_hits());
  impl.forget();
  map->mark_moving(impl.moving_voxels);
  map->mark_static(impl.static_voxels);
  for (const geometry::Aabb& body : impl.bodies) map->mark_moving_in(body);
  map->take_back_moving(impl.bodies);
  impl.things.clear();
  for (const FollowedThing& track : impl.tracks) {
    if (track.is_moving) impl.things.push_back(track.thing_at(*impl.stamp_ns));
  }
}

const std::vector<MovingThing>& MovingThings::things() const { return impl_->things; }
void MovingThings::clear() { impl_->clear(); }
std::size_t MovingThings::num_not_followed() const { return impl_->num_not_followed; }

}  // namespace voxnav::occupancy
