// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/cloud/cloud_filter.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "cloud_reader.hpp"

namespace voxnav::cloud {
namespace {

using Verdict = CloudFilter::Verdict;

/// Pixels around one, in the order in which neighbours are likely: most returns need to look at two of them only.
/// Source of the rule that a return needs neighbours within a distance that grows with its range: Charron, Phillips and
/// Waslander, "De-noising of lidar point clouds corrupted by snowfall", CRV 2018, section III (DROR).
constexpr std::array<std::array<int, 2>, 14> kNearestFirst{{{0, -1},
                                                            {0, 1},
                                                            {-1, 0},
                                                            {1, 0},
                                                            {-1, -1},
                                                            {-1, 1},
                                                            {1, -1},
                                                            {1, 1},
                                                            {0, -2},
                                                            {0, 2},
                                                            {-1, -2},
                                                            {-1, 2},
                                                            {1, -2},
                                                            {1, 2}}};

float squared(double value) { return static_cast<float>(value * value); }

std::array<float, 3> to_float(const std::array<double, 3>& v) {
  return {static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2])};
}

double norm(double x, double y, double z) { return std::sqrt(x * x + y * y + z * z); }

/// Beyond this range nothing but the far limit and ghosts has to be tested.
double clear_range(const CloudFilterConfig& c) {
  double range = c.min_range_m;
  if (c.body_radius_m > 0) {
    range = std::max(range, norm(c.body_center_m[0], c.body_center_m[1], c.body_center_m[2]) + c.body_radius_m);
  }
  if (!c.use_body_box) return range;
  double corner[3];
  for (std::size_t i = 0; i < 3; ++i)
    corner[i] = std::max(std::abs(c.body_box_min_m[i]), std::abs(c.body_box_max_m[i]));
  return std::max(range, norm(corner[0], corner[1], corner[2]));
}

void count(Verdict verdict, FilterCounts* counts) {
  switch (verdict) {
    case Verdict::kNan:
      ++counts->nan;
      break;
    case Verdict::kZero:
      ++counts->zero;
      break;
    case Verdict::kBody:
      ++counts->body;
      break;
    case Verdict::kNear:
      ++counts->near;
      break;
    default:
      break;  // kept, far and ghosts are counted by the lists they go to
  }
}

/// Makes offsets count from the earliest point, for drivers whose stamp is not the start of the sweep.
void shift_times(std::int64_t first_ns, std::vector<Point>* points) {
  for (Point& p : *points) p.time_offset_ns -= static_cast<std::uint32_t>(first_ns);
}

}  // namespace

std::array<std::pair<const char*, std::uint64_t>, 10> FilterCounts::reasons() const {
  return {{{"decimated", decimated},
           {"nan", nan},
           {"zero", zero},
           {"body", body},
           {"near", near},
           {"far", far},
           {"ghost", ghost},
           {"outlier", outlier},
           {"pcl", pcl},
           {"kept", kept}}};
}

FilterCounts& FilterCounts::operator+=(const FilterCounts& o) {
  total += o.total;
  decimated += o.decimated;
  nan += o.nan;
  zero += o.zero;
  body += o.body;
  near += o.near;
  far += o.far;
  ghost += o.ghost;
  outlier += o.outlier;
  pcl += o.pcl;
  kept += o.kept;
  return *this;
}

CloudFilter::CloudFilter(const CloudFilterConfig& config)
    : config_(base::checked(config)), limits_(limits_of(config)) {}

void CloudFilter::set_body_mask(BodyMask mask) {
  body_mask_ = std::move(mask);
  has_body_mask_ = body_mask_.num_covered() > 0;
  limits_ = limits_of(config_);
  limits_.clear_sq = std::max(limits_.clear_sq, squared(body_mask_.farthest_m() * 1.001 + 1e-6));
}

CloudFilter::Limits CloudFilter::limits_of(const CloudFilterConfig& c) {
  Limits out;
  // A margin against rounding: the exact tests behind the clear range decide.
  out.clear_sq = squared(clear_range(c) * 1.001 + 1e-6);
  out.far_sq = squared(c.max_range_m);
  out.near_sq = squared(c.min_range_m);
  out.ghost_sq = squared(c.ghost_range_m);
  out.ghost_intensity = static_cast<float>(c.ghost_intensity);
  out.center = to_float(c.body_center_m);
  out.body_sq = squared(c.body_radius_m);
  out.box_min = to_float(c.body_box_min_m);
  out.box_max = to_float(c.body_box_max_m);
  return out;
}

