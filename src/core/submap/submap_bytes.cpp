// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "submap/content/content_codec.hpp"
#include "voxnav/submap/submap.hpp"

namespace voxnav::submap {
namespace {

constexpr base::Format kFormat{0x4D535856, 1, "a voxnav submap"};  // "VXSM"
constexpr double kFinest_m = 1e-3;
constexpr double kCoarsest_m = 1e3;
constexpr double kFarthest_m = 1e7;  // largest distance of the grid from the submap frame

std::vector<geometry::SurfacePoint> get_surface_points(base::ByteReader* in) {
  std::vector<geometry::SurfacePoint> points(in->get_count(7 * sizeof(float)));
  for (geometry::SurfacePoint& point : points) {
    in->get_raw(point.position.data(), 3 * sizeof(float));
    in->get_raw(point.normal.data(), 3 * sizeof(float));
    point.weight = in->get<float>();
    const bool is_finite = point.position.allFinite() && point.normal.allFinite() && std::isfinite(point.weight);
    if (!is_finite || !(point.weight > 0.f)) in->fail("has a surface point that is no point");
  }
  return points;
}

}  // namespace

std::string Submap::to_bytes() const {
  base::ByteWriter out;
  out.put_header(kFormat);
  out.put(resolution_m_);
  out.put(config_.band_voxels);
  out.put(config_.max_distance_m);
  out.put<std::int32_t>(config_.max_surface_points);
  out.put<std::uint8_t>(config_.certified);
  out.put_raw(T_S_G_.matrix().data(), 16 * sizeof(double));
  const auto held = content();
  write_content(*held, &out);
  // Surface points for registration follow from the content, unless their normals were measured.
  static const std::vector<geometry::SurfacePoint> none;
  const std::vector<geometry::SurfacePoint>& points = held->measured() ? surface_points() : none;
  out.put<std::uint64_t>(points.size());
  for (const geometry::SurfacePoint& point : points) {
    out.put_raw(point.position.data(), 3 * sizeof(float));
    out.put_raw(point.normal.data(), 3 * sizeof(float));
    out.put(point.weight);
  }
  return out.finish();
}

std::shared_ptr<Submap> Submap::from_bytes(const std::string& bytes) {
  base::ByteReader in(bytes, "submap");
  in.check_header(kFormat);
  std::shared_ptr<Submap> out(new Submap());
  out->resolution_m_ = in.get<double>();
  if (!(out->resolution_m_ >= kFinest_m && out->resolution_m_ <= kCoarsest_m)) in.fail("has no usable resolution");
  out->config_.band_voxels = in.get<double>();
  out->config_.max_distance_m = in.get<double>();
  out->config_.max_surface_points = in.get<std::int32_t>();
  out->config_.certified = in.get<std::uint8_t>() != 0;
  if (!base::problems_of(out->config_).empty()) in.fail("has settings out of range");
  in.get_raw(out->T_S_G_.matrix().data(), 16 * sizeof(double));
  const Eigen::RowVector4d last_row(0, 0, 0, 1);
  if (!geometry::is_valid(out->T_S_G_) || out->T_S_G_.matrix().row(3) != last_row) in.fail("has no valid transform");
  if (out->T_S_G_.translation().cwiseAbs().maxCoeff() > kFarthest_m) in.fail("has a grid that lies too far away");
  out->T_G_S_ = out->T_S_G_.inverse(Eigen::Isometry);
  SubmapContent content = read_content(&in);
  std::vector<geometry::SurfacePoint> points = get_surface_points(&in);
  if (in.remaining() != 0) in.fail("has bytes after its end");
  const bool is_measured = content.measured() != nullptr;
  if (!is_measured && !points.empty()) in.fail("has surface points that should follow from its content");
  if (is_measured) out->set_surface_points(std::move(points));
  out->take_content(std::move(content));
  return out;
}

}  // namespace voxnav::submap
