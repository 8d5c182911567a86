// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/pipeline/mapper.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "pipeline/load_control.hpp"
#include "pipeline/map_clock.hpp"
#include "pipeline/sweep_queue.hpp"
#include "planning/other_uavs.hpp"
#include "voxnav/geometry/pose.hpp"
#include "voxnav/odometry/imu_gate.hpp"

namespace voxnav::pipeline {
namespace {

using geometry::Pose;

/// The mapper's own odometry gives one pose per sweep: one that is lost of a slow sensor leaves no gap.
constexpr double kMaxOwnPoseGap_s = 0.5;
/// Sweeps that may wait for the IMU to show where up is: four seconds at 20 Hz.
constexpr std::size_t kMaxUnlevel = 80;

/// Where others are is not known any more in sweeps that are this much newer than the newest news.
constexpr double kMaxNewsAge_s = 1.0;
/// A sweep at the usual 10 Hz. Of a longer one the part of a body that comes later may be mapped, which is safe.
constexpr base::StampNs kSweep_ns = 100'000'000;

std::string seconds(base::StampNs stamp_ns) { return std::to_string(base::to_seconds(stamp_ns)); }

}  // namespace

std::vector<std::string> MapperConfig::problems() const {
  std::vector<std::string> out;
  if (sensors.empty()) out.emplace_back("sensors must hold at least one");
  for (const SensorConfig& sensor : sensors) {
    for (const std::string& problem : base::problems_of(sensor)) out.push_back("sensors: " + problem);
  }
  return out;
}

struct Mapper::Impl {
  struct Mapped {
    base::StampNs stamp_ns;
    Pose T_O_B;
  };

  Impl(const MapperConfig& mapper_config, const Pose& T_B_L, const SweepLocator* other_locator);
  void track(cloud::Sweep sweep, double now_s);
  void track_ready(double now_s);
  SweepQueue& queue_of(std::size_t sensor);
  void push(WaitingSweep waiting);
  std::optional<std::size_t> next_sensor();
  void map_sweep(WaitingSweep* waiting, MapperStep* step);
  bool awaits_level() const;
  void level();
  void watch_jump(const geometry::Vec3& body, MapperStep* step);
  void clear(const std::string& text, MapperStep* step);
  std::vector<Handover> clear(const std::string& reason);
  void insert(cloud::Sweep* sweep, const SweepPoses& poses, MapperStep* step);
  std::vector<occupancy::BodyBall> bodies_at(base::StampNs begin_ns) const;

