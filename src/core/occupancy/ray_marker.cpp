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

/// Marks of a block that have to be cleaned: surface bits alone, or crossed by rays.
constexpr std::uint8_t kHasSurface = 1;
constexpr std::uint8_t kCrossed = 2;

std::int64_t fixed(double value) { return static_cast<std::int64_t>(value * kOne); }

}  // namespace

/// What the voxels on a ray need to know of it.
struct RayMarker::Ray {
  bool is_evidence;
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

void RayMarker::begin(BlockWindow& window, const EndVoxels& ends, const ScanBox& box, const MissGuard& guard,
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
    touched_[block] = kHasSurface;
    for (int i = 0; i < 64; ++i) {
      rows_[64 * std::size_t{block} + i].surface = known->leaves.bits()[i] & ~(hits ? (*hits)[i] : 0);
    }
  }
}

inline void RayMarker::flush(std::uint32_t row_index, std::uint64_t bits, const Ray& ray) {
  Row& row = rows_[row_index];
  row.passed |= bits;
  touched_[row_index >> 6] = kCrossed;
  const std::uint64_t crossed = row.surface & bits;
  if (crossed != 0) cross_surfaces(row_index, crossed, ray);
}

/// Bits are gathered as long as they fall into one row; what the loop needs stays in registers.
void RayMarker::walk(const Line& line, const Ray& ray) {
  std::int64_t b = line.b;
  std::int64_t c = line.c;
  int a = line.a;
  std::uint32_t across = line.b_parts[b >> kFractionBits] + line.c_parts[c >> kFractionBits];
  std::uint32_t row = (line.a_parts[a] + across) >> 6;
  std::uint64_t bits = 0;
  const auto visit = [&](std::uint32_t address) {
    if ((address >> 6) != row) {
      flush(row, bits, ray);
      row = address >> 6;
      bits = 0;
    }
    bits |= std::uint64_t{1} << (address & 63);
  };
  const auto cross_slab = [&](std::int64_t b_next, std::int64_t c_next) {
    const std::uint32_t along = line.a_parts[a];
    visit(along + across);
    const bool both =
        (b_next >> kFractionBits) != (b >> kFractionBits) && (c_next >> kFractionBits) != (c >> kFractionBits);
    if (both) visit(along + corner(line, {b, c}, {b_next, c_next}));
    across = line.b_parts[b_next >> kFractionBits] + line.c_parts[c_next >> kFractionBits];
    visit(along + across);
    b = b_next;
    c = c_next;
    a += line.a_step;
  };
  std::int64_t b_border = line.b_border;
  std::int64_t c_border = line.c_border;
  for (int slab = 0; slab < line.num_slabs; ++slab) {
    cross_slab(b_border, c_border);
    b_border += line.b_slope;
    c_border += line.c_slope;
  }
  cross_slab(line.b_origin, line.c_origin);
  flush(row, bits, ray);
}

/// Where a ray changes voxel on both short axes within one slab, the voxel between is behind the border that comes
/// first: the one reached at the smaller share of the slab.
std::uint32_t RayMarker::corner(const Line& line, const Across& from, const Across& to) {
  const auto cell = [](std::int64_t value) { return value >> kFractionBits; };
  const auto way = [&](std::int64_t start, std::int64_t end) {
    return std::abs(static_cast<double>((std::max(cell(start), cell(end)) << kFractionBits) - start));
  };
  const double b_share = way(from.b, to.b) * std::abs(static_cast<double>(to.c - from.c));
  const double c_share = way(from.c, to.c) * std::abs(static_cast<double>(to.b - from.b));
  return b_share < c_share ? line.b_parts[cell(to.b)] + line.c_parts[cell(from.c)]
                           : line.b_parts[cell(from.b)] + line.c_parts[cell(to.c)];
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
  walk(line, {is_evidence, end, delta.normalized().cast<float>()});
}

void RayMarker::cross_surfaces(std::uint32_t row, std::uint64_t bits, const Ray& ray) {
  if (!ray.is_evidence) return;
  for_each_bit(bits, [&](int bit) {
    // One ray that saw through a voxel says it all; further ones need not be looked at.
    const bool saw_through = cross_surface(row >> 6, static_cast<int>(row & 63) * 64 + bit, ray);
    if (saw_through) rows_[row].surface &= ~(std::uint64_t{1} << bit);
  });
}

bool RayMarker::cross_surface(std::uint32_t block, int offset, const Ray& ray) {
  constexpr float kHalfDiagonal = 0.8661f;
  const geometry::Index3& first = box_->first_voxel(block);
  const geometry::Index3 inside = geometry::voxel_at({0, 0, 0}, offset);
  const geometry::Vec3f center(static_cast<float>(first.x + inside.x) + 0.5f,
                               static_cast<float>(first.y + inside.y) + 0.5f,
                               static_cast<float>(first.z + inside.z) + 0.5f);
  const geometry::Vec3f to_center = center - ray.end;
  const float center_along = to_center.dot(ray.direction);
  if (center_along < guard_.end_voxels - kHalfDiagonal) return false;
  const std::uint32_t slot = box_->slot_of(block);
  SurfaceLeaf* leaf = window_->at(static_cast<int>(slot))->leaves.find(offset);
  const geometry::Vec3f to_mean = to_center + leaf->offset();
  const float along = to_mean.dot(ray.direction);
  if (along < guard_.end_voxels) return false;
  const geometry::Vec3f across = to_mean - along * ray.direction;
  const bool saw_through =
      leaf->squared_distance(across, ray.direction, guard_.spread_voxels) <= guard_.sigmas * guard_.sigmas;
  std::uint8_t octants = 0xFF;
  if (!saw_through) {
    const geometry::Vec3f at = center_along * ray.direction - to_center;
    const int octant = (at.x() > 0.0f ? 1 : 0) | (at.y() > 0.0f ? 2 : 0) | (at.z() > 0.0f ? 4 : 0);
    octants = static_cast<std::uint8_t>(1u << octant);
  }
  crossings_.push_back({leaf, slot, static_cast<std::uint16_t>(offset), octants});
  return saw_through;
}

void RayMarker::merge(const RayMarker& other) {
  for (const std::uint32_t block : other.touched_blocks()) {
    touched_[block] = kCrossed;
    for (std::size_t i = 64 * std::size_t{block}; i < 64 * std::size_t{block} + 64; ++i)
      rows_[i].passed |= other.rows_[i].passed;
  }
  crossings_.insert(crossings_.end(), other.crossings_.begin(), other.crossings_.end());
}

std::vector<std::uint32_t> RayMarker::touched_blocks() const {
  std::vector<std::uint32_t> out;
  for (std::size_t block = 0; block < touched_.size(); ++block) {
    if (touched_[block] == kCrossed) out.push_back(static_cast<std::uint32_t>(block));
  }
  return out;
}

std::size_t RayMarker::memory_bytes() const {
  return rows_.capacity() * sizeof(Row) + touched_.capacity() + crossings_.capacity() * sizeof(Crossing);
}

}  // namespace voxnav::occupancy
