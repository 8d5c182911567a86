// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "voxnav/base/bytes.hpp"
#include "voxnav/submap/submap.hpp"

namespace voxnav::submap {
namespace {

constexpr std::uint32_t kMagic = 0x4D535856;  // "VXSM"
constexpr std::uint32_t kVersion = 1;

}  // namespace

std::string Submap::to_bytes() const {
  base::ByteWriter out;
  out.put(kMagic);
  out.put(kVersion);
  out.put(resolution_m_);
  out.put(config_.band_voxels);
  out.put(config_.max_distance_m);
  out.put<std::int32_t>(config_.max_surface_points);
  out.put<std::uint8_t>(config_.certified);
  out.put_raw(T_S_G_.matrix().data(), 16 * sizeof(double));
  field_.write(&out);
  out.put<std::uint64_t>(surface_points_.size());
  for (const geometry::SurfacePoint& point : surface_points_) {
    out.put_raw(point.position.data(), 3 * sizeof(float));
    out.put_raw(point.normal.data(), 3 * sizeof(float));
    out.put(point.weight);
  }
  return out.finish();
}

std::shared_ptr<Submap> Submap::from_bytes(const std::string& bytes) {
  base::ByteReader in(bytes, "submap");
  if (in.get<std::uint32_t>() != kMagic) in.fail("is not a voxnav submap");
  if (in.get<std::uint32_t>() != kVersion) in.fail("has a version this program does not know");
  std::shared_ptr<Submap> out(new Submap());
  out->resolution_m_ = in.get<double>();
  if (!(out->resolution_m_ > 0.0) || !std::isfinite(out->resolution_m_)) in.fail("has no positive resolution");
  out->config_.band_voxels = in.get<double>();
  out->config_.max_distance_m = in.get<double>();
  out->config_.max_surface_points = in.get<std::int32_t>();
  out->config_.certified = in.get<std::uint8_t>() != 0;
  if (!base::problems_of(out->config_).empty()) in.fail("has settings out of range");
  in.get_raw(out->T_S_G_.matrix().data(), 16 * sizeof(double));
  const Eigen::RowVector4d last_row(0, 0, 0, 1);
  if (!geometry::is_valid(out->T_S_G_) || out->T_S_G_.matrix().row(3) != last_row) in.fail("has no valid transform");
  out->T_G_S_ = out->T_S_G_.inverse(Eigen::Isometry);
  out->field_ = CompressedField::read(&in);
  out->surface_points_.resize(in.get_count(7 * sizeof(float)));
  for (geometry::SurfacePoint& point : out->surface_points_) {
    in.get_raw(point.position.data(), 3 * sizeof(float));
    in.get_raw(point.normal.data(), 3 * sizeof(float));
    point.weight = in.get<float>();
    const bool is_finite = point.position.allFinite() && point.normal.allFinite() && std::isfinite(point.weight);
    if (!is_finite || !(point.weight > 0.f)) in.fail("has a surface point that is no point");
  }
  if (in.remaining() != 0) in.fail("has bytes after its end");
  out->update_bounds();
  return out;
}

}  // namespace voxnav::submap