CloudFilter::Verdict CloudFilter::judge_near_or_odd(float x, float y, float z, float range_sq) const {
  if (!std::isfinite(x) || !std::isfinite(y) || !std::isfinite(z)) return Verdict::kNan;
  if (x == 0.0F && y == 0.0F && z == 0.0F) return Verdict::kZero;
  const Limits& l = limits_;
  const float dx = x - l.center[0], dy = y - l.center[1], dz = z - l.center[2];
  if (dx * dx + dy * dy + dz * dz < l.body_sq) return Verdict::kBody;
  const bool is_in_box = x >= l.box_min[0] && x <= l.box_max[0] && y >= l.box_min[1] && y <= l.box_max[1] &&
                         z >= l.box_min[2] && z <= l.box_max[2];
  if (config_.use_body_box && is_in_box) return Verdict::kBody;
  if (has_body_mask_ && body_mask_.covers(x, y, z)) return Verdict::kBody;
  if (range_sq < l.near_sq) return Verdict::kNear;
  return range_sq > l.far_sq ? Verdict::kFar : Verdict::kKept;
}

void CloudFilter::begin(const RawCloudView& cloud, FilterResult* result) {
  const bool organised = cloud.is_organised();
  row_step_ = organised ? static_cast<std::uint32_t>(config_.row_decimation) : 1;
  column_step_ = static_cast<std::uint32_t>(organised ? config_.column_decimation : config_.unorganised_decimation);
  first_row_ = config_.cycle_decimation ? static_cast<std::uint32_t>(num_clouds_ % row_step_) : 0;
  // Columns move on when the rows have gone round, so that every pixel gets its turn.
  first_column_ = config_.cycle_decimation ? static_cast<std::uint32_t>(num_clouds_ / row_step_ % column_step_) : 0;
  // A phase beyond the cloud would drop all of it.
  if (first_row_ >= cloud.height()) first_row_ = 0;
  if (first_column_ >= cloud.width()) first_column_ = 0;
  ++num_clouds_;
  result->ghosts.clear();
  result->far.clear();
  result->counts = FilterCounts();
  result->counts.total = cloud.num_points();
  result->sweep_start_ns = 0;
  result->num_bad_times = 0;
  result->is_ghost_filter_suspended = result->is_outlier_filter_suspended = false;
  grid_rows_ = grid_columns_ = 0;
  pixel_of_.clear();
  ghost_pixel_of_.clear();
}

template <class Reader>
void CloudFilter::pass(const RawCloudView& cloud, FilterResult* result) {
  if (limits_.ghost_intensity > 0.0F && cloud.access().intensity) {
    pass_rows<Reader, true>(cloud, result);
  } else {
    pass_rows<Reader, false>(cloud, result);
  }
}

template <class Reader, bool kMayHaveGhosts>
void CloudFilter::pass_rows(const RawCloudView& cloud, FilterResult* result) {
  const Reader read(cloud.access());
  TimeReader time(cloud.access(), cloud_times_);
  FilterCounts& counts = result->counts;
  const Limits limits = limits_;
  const std::uint32_t used_columns = (cloud.width() - first_column_ + column_step_ - 1) / column_step_;
  const std::size_t stride = static_cast<std::size_t>(column_step_) * cloud.point_step();
  const bool keep_pixels = config_.remove_outliers && cloud.is_organised();
  std::uint64_t num_examined = 0;
  // Written by index into room for every point: the loop holds no growth check, and only what the previous
  // result did not fill is initialised.
  result->points.resize(cloud.num_points());
  Point* out = result->points.data();
  for (std::uint32_t r = first_row_; r < cloud.height(); r += row_step_) {
    const std::uint8_t* p = cloud.row(r) + static_cast<std::size_t>(first_column_) * cloud.point_step();
    for (std::uint32_t c = 0; c < used_columns; ++c, p += stride) {
      float v[3];
      read.position(p, v);
      const float range_sq = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
      // NaN fails this comparison too.
      if (!(range_sq > limits.clear_sq && range_sq <= limits.far_sq)) {
        const Verdict verdict = judge_near_or_odd(v[0], v[1], v[2], range_sq);
        if (verdict == Verdict::kFar) {
          result->far.push_back({v[0], v[1], v[2], read.intensity(p), time(p)});
          continue;
        }
        if (verdict != Verdict::kKept) {
          count(verdict, &counts);
          continue;
        }
      }
      *out = {v[0], v[1], v[2], read.intensity(p), time(p)};
      if (kMayHaveGhosts && out->intensity < limits.ghost_intensity && range_sq < limits.ghost_sq) {
        result->ghosts.push_back(*out);
        if (keep_pixels) ghost_pixel_of_.push_back(grid_rows_ * used_columns + c);
        continue;
      }
      if (keep_pixels) pixel_of_.push_back(grid_rows_ * used_columns + c);
      ++out;
    }
    num_examined += used_columns;
    ++grid_rows_;
  }
  result->points.resize(static_cast<std::size_t>(out - result->points.data()));
  grid_columns_ = used_columns;
  counts.decimated = counts.total - num_examined;
  result->num_bad_times = time.num_bad();
  result->sweep_start_ns = time.min_ns();
}

