// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/pipeline/mapper.hpp"

#include <algorithm>
#include <deque>
#include <stdexcept>
#include <utility>

#include "pipeline/load_control.hpp"
#include "pipeline/sweep_stamps.hpp"
#include "voxnav/geometry/pose.hpp"
#include "voxnav/odometry/imu_gate.hpp"

namespace voxnav::pipeline {
namespace {

using geometry::Pose;

/// The mapper's own odometry gives one pose per sweep: one that is lost of a slow sensor leaves no gap.
constexpr double kMaxOwnPoseGap_s = 0.5;
/// Sweeps that may wait for the IMU to show where up is: four seconds at 20 Hz.
constexpr std::size_t kMaxUnlevel = 80;

std::string seconds(base::StampNs stamp_ns) { return std::to_string(base::to_seconds(stamp_ns)); }

}  // namespace

struct Mapper::Impl {
  struct Drop {
    SweepFate fate;
    std::string reason;
  };
  struct Waiting {
    cloud::Sweep sweep;
    std::optional<SweepPoses> poses;
    double since_s = 0.0;
    std::optional<Drop> drop;
  };
  struct Mapped {
    base::StampNs stamp_ns;
    Pose T_O_B;
  };

  Impl(const MapperConfig& mapper_config, const Pose& T_B_L, const SweepLocator* other_locator);
  void track(cloud::Sweep sweep, double now_s);
  void track_ready(double now_s);
  void push(Waiting item);
  void settle(Waiting* item) const;
  void watch_clock(base::StampNs stamp_ns, MapperStep* step);
  bool awaits_level() const;
  void level();
  void watch_jump(const geometry::Vec3& body, MapperStep* step);
  void clear(const std::string& text, MapperStep* step);
  std::vector<Handover> clear(const std::string& reason);
  void insert(cloud::Sweep* sweep, const SweepPoses& poses, MapperStep* step);

