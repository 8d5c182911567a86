// SPDX-License-Identifier: BSD-3-Clause
#include "offline_config.hpp"

#include "bind_config.hpp"
#include "configs/offline_config.hpp"

namespace voxnav::bindings {

void bind_offline_config(py::module_& m) {
  bind_words<PoseSource>(m, "PoseSource", "Where the poses of a recording's scans come from.");
  bind_words<MountSource>(m, "MountSource", "Where the mount of a recording's LiDAR is from.");
  bind_config<OfflineConfig>(m, "OfflineConfig",
                             "Parameters of scripts/map_bag beside those of the parts that it runs.");
}

}  // namespace voxnav::bindings
