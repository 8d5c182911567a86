// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/cloud/pcl_filters.hpp"

#include "base/plugin.hpp"

namespace voxnav::cloud {

std::vector<std::string> PclFiltersConfig::problems() const {
  std::vector<std::string> out;
  for (const std::string& name : filters) {
    if (base::value_of_word<PclFilterKind>(name)) continue;
    out.push_back("filters: '" + name + "': " + base::detail::choice_problem(base::all_words<PclFilterKind>()));
  }
  if (filter_limit_min >= filter_limit_max) {
    out.push_back("filter_limit_min = " + base::to_string(filter_limit_min) +
                  ": must be below filter_limit_max = " + base::to_string(filter_limit_max));
  }
  for (std::size_t k = 0; k < 3; ++k) {
    if (crop_box_min[k] < crop_box_max[k]) continue;
    out.push_back(std::string("crop_box_min: must be below crop_box_max on axis ") + "xyz"[k]);
  }
  if (axis == std::array<double, 3>{0.0, 0.0, 0.0}) out.emplace_back("axis: must not be zero");
  return out;
}

std::vector<PclFilterKind> PclFiltersConfig::kinds() const {
  std::vector<PclFilterKind> out;
  for (const std::string& name : filters) {
    if (const auto kind = base::value_of_word<PclFilterKind>(name)) out.push_back(*kind);
  }
  return out;
}

std::vector<std::unique_ptr<PclFilter>> make_pcl_filters(const PclFiltersConfig& config) {
  base::checked(config);
  std::vector<std::unique_ptr<PclFilter>> out;
  for (const PclFilterKind kind : config.kinds()) {
    using Maker = PclFilter*(PclFilterKind, const PclFiltersConfig&);
    const auto make = base::plugin_function<Maker>("libvoxnav_pcl.so", "voxnav_make_pcl_filter");
    out.emplace_back(make(kind, config));
  }
  return out;
}

}  // namespace voxnav::cloud
