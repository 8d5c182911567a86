// SPDX-License-Identifier: BSD-3-Clause
#include "bind_config.hpp"
#include "floors.hpp"
#include "mapper.hpp"
#include "offline_config.hpp"
#include "planning_manager.hpp"
#include "submap_assembler.hpp"
#include "submap_scheduler.hpp"
#include "voxnav/pipeline/time_config.hpp"

namespace voxnav::bindings {

void bind_pipeline(pybind11::module_& m) {
  bind_config<pipeline::TimeConfig>(m, "TimeConfig",
                                    "Whether time is real, or that of a simulation that waits for the node.");
  bind_navigation_map(m);
  bind_planning_manager(m);
  bind_offline_config(m);
  bind_submap_scheduler(m);
  bind_submap_assembler(m);
  bind_mapper(m);
}

}  // namespace voxnav::bindings
