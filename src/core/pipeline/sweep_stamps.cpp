// SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/sweep_stamps.hpp"

namespace voxnav::pipeline {

std::optional<std::string> SweepStamps::refuse(base::StampNs start_ns, bool has_poses) {
  base::ClockWatch& watch = has_poses ? posed_ : others_;
  const auto before_ns = watch.newest_ns();
  const base::StampVerdict verdict = watch.add(start_ns);
  if (verdict == base::StampVerdict::kNext || verdict == base::StampVerdict::kNewClock) return std::nullopt;
  std::string out = start_ns <= *before_ns ? "its stamp is not newer than" : "its stamp is far ahead of";
  out += " that of the scan before, " + std::to_string(base::to_seconds(*before_ns));
  if (verdict == base::StampVerdict::kStray) out += ", and nothing confirms yet that the clock was set anew";
  return out;
}

}  // namespace voxnav::pipeline
