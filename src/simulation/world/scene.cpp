// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav_simulation/scene.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

#include "scene_part.hpp"

namespace voxnav_simulation {
namespace {

constexpr std::size_t kPacket = 8;

/// Fills a packet with rays from one origin. Lanes beyond `count` repeat the last ray.
void fill_packet(const Vec3f& origin, const Vec3f* directions, std::size_t count, float max_range_m, RTCRayHit8* p) {
  for (std::size_t i = 0; i < kPacket; ++i) {
    const Vec3f& d = directions[std::min(i, count - 1)];
    p->ray.org_x[i] = origin.x();
    p->ray.org_y[i] = origin.y();
    p->ray.org_z[i] = origin.z();
    p->ray.dir_x[i] = d.x();
    p->ray.dir_y[i] = d.y();
    p->ray.dir_z[i] = d.z();
    p->ray.tnear[i] = 0.0F;
    p->ray.tfar[i] = max_range_m;
    p->ray.time[i] = 0.0F;
    p->ray.mask[i] = 0xFFFFFFFFU;
    p->ray.id[i] = 0;
    p->ray.flags[i] = 0;
    p->hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
    p->hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
  }
}

}  // namespace

Scene::Scene(World world) : world_(std::move(world)), device_(std::make_shared<Device>()) {
  static_part_ = std::make_shared<Part>(device_, world_.mesh(), Pose::Identity());
  const WorldConfig& config = world_.config();
  if (config.has_vehicle) {
    move_vehicle(config.vehicle_position_m[0], config.vehicle_position_m[1], config.vehicle_heading_rad);
  }
}

Scene::~Scene() = default;

std::shared_ptr<const Scene::Part> Scene::vehicle() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return vehicle_;
}

void Scene::cast(const Vec3f& origin, const Vec3f* directions, std::size_t count, float max_range_m, Hit* hits,
                 std::optional<StampNs> at_ns) const {
  const std::shared_ptr<const Part> vehicle_part = vehicle();
  for (std::size_t first = 0; first < count; first += kPacket) {
    const std::size_t lanes = std::min(kPacket, count - first);
    alignas(32) int valid[kPacket];
    for (std::size_t i = 0; i < kPacket; ++i) valid[i] = i < lanes ? -1 : 0;
    alignas(32) RTCRayHit8 packet;
    fill_packet(origin, directions + first, lanes, max_range_m, &packet);
    std::fill(hits + first, hits + first + lanes, Hit{});
    static_part_->cast(&packet, valid, hits + first, lanes);
    if (vehicle_part) vehicle_part->cast(&packet, valid, hits + first, lanes);
  }
  if (!at_ns) return;
  if (moving_at(*at_ns).empty()) return;
  const auto is_too_far = [max_range_m](const Hit& hit) { return hit.range_m > max_range_m; };
  cast_at_movers(origin, directions, count, *at_ns, hits);
  std::replace_if(hits, hits + count, is_too_far, Hit{});
}

std::vector<std::pair<const Mover*, Vec3>> Scene::moving_at(StampNs at_ns) const {
  std::vector<std::pair<const Mover*, Vec3>> out = visitors_.at(at_ns);
  for (const Mover& mover : world_.movers()) out.emplace_back(&mover, mover.at(at_ns));
  return out;
}

/// Shortens rays to the movers that they meet.
void Scene::cast_at_movers(const Vec3f& origin, const Vec3f* directions, std::size_t count, StampNs at_ns,
                           Hit* hits) const {
  const Vec3 from = origin.cast<double>();
  for (const auto& [shape, bottom] : moving_at(at_ns)) {
    const Mover& mover = *shape;
    // Rays that pass the sphere around the mover need no closer look.
    const Vec3 towards = bottom + Vec3(0, 0, 0.5 * mover.height_m) - from;
    const double reach_m = std::hypot(mover.radius_m, 0.5 * mover.height_m);
    for (std::size_t i = 0; i < count; ++i) {
      const Vec3 direction = directions[i].cast<double>();
      if (towards.squaredNorm() - std::pow(towards.dot(direction), 2) > reach_m * reach_m) continue;
      const auto hit = cast_at_cylinder(mover, bottom, from, direction);
      if (!hit || static_cast<float>(hit->range_m) >= hits[i].range_m) continue;
      hits[i] = {static_cast<float>(hit->range_m), static_cast<float>(hit->cos_incidence), mover.surface_class};
    }
  }
}

bool Scene::move_vehicle(double x, double y, double heading_rad) {
  const std::optional<Pose> pose = world_.vehicle_pose(x, y, heading_rad);
  if (!pose || world_.vehicle_mesh().triangles.empty()) return false;
  auto moved = std::make_shared<Part>(device_, world_.vehicle_mesh(), *pose);
  const std::lock_guard<std::mutex> lock(mutex_);
  vehicle_ = std::move(moved);
  return true;
}

std::optional<Pose> Scene::vehicle_pose() const {
  const std::shared_ptr<const Part> part = vehicle();
  if (!part) return std::nullopt;
  return part->T_W_part;
}

std::optional<Nearest> Scene::nearest(const Vec3& p, double max_m, std::optional<StampNs> at_ns) const {
  // Comparisons with NaN are false, so that without this check the result would be "no surface near", and a collision
  // monitor would believe it.
  if (!p.allFinite() || !(max_m >= 0.0)) throw std::invalid_argument("nearest surface of a point that is not finite");
  std::optional<Nearest> best = static_part_->nearest(p, max_m);
  if (const std::shared_ptr<const Part> part = vehicle()) {
    const std::optional<Nearest> other = part->nearest(p, best ? best->distance_m : max_m);
    if (other) best = other;
  }
  if (!at_ns) return best;
  for (const auto& [mover, bottom] : moving_at(*at_ns)) {
    const double distance_m = distance_to_cylinder(*mover, bottom, p);
    if (distance_m < (best ? best->distance_m : max_m)) best = Nearest{distance_m, mover->surface_class};
  }
  return best;
}

double Scene::clearance(const Vec3& p, double max_m, std::optional<StampNs> at_ns) const {
  const std::optional<Nearest> found = nearest(p, max_m, at_ns);
  return found ? std::min(found->distance_m, max_m) : max_m;
}

std::shared_ptr<Scene> shared_scene(const std::string& world_yaml_path, std::uint64_t seed) {
  static std::mutex mutex;
  static std::map<std::pair<std::string, std::uint64_t>, std::weak_ptr<Scene>> scenes;
  const std::lock_guard<std::mutex> lock(mutex);
  std::weak_ptr<Scene>& known = scenes[{world_yaml_path, seed}];
  std::shared_ptr<Scene> scene = known.lock();
  if (!scene) {
    scene = std::make_shared<Scene>(World(load_world_config(world_yaml_path), seed));
    known = scene;
  }
  return scene;
}

}  // namespace voxnav_simulation
