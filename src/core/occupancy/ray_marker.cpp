// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/occupancy/ray_marker.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "voxnav/occupancy/byte_ops.hpp"

namespace voxnav::occupancy {
namespace {

/// Positions across the longest axis are fixed-point numbers: exact sums, and the voxel is a shift away.
constexpr int kFractionBits = 32;
constexpr double kOne = 4294967296.0;

std::int64_t fixed(double value) { return static_cast<std::int64_t>(value * kOne); }

}  // namespace

/// Bits of the voxels visited last, as long as they lie in one row.
struct RayMarker::Run {
  std::uint32_t row = 0;
  std::uint64_t bits = 0;
  bool is_evidence = true;
  geometry::Vec3f end;
  geometry::Vec3f direction;  ///< unit, from the end to the sensor
};

/// A ray with its longest axis (a) first; b and c are the others.
struct RayMarker::Line {
  const std::uint32_t* a_parts;
  const std::uint32_t* b_parts;
  const std::uint32_t* c_parts;
  int a;  ///< voxel of the end
  int a_step;
  int num_slabs;   ///< borders crossed on the longest axis
  std::int64_t b;  ///< of the end
  std::int64_t c;
  std::int64_t b_border;  ///< at the first border crossed on the longest axis
  std::int64_t c_border;
  std::int64_t b_slope;  ///< per voxel of the longest axis
  std::int64_t c_slope;
  std::int64_t b_origin;
  std::int64_t c_origin;
};

void RayMarker::begin(const BlockWindow& window, const EndVoxels& ends, const ScanBox& box, const MissGuard& guard,
                      const geometry::Vec3& origin) {
  for (std::size_t block = 0; block < touched_.size(); ++block) {
    if (touched_[block] != 0) std::fill_n(rows_.begin() + static_cast<std::ptrdiff_t>(64 * block), 64, Row{});
  }
  window_ = &window;
  box_ = &box;
  guard_ = guard;
  origin_ = origin.cast<float>();
  crossings_.clear();
  touched_.assign(box.num_blocks(), 0);
  rows_.resize(std::max<std::size_t>(rows_.size(), std::size_t{64} * box.num_blocks()));
  for (std::uint32_t block = 0; block < box.num_blocks(); ++block) {
    const std::uint32_t slot = box.slot_of(block);
    const OctreeBlock* known = window.at(static_cast<int>(slot));
    if (known == nullptr || known->leaves.empty()) continue;
    const VoxelBits* hits = ends.hit_bits(slot);
    touched_[block] = 2;  // has surface bits to be cleaned, even if no ray comes here
    for (int i = 0; i < 64; ++i) {
      rows_[64 * std::size_t{block} + i].surface = known->leaves.bits()[i] & ~(hits ? (*hits)[i] : 0);
    }
  }
}

inline void RayMarker::flush(Run* run) {
  Row& row = rows_[run->row];
  row.passed |= run->bits;
  touched_[run->row >> 6] = 3;
  const std::uint64_t crossed = row.surface & run->bits;
  if (crossed != 0) cross_surfaces(run->row, crossed, *run);
  run->bits = 0;
}

inline void RayMarker::visit(std::uint32_t address, Run* run) {
  const std::uint32_t row = address >> 6;
  if (row != run->row) {
    flush(run);
    run->row = row;
  }
  run->bits |= std::uint64_t{1} << (address & 63);
}

void RayMarker::walk(const Line& line, Run* run) {
  std::int64_t b = line.b;
  std::int64_t c = line.c;
  std::int64_t b_next = line.num_slabs > 0 ? line.b_border : line.b_origin;
  std::int64_t c_next = line.num_slabs > 0 ? line.c_border : line.c_origin;
  int a = line.a;
  for (int slab = 0; slab <= line.num_slabs; ++slab) {
    const auto b_cell = static_cast<int>(b >> kFractionBits);
    const auto c_cell = static_cast<int>(c >> kFractionBits);
    const auto b_end = static_cast<int>(b_next >> kFractionBits);
    const auto c_end = static_cast<int>(c_next >> kFractionBits);
    const std::uint32_t here = line.a_parts[a];
    visit(here + line.b_parts[b_cell] + line.c_parts[c_cell], run);
    if (b_cell != b_end && c_cell != c_end) {
      // Which border comes first: compare the shares of the slab at which they are reached.
      const auto b_border =
          static_cast<double>((static_cast<std::int64_t>(std::max(b_cell, b_end)) << kFractionBits) - b);
      const auto c_border =
          static_cast<double>((static_cast<std::int64_t>(std::max(c_cell, c_end)) << kFractionBits) - c);
      const bool b_first =
          std::abs(b_border * static_cast<double>(c_next - c)) < std::abs(c_border * static_cast<double>(b_next - b));
      visit(here + line.b_parts[b_first ? b_end : b_cell] + line.c_parts[b_first ? c_cell : c_end], run);
    }
    visit(here + line.b_parts[b_end] + line.c_parts[c_end], run);
    a += line.a_step;
    b = b_next;
    c = c_next;
    b_next = slab + 1 < line.num_slabs ? b + line.b_slope : line.b_origin;
    c_next = slab + 1 < line.num_slabs ? c + line.c_slope : line.c_origin;
  }
}

void RayMarker::cast(const geometry::Vec3f& end, bool is_evidence) {
  const geometry::Vec3 from = end.cast<double>();
  const geometry::Vec3 to = origin_.cast<double>();
  const geometry::Vec3 delta = to - from;
  int a = 0;
  const double length = delta.cwiseAbs().maxCoeff(&a);
  const int b = (a + 1) % 3;
  const int c = (a + 2) % 3;
  Line line;
  line.a_parts = box_->parts(a);
  line.b_parts = box_->parts(b);
  line.c_parts = box_->parts(c);
  line.a = static_cast<int>(from[a]);
  line.a_step = delta[a] > 0.0 ? 1 : -1;
  line.num_slabs = std::abs(static_cast<int>(to[a]) - line.a);
  line.b = fixed(from[b]);
  line.c = fixed(from[c]);
  line.b_origin = fixed(to[b]);
  line.c_origin = fixed(to[c]);
  const double b_slope = length > 0.0 ? delta[b] / length : 0.0;
  const double c_slope = length > 0.0 ? delta[c] / length : 0.0;
  const double to_border = line.a_step > 0 ? line.a + 1 - from[a] : from[a] - line.a;
  line.b_border = fixed(from[b] + to_border * b_slope);
  line.c_border = fixed(from[c] + to_border * c_slope);
  line.b_slope = fixed(b_slope);
  line.c_slope = fixed(c_slope);
  Run run;
  run.row = (line.a_parts[line.a] + line.b_parts[line.b >> kFractionBits] + line.c_parts[line.c >> kFractionBits]) >> 6;
  run.is_evidence = is_evidence;
  run.end = end;
  run.direction = delta.normalized().cast<float>();
  walk(line, &run);
  flush(&run);
}

void RayMarker::cross_surfaces(std::uint32_t row, std::uint64_t bits, const Run& run) {
  if (!run.is_evidence) return;
  for_each_bit(bits, [&](int bit) { cross_surface(row >> 6, static_cast<int>(row & 63) * 64 + bit, run); });
}

void RayMarker::cross_surface(std::uint32_t block, int offset, const Run& run) {
  const geometry::Index3 first = box_->first_voxel(block);
  const geometry::Index3 inside = geometry::voxel_at({0, 0, 0}, offset);
  const geometry::Vec3f center(static_cast<float>(first.x + inside.x) + 0.5f,
                               static_cast<float>(first.y + inside.y) + 0.5f,
                               static_cast<float>(first.z + inside.z) + 0.5f);
  const std::uint32_t slot = box_->slot_of(block);
  const geometry::Vec3f mean = center + window_->at(static_cast<int>(slot))->leaves.find(offset)->offset();
  const geometry::Vec3f to_mean = mean - run.end;
  const float along = to_mean.dot(run.direction);
  if (along < guard_.end_voxels) return;
  const float distance_squared = to_mean.squaredNorm() - along * along;
  std::uint8_t octants = 0xFF;
  if (distance_squared > guard_.distance_voxels * guard_.distance_voxels) {
    const float nearest = (center - run.end).dot(run.direction);
    const geometry::Vec3f at = run.end + nearest * run.direction - center;
    const int octant = (at.x() > 0.0f ? 1 : 0) | (at.y() > 0.0f ? 2 : 0) | (at.z() > 0.0f ? 4 : 0);
    octants = static_cast<std::uint8_t>(1u << octant);
  }
  crossings_.push_back({slot, static_cast<std::uint16_t>(offset), octants});
}

void RayMarker::merge(const RayMarker& other) {
  for (const std::uint32_t block : other.touched_blocks()) {
    touched_[block] = 3;
    for (std::size_t i = 64 * std::size_t{block}; i < 64 * std::size_t{block} + 64; ++i)
      rows_[i].passed |= other.rows_[i].passed;
  }
  crossings_.insert(crossings_.end(), other.crossings_.begin(), other.crossings_.end());
}

std::vector<std::uint32_t> RayMarker::touched_blocks() const {
  std::vector<std::uint32_t> out;
  for (std::size_t block = 0; block < touched_.size(); ++block) {
    if (touched_[block] == 3) out.push_back(static_cast<std::uint32_t>(block));
  }
  return out;
}

std::size_t RayMarker::memory_bytes() const {
  return rows_.capacity() * sizeof(Row) + touched_.capacity() + crossings_.capacity() * sizeof(Crossing);
}

}  // namespace voxnav::occupancy