  MapperConfig config;
  occupancy::LocalMap map;
  occupancy::MovingThings moving;
  SubmapScheduler scheduler;
  LoadControl load;
  PoseLocator own_locator;
  SweepSettler settler;
  std::optional<odometry::LidarOdometry> odometry;
  odometry::ImuGate gate;
  std::vector<SweepQueue> queues;  // of each sensor
  bool expects_imu = false;
  MapClock clock;
  std::optional<geometry::Vec3> last_body;
  bool mapped_any = false;
  std::vector<containers::OtherUav> others;
  std::optional<Mapped> mapped;  // the sweep that close_due() is still to be asked for
};

Mapper::Impl::Impl(const MapperConfig& mapper_config, const Pose& T_B_L, const SweepLocator* other_locator)
    : config(base::checked(mapper_config)),
      map(config.map),
      moving(config.moving),
      scheduler(config.submap, config.first_submap_id),
      load(config.load),
      settler{other_locator ? other_locator : &own_locator, config.use_deskew},
      gate({config.odometry && config.odometry->use_imu}),
      clock(config.sensors.size()) {
  for (const SensorConfig& sensor : config.sensors) queues.emplace_back(sensor);
  own_locator.set_mount(T_B_L);
  own_locator.set_max_gap(
      base::from_seconds(std::max(config.max_pose_gap_s, config.odometry ? kMaxOwnPoseGap_s : 0.0)));
  if (config.odometry) odometry.emplace(*config.odometry, T_B_L, odometry::StampChecks::kByCaller);
}

void Mapper::Impl::track(cloud::Sweep sweep, double now_s) {
  const odometry::OdometryResult result = odometry->add_sweep(sweep);
  if (result.is_new && result.quality.state == odometry::OdometryState::kCoasting) scheduler.request_close("odometry");
  // Before odometry has a map there is no pose to speak of.
  if (result.is_new && odometry->num_map_voxels() > 0)
    own_locator.add(result.stamp_ns, geometry::as_sent(result.T_O_B));
  push({std::move(sweep), std::nullopt, now_s, std::nullopt});
  level();
}

/// Whether poses are still given in a frame that will be turned upright. Sweeps wait for that, unless too many of the
/// sensor do that tells the poses.
bool Mapper::Impl::awaits_level() const {
  return expects_imu && odometry && odometry->num_map_voxels() > 0 && !odometry->is_level() && !mapped_any &&
         queues.front().size() <= kMaxUnlevel;
}

/// Turns the frame of the odometry upright as soon as the IMU shows where up is, as long as nothing is mapped in it.
void Mapper::Impl::level() {
  if (!odometry || mapped_any) return;
  const auto T_new_O = odometry->level(settler.has_ended);
  if (!T_new_O) return;
  own_locator.move_frame(*T_new_O);
  for (SweepQueue& queue : queues) queue.forget_poses();
}

void Mapper::Impl::track_ready(double now_s) {
  while (auto sweep = gate.next(now_s)) track(std::move(*sweep), now_s);
}

SweepQueue& Mapper::Impl::queue_of(std::size_t sensor) {
  if (sensor < queues.size()) return queues[sensor];
  throw std::invalid_argument("there is no sensor " + std::to_string(sensor) + ", but " +
                              std::to_string(queues.size()));
}

void Mapper::Impl::push(WaitingSweep waiting) {
  SweepQueue& queue = queues[waiting.sweep.sensor];
  queue.push(std::move(waiting));
  const auto max_pending = static_cast<std::size_t>(config.max_pending_scans);
  if (queue.size() <= max_pending || (awaits_level() && queue.size() <= kMaxUnlevel)) return;
  queue.limit(max_pending, settler);
}

/// Returns the sensor whose oldest sweep is ready; if there are several, the one whose sweep began first.
std::optional<std::size_t> Mapper::Impl::next_sensor() {
  std::optional<std::size_t> out;
  for (std::size_t i = 0; i < queues.size(); ++i) {
    if (queues[i].empty()) continue;
    WaitingSweep& oldest = queues[i].front();
    if (!settler.has_ended && !oldest.drop && awaits_level()) continue;
    settler.settle(&oldest);
    if (oldest.is_settled() && (!out || oldest.sweep.start_ns < queues[*out].front().sweep.start_ns)) out = i;
  }
  return out;
}

/// Only when time jumped back, which the sweeps after have confirmed, is the map of the future forgotten.
void Mapper::Impl::map_sweep(WaitingSweep* waiting, MapperStep* step) {
  const base::StampNs start_ns = waiting->sweep.start_ns;
  const std::optional<base::StampNs> newest_ns = clock.newest_ns();
  const MapClock::Verdict verdict = clock.add(step->sensor, start_ns);
  if (verdict == MapClock::Verdict::kBehindOthers) {
    step->fate = SweepFate::kLate;
    step->reason = "its stamp is " + seconds(*newest_ns - start_ns) + " s behind those of the other sensors";
    return;
  }
  if (verdict == MapClock::Verdict::kJumpedBack)
    clear("time jumped back from " + seconds(*newest_ns) + " to " + seconds(start_ns), step);
  step->leads = clock.leads(step->sensor, start_ns);
  watch_jump(waiting->poses->T_O_B.translation(), step);
  insert(&waiting->sweep, *waiting->poses, step);
}

void Mapper::Impl::watch_jump(const geometry::Vec3& body, MapperStep* step) {
  const double jump_m = last_body ? (body - *last_body).norm() : 0.0;
  if (jump_m > config.max_jump_m) clear("the pose jumped by " + std::to_string(jump_m) + " m", step);
  last_body = body;
}

void Mapper::Impl::clear(const std::string& text, MapperStep* step) {
  for (Handover& handover : clear("odometry")) step->handovers.push_back(std::move(handover));
  step->map_cleared = text;
}

std::vector<Handover> Mapper::Impl::clear(const std::string& reason) {
  std::vector<Handover> out = scheduler.finish(&map, reason);
  map.clear();
  moving.clear();
  last_body.reset();
  mapped.reset();
  return out;
}

void Mapper::Impl::insert(cloud::Sweep* sweep, const SweepPoses& poses, MapperStep* step) {
  if (load.decimation() > 1) {
    load.thin_out(1, &sweep->points);
    load.thin_out(1, &sweep->time_offsets_ns);
  }
  float* first = sweep->points.empty() ? nullptr : sweep->points.front().data();
  deskew({first, sweep->points.size(), 3}, sweep->time_offsets_ns, poses.motion);
  const SensorConfig& sensor = queues[sweep->sensor].config();
  map.set_bodies(bodies_at(sweep->start_ns));
  step->statistics =
      map.insert(geometry::view_of(sweep->points), middle_of(poses.motion), geometry::view_of(sweep->open_beams),
                 {sensor.max_range_m, sensor.no_return_range_m, sensor.range_noise_m});
  moving.update(&map, sweep->stamp_ns, poses.T_O_B.translation());
  if (config.vehicle_radius_m > 0.0) map.mark_free(poses.T_O_B.translation(), config.vehicle_radius_m);
  step->T_O_B = poses.T_O_B;
  mapped_any = true;
  if (step->leads) mapped = {sweep->start_ns, poses.T_O_B};
}

/// A body moves during a sweep, so its ball holds both ends of its way.
std::vector<occupancy::BodyBall> Mapper::Impl::bodies_at(base::StampNs begin_ns) const {
  const base::StampNs end_ns = begin_ns + kSweep_ns;
  std::vector<occupancy::BodyBall> out;
  for (const containers::OtherUav& other : others) {
    if (other.radius_m <= 0.0 || std::abs(base::to_seconds(end_ns - other.seen_ns)) > kMaxNewsAge_s) continue;
    const geometry::Vec3 from = planning::place_at(other, begin_ns), to = planning::place_at(other, end_ns);
    out.push_back({0.5 * (from + to), other.radius_m + 0.5 * (to - from).norm()});
  }
  return out;
}

Mapper::Mapper(const MapperConfig& config, const Pose& T_B_L, const SweepLocator* locator)
    : impl_(std::make_unique<Impl>(config, T_B_L, locator)) {}

Mapper::~Mapper() = default;

void Mapper::add_imu(const odometry::ImuSample& sample) {
  if (!impl_->odometry) return;
  if (impl_->odometry->add_imu(sample)) impl_->gate.note_imu(sample.stamp_ns);
  impl_->track_ready(0.0);
}

bool Mapper::add_pose(base::StampNs stamp_ns, const Pose& T_O_B) { return impl_->own_locator.add(stamp_ns, T_O_B); }

void Mapper::set_mount(std::size_t sensor, const Pose& T_B_L) {
  impl_->queue_of(sensor);
  impl_->own_locator.set_mount(T_B_L, sensor);
}

void Mapper::add_sweep(cloud::Sweep sweep, const std::optional<SweepPoses>& poses, double now_s) {
  if (const auto problem = impl_->queue_of(sweep.sensor).stamps().refuse(sweep.start_ns, poses.has_value())) {
    impl_->push({std::move(sweep), std::nullopt, now_s, WaitingSweep::Drop{SweepFate::kLate, *problem}});
  } else if (poses || !impl_->odometry || sweep.sensor != 0) {
    impl_->push({std::move(sweep), poses, now_s, std::nullopt});
  } else {
    impl_->gate.add(std::move(sweep), 0.0);
    impl_->track_ready(0.0);
  }
}

void Mapper::set_others(std::vector<containers::OtherUav> others) {
  for (const containers::OtherUav& other : others) planning::require_valid(other);
  impl_->others = std::move(others);
}

void Mapper::drop_overdue(double now_s, double timeout_s) {
  for (SweepQueue& queue : impl_->queues) queue.drop_overdue(now_s, timeout_s, impl_->settler);
}

void Mapper::end_input() {
  impl_->settler.has_ended = true;
  while (auto sweep = impl_->gate.take_oldest()) impl_->track(std::move(*sweep), 0.0);
  impl_->level();
}

void Mapper::expect_imu() { impl_->expects_imu = impl_->config.odometry && impl_->config.odometry->use_imu; }

bool Mapper::is_waiting_for_imu() const { return !impl_->gate.empty(); }

bool Mapper::has_next() { return impl_->next_sensor().has_value(); }

MapperStep Mapper::next() {
  const std::optional<std::size_t> sensor = impl_->next_sensor();
  if (!sensor) throw std::logic_error("Mapper::next(): no sweep is ready");
  WaitingSweep oldest = impl_->queues[*sensor].pop();
  MapperStep step;
  step.stamp_ns = oldest.sweep.stamp_ns;
  step.sensor = *sensor;
  impl_->mapped.reset();
  if (oldest.drop) {
    step.fate = oldest.drop->fate;
    step.reason = oldest.drop->reason;
  } else {
    impl_->map_sweep(&oldest, &step);
  }
  return step;
}

std::vector<Handover> Mapper::close_due() {
  if (!impl_->mapped) return {};
  const Impl::Mapped scan = *std::exchange(impl_->mapped, std::nullopt);
  return impl_->scheduler.add_scan(&impl_->map, scan.stamp_ns, scan.T_O_B);
}

std::vector<Handover> Mapper::finish(const std::string& reason) { return impl_->scheduler.finish(&impl_->map, reason); }

void Mapper::request_close(const std::string& reason) { impl_->scheduler.request_close(reason); }

std::vector<Handover> Mapper::clear(const std::string& reason) { return impl_->clear(reason); }

void Mapper::add_load(double work_s, double period_s) { impl_->load.add(work_s, period_s); }

int Mapper::decimation() const { return impl_->load.decimation(); }

occupancy::LocalMap& Mapper::map() { return impl_->map; }

const occupancy::LocalMap& Mapper::map() const { return impl_->map; }

const occupancy::MovingThings& Mapper::moving() const { return impl_->moving; }

std::optional<base::StampNs> Mapper::newest_stamp_ns() const { return impl_->clock.newest_ns(); }

std::vector<std::string> Mapper::odometry_problems() const {
  return impl_->odometry ? impl_->odometry->problems() : std::vector<std::string>();
}

const odometry::LidarOdometry* Mapper::odometry() const { return impl_->odometry ? &*impl_->odometry : nullptr; }

}  // namespace voxnav::pipeline