void CloudFilter::restore_unjudged_ghosts(FilterResult* result) {
  if (result->ghosts.empty()) return;
  const auto has_intensity = [](const Point& p) { return p.intensity > 0.0F; };
  const bool any = std::any_of(result->points.begin(), result->points.end(), has_intensity) ||
                   std::any_of(result->ghosts.begin(), result->ghosts.end(), has_intensity);
  if (any) return;
  result->is_ghost_filter_suspended = true;
  result->points.insert(result->points.end(), result->ghosts.begin(), result->ghosts.end());
  result->ghosts.clear();
  pixel_of_.insert(pixel_of_.end(), ghost_pixel_of_.begin(), ghost_pixel_of_.end());
}

bool CloudFilter::has_neighbours(std::size_t point, const std::vector<Point>& points) const {
  const Point& p = points[point];
  const float range = std::sqrt(p.x * p.x + p.y * p.y + p.z * p.z);
  const auto reach = static_cast<float>(config_.outlier_distance_m + config_.outlier_range_ratio * range);
  const auto row = static_cast<std::int64_t>(pixel_of_[point] / grid_columns_);
  const auto column = static_cast<std::int64_t>(pixel_of_[point] % grid_columns_);
  int found = 0;
  for (const auto& [down, right] : kNearestFirst) {
    const std::int64_t r = row + down;
    if (r < 0 || r >= grid_rows_) continue;
    // Sweeps close on themselves: the first column is the neighbour of the last.
    const std::int64_t c = (column + right + std::int64_t{grid_columns_} * 2) % grid_columns_;
    const std::int32_t other = grid_[static_cast<std::size_t>(r * grid_columns_ + c)];
    if (other < 0 || static_cast<std::size_t>(other) == point) continue;
    const Point& q = points[static_cast<std::size_t>(other)];
    const float dx = p.x - q.x, dy = p.y - q.y, dz = p.z - q.z;
    if (dx * dx + dy * dy + dz * dz <= reach * reach && ++found >= config_.outlier_min_neighbours) return true;
  }
  return false;
}

/// Tells whether neighbours in the image are neighbours in space, as of a sensor whose beams are close to each other
/// and in order. Most returns of one cloud, near and far, show it for all that follow: later clouds may consist of
/// little but rain.
bool CloudFilter::knows_image(const std::vector<Point>& points) {
  constexpr std::size_t kNumAsked = 1000, kFewest = 20;
  if (knows_image_) return true;
  const std::size_t step = std::max<std::size_t>(1, pixel_of_.size() / kNumAsked);
  std::size_t num_asked = 0, num_lone = 0;
  for (std::size_t i = 0; i < pixel_of_.size(); i += step, ++num_asked) num_lone += has_neighbours(i, points) ? 0 : 1;
  knows_image_ = num_asked >= kFewest && 2 * num_lone < num_asked;
  return knows_image_;
}

void CloudFilter::remove_outliers(FilterResult* result) {
  std::vector<Point>& points = result->points;
  grid_.assign(static_cast<std::size_t>(grid_rows_) * grid_columns_, -1);
  for (std::size_t i = 0; i < pixel_of_.size(); ++i) grid_[pixel_of_[i]] = static_cast<std::int32_t>(i);
  if (!knows_image(points)) {
    result->is_outlier_filter_suspended = true;
    return;
  }
  is_outlier_.assign(points.size(), 0);
  const float farthest_sq = squared(config_.outlier_max_range_m);
  for (std::size_t i = 0; i < pixel_of_.size(); ++i) {
    const Point& p = points[i];
    if (p.x * p.x + p.y * p.y + p.z * p.z > farthest_sq) continue;
    is_outlier_[i] = has_neighbours(i, points) ? 0 : 1;
  }
  std::size_t kept = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!is_outlier_[i]) points[kept++] = points[i];
  }
  result->counts.outlier = points.size() - kept;
  points.resize(kept);
}

void CloudFilter::apply(const RawCloudView& cloud, FilterResult* result) {
  begin(cloud, result);
  cloud_times_ = times_.judge(cloud);
  if (cloud.num_points() == 0) {
    result->points.clear();
  } else {
    if (Float32Reader::can_read(cloud.access())) {
      pass<Float32Reader>(cloud, result);
    } else {
      pass<AnyReader>(cloud, result);
    }
  }
  restore_unjudged_ghosts(result);
  if (!pixel_of_.empty()) remove_outliers(result);
  if (result->sweep_start_ns != 0) {
    for (auto* list : {&result->points, &result->ghosts, &result->far}) shift_times(result->sweep_start_ns, list);
  }
  result->counts.far = result->far.size();
  result->counts.ghost = result->ghosts.size();
  result->counts.kept = result->points.size();
}

FilterResult CloudFilter::apply(const RawCloudView& cloud) {
  FilterResult result;
  apply(cloud, &result);
  return result;
}

}  // namespace voxnav::cloud
