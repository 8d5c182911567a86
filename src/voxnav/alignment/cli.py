# SPDX-License-Identifier: BSD-3-Clause
"""``scripts/evaluate_alignment``: how well the submap graph corrects simulated flights that drift."""

from __future__ import annotations

import argparse
import json
import os
import time
from typing import Any, Sequence

import numpy as np

from voxnav.alignment.flight import kept_flight, world_of
from voxnav.alignment.measure import Errors, aligned_surface, merged_surface, own_surface, solve, surface_share
from voxnav.alignment.pictures import draw_errors, draw_trunks
from voxnav.alignment.scenarios import SCENARIOS, Scenario, at_rate
from voxnav.plotting import require_pictures

_DEFAULT = [name for name in SCENARIOS if name != "long"]
# A trajectory counts as worse only if its error grew by more than this, which is the accuracy of the measurement.
_TOLERANCE_M = 0.005


def arguments(argv: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="evaluate_alignment", description=__doc__)
    parser.add_argument("--scenarios", nargs="+", choices=list(SCENARIOS), default=_DEFAULT,
                        help="default: %(default)s")
    parser.add_argument("--seeds", nargs="+", type=int, default=[1, 2, 3], help="of world, sensor and drift")
    parser.add_argument("--scan-hz", type=float, help="scans per second; default: those of the scenario")
    parser.add_argument("--out", default="build/alignment", help="folder for pictures and alignment.json")
    parser.add_argument("--keep-flights", metavar="DIR", help="keep simulated flights here and use those that are kept")
    return parser.parse_args(argv)


def evaluate(scenario: Scenario, seed: int, out: str, flights: str | None) -> dict[str, Any]:
    """Flies, solves, measures and draws one flight. Returns a dict of numbers."""
    world, flight = world_of(scenario, seed), kept_flight(scenario, seed, flights)
    solved = solve(flight)
    seconds = np.array([report.seconds for report in solved.reports])
    name = "%s_%d" % (scenario.name, seed)
    draw_errors(os.path.join(out, name + ".png"), "%s, seed %d" % (scenario.about, seed), flight, solved)
    rows = np.searchsorted(flight.stamps_s, solved.stamps_s - 1e-6)
    half_voxel_m = 0.2
    sides: dict[str, Any] = {
        "before": ({r.id: r.T_O_S for r, _ in flight.submaps}, {}, flight.T_O_B[rows]),
        "after": (solved.session.graph.poses(), solved.session.bends(), solved.T_W_B)}
    own, merged = ({key: aligned_surface(surface(flight, T_W_S, bends), T_est, solved.T_true)
                    for key, (T_W_S, bends, T_est) in sides.items()} for surface in (own_surface, merged_surface))
    if hasattr(world, "trunks"):
        draw_trunks(os.path.join(out, name + "_trunks.png"), own, world, flight.T_W_B[0][:2, 3])
    return {
        "scenario": scenario.name, "seed": seed, "submaps": len(flight.submaps), "pairs": solved.reports[-1].pairs,
        "before": _numbers(solved.before), "after": _numbers(solved.after),
        "worst_excess_m": float(solved.worst_excess_m),
        "surface_share": {key: surface_share(points, world, half_voxel_m) for key, points in own.items()},
        "map_share": {key: surface_share(points, world, half_voxel_m) for key, points in merged.items()},
        "solve_cpu_s": {"mean": float(seconds.mean()), "max": float(seconds.max()), "last": float(seconds[-1])}}


def _numbers(errors: Errors) -> dict[str, Any]:
    return {"rmse_m": float(errors.rmse_m), "axis_m": [float(x) for x in errors.axis_m],
            "unaligned_m": float(errors.unaligned_m), "closure_m": float(errors.closure_m)}


def _print_errors(results: list[dict[str, Any]]) -> None:
    print("\nTrajectory error [m]: RMSE after SE(3) alignment, by axis; way from start to end; share of what "
          "submaps saw themselves, and of the merged map, within 0.2 m of the true surface")
    print("scenario  seed submaps pairs |  before   x     y     z   start-end   own     map |"
          "   after   x     y     z   start-end   own     map | solve CPU mean, max [s]")
    for r in results:
        sides = ["%7.3f %5.3f %5.3f %5.3f %9.3f %5.1f %% %5.1f %%" % (
            r[k]["rmse_m"], *r[k]["axis_m"], r[k]["closure_m"], 100.0 * r["surface_share"][k],
            100.0 * r["map_share"][k]) for k in ("before", "after")]
        print("%-9s %4d %7d %5d | %s | %s | %.3f %.3f" % (
            r["scenario"], r["seed"], r["submaps"], r["pairs"], *sides, r["solve_cpu_s"]["mean"],
            r["solve_cpu_s"]["max"]))


def _print_never_worse(results: list[dict[str, Any]]) -> int:
    """Prints the gain of each flight and its worst moment. Returns how many flights came out worse than their input."""
    print("\nNever worse: after all submaps, and the worst moment of the flight (after minus before) [m]")
    worse = 0
    for r in results:
        gain_m = r["before"]["rmse_m"] - r["after"]["rmse_m"]
        is_worse = max(-gain_m, r["worst_excess_m"]) > _TOLERANCE_M
        worse += is_worse
        print("%-9s %4d  gain %7.3f  worst moment %+7.3f  %s" % (
            r["scenario"], r["seed"], gain_m, r["worst_excess_m"], "WORSE" if is_worse else "ok"))
    return worse


def main(argv: Sequence[str] | None = None) -> int:
    args = arguments(argv)
    require_pictures()
    os.makedirs(args.out, exist_ok=True)
    results = []
    for name in args.scenarios:
        for seed in args.seeds:
            start_s = time.process_time()
            scenario = at_rate(SCENARIOS[name], args.scan_hz)
            results.append(evaluate(scenario, seed, args.out, args.keep_flights))
            r = results[-1]
            print("%-9s seed %d: %.3f -> %.3f m (%.0f s)" % (
                name, seed, r["before"]["rmse_m"], r["after"]["rmse_m"], time.process_time() - start_s), flush=True)
    _print_errors(results)
    worse = _print_never_worse(results)
    with open(os.path.join(args.out, "alignment.json"), "w") as out:
        json.dump(results, out, indent=1)
    return 1 if worse else 0
