// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/graph/graph_config.hpp"

namespace voxnav::graph {

std::vector<std::string> SubmapGraphConfig::problems() const {
  std::vector<std::string> out;
  if (fine_kernel_voxels > coarse_kernel_voxels)
    out.emplace_back("fine_kernel_voxels must not exceed coarse_kernel_voxels");
  if (min_points_per_pair > 2 * points_per_pair) out.emplace_back("min_points_per_pair exceeds what a pair can have");
  return out;
}

}  // namespace voxnav::graph
