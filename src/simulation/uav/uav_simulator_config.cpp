// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav_simulation/uav_simulator_config.hpp"

namespace voxnav_simulation {

std::vector<std::string> UavSimulatorConfig::problems() const {
  std::vector<std::string> out;
  if (200 % clock_hz != 0) out.emplace_back("clock_hz must divide 200, the vehicle's own rate");
  if (clock_hz % state_hz != 0) out.emplace_back("state_hz must divide clock_hz");
  if (clock_hz % tracker_cmd_hz != 0) out.emplace_back("tracker_cmd_hz must divide clock_hz");
  if (clock_hz % 20 != 0) out.emplace_back("clock_hz must be a multiple of 20, the rate of the slower sensors");
  if (speed_factor <= 0 && lockstep_nodes.empty()) out.emplace_back("speed_factor 0 needs lockstep_nodes to wait for");
  if (uav_name.empty()) out.emplace_back("uav_name must not be empty");
  return out;
}

}  // namespace voxnav_simulation