  MapperConfig config;
  occupancy::LocalMap map;
  SubmapScheduler scheduler;
  LoadControl load;
  PoseLocator own_locator;
  const SweepLocator* locator;
  std::optional<odometry::LidarOdometry> odometry;
  odometry::ImuGate gate;
  std::deque<Waiting> waiting;
  bool has_ended = false;
  bool expects_imu = false;
  SweepStamps stamps;
  std::optional<base::StampNs> newest_ns;
  std::optional<geometry::Vec3> last_body;
  bool mapped_any = false;
  std::optional<Mapped> mapped;  // the sweep that close_due() is still to be asked for
};

Mapper::Impl::Impl(const MapperConfig& mapper_config, const Pose& T_B_L, const SweepLocator* other_locator)
    : config(base::checked(mapper_config)),
      map(config.map),
      scheduler(config.submap, config.first_submap_id),
      load(config.load),
      locator(other_locator ? other_locator : &own_locator),
      gate({config.odometry && config.odometry->use_imu}) {
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

/// Whether poses are still given in a frame that will be turned upright. Sweeps wait for that, unless too many do.
bool Mapper::Impl::awaits_level() const {
  return expects_imu && odometry && odometry->num_map_voxels() > 0 && !odometry->is_level() && !mapped_any &&
         waiting.size() <= kMaxUnlevel;
}

/// Turns the frame of the odometry upright as soon as the IMU shows where up is, as long as nothing is mapped in it.
void Mapper::Impl::level() {
  if (!odometry || mapped_any) return;
  const auto T_new_O = odometry->level(has_ended);
  if (!T_new_O) return;
  own_locator.move_frame(*T_new_O);
  for (Waiting& item : waiting) item.poses.reset();
}

void Mapper::Impl::track_ready(double now_s) {
  while (auto sweep = gate.next(now_s)) track(std::move(*sweep), now_s);
}

void Mapper::Impl::push(Waiting item) {
  waiting.push_back(std::move(item));
  if (waiting.size() <= static_cast<std::size_t>(config.max_pending_scans) || awaits_level()) return;
  Waiting* oldest = nullptr;
  int num_without_pose = 0;
  for (Waiting& each : waiting) {
    settle(&each);
    if (each.poses || each.drop) continue;
    if (!oldest) oldest = &each;
    ++num_without_pose;
  }
  if (num_without_pose <= config.max_pending_scans) return;
  oldest->drop = Drop{SweepFate::kCrowded, "more scans wait for their pose than max_pending_scans"};
}

/// Asks for the poses of a sweep that has none; gives it up when there will be none.
void Mapper::Impl::settle(Waiting* item) const {
  if (item->poses || item->drop) return;
  SweepLocation found = locator->locate(item->sweep, config.use_deskew ? item->sweep.duration_ns : 0);
  if (found.status == SweepLocation::Status::kKnown) {
    item->poses = found.poses;
  } else if (found.status == SweepLocation::Status::kNever || has_ended) {
    item->drop = Drop{SweepFate::kNoPose, "there is no pose for it: " + found.problem};
  }
}

/// Only when time jumped back, which the sweeps after have confirmed, is the map of the future forgotten.
void Mapper::Impl::watch_clock(base::StampNs stamp_ns, MapperStep* step) {
  if (newest_ns && stamp_ns < *newest_ns - kMaxStampLagNs) {
    clear("time jumped back from " + seconds(*newest_ns) + " to " + seconds(stamp_ns), step);
  }
  newest_ns = stamp_ns;
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
  step->statistics =
      map.insert(geometry::view_of(sweep->points), middle_of(poses.motion), geometry::view_of(sweep->open_beams));
  if (config.vehicle_radius_m > 0.0) map.mark_free(poses.T_O_B.translation(), config.vehicle_radius_m);
  step->T_O_B = poses.T_O_B;
  mapped_any = true;
  mapped = {sweep->start_ns, poses.T_O_B};
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

void Mapper::add_sweep(cloud::Sweep sweep, const std::optional<SweepPoses>& poses, double now_s) {
  if (const auto problem = impl_->stamps.refuse(sweep.start_ns, poses.has_value())) {
    impl_->push({std::move(sweep), std::nullopt, now_s, Impl::Drop{SweepFate::kLate, *problem}});
  } else if (poses || !impl_->odometry) {
    impl_->push({std::move(sweep), poses, now_s, std::nullopt});
  } else {
    impl_->gate.add(std::move(sweep), 0.0);
    impl_->track_ready(0.0);
  }
}

void Mapper::drop_overdue(double now_s, double timeout_s) {
  for (Impl::Waiting& item : impl_->waiting) {
    impl_->settle(&item);
    if (item.poses || item.drop || now_s - item.since_s <= timeout_s) continue;
    const std::string problem = impl_->locator->locate(item.sweep, item.sweep.duration_ns).problem;
    item.drop = Impl::Drop{SweepFate::kNoPose, "no pose within " + std::to_string(timeout_s) + " s: " + problem};
  }
}

void Mapper::end_input() {
  impl_->has_ended = true;
  while (auto sweep = impl_->gate.take_oldest()) impl_->track(std::move(*sweep), 0.0);
  impl_->level();
}

void Mapper::expect_imu() { impl_->expects_imu = impl_->config.odometry && impl_->config.odometry->use_imu; }

bool Mapper::is_waiting_for_imu() const { return !impl_->gate.empty(); }

bool Mapper::has_next() {
  if (impl_->waiting.empty()) return false;
  Impl::Waiting& oldest = impl_->waiting.front();
  if (!impl_->has_ended && !oldest.drop && impl_->awaits_level()) return false;
  impl_->settle(&oldest);
  return oldest.poses || oldest.drop;
}

MapperStep Mapper::next() {
  if (!has_next()) throw std::logic_error("Mapper::next(): no sweep is ready");
  Impl::Waiting oldest = std::move(impl_->waiting.front());
  impl_->waiting.pop_front();
  MapperStep step;
  step.stamp_ns = oldest.sweep.stamp_ns;
  impl_->mapped.reset();
  if (oldest.drop) {
    step.fate = oldest.drop->fate;
    step.reason = oldest.drop->reason;
  } else {
    impl_->watch_clock(oldest.sweep.start_ns, &step);
    impl_->watch_jump(oldest.poses->T_O_B.translation(), &step);
    impl_->insert(&oldest.sweep, *oldest.poses, &step);
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

std::optional<base::StampNs> Mapper::newest_stamp_ns() const { return impl_->newest_ns; }

std::vector<std::string> Mapper::odometry_problems() const {
  return impl_->odometry ? impl_->odometry->problems() : std::vector<std::string>();
}

const odometry::LidarOdometry* Mapper::odometry() const { return impl_->odometry ? &*impl_->odometry : nullptr; }

}  // namespace voxnav::pipeline
