# SPDX-License-Identifier: BSD-3-Clause
"""``scripts/demo_two_uavs``: two UAVs cross a simulated world towards each other's start, once for each seed."""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
from typing import Any, Sequence

from voxnav.demo import mission, processes

NAMES = ("uav1", "uav2")
HEIGHT_M = 2.0
HEADING = ("seed", "reached", "least distance [m]", "least clearance [m]", "flight [s]", "collision", "reason")


def arguments(argv: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--world", default="forest", help="name of a file in worlds/, or path that ends in .yaml")
    parser.add_argument("--seeds", type=int, nargs="+", default=[1], help="of world, drift and sensor noise")
    parser.add_argument("--out", default="build/two_uavs", help="folder for one file for each seed, and the logs")
    parser.add_argument("--lockstep", action="store_true", help="simulated time waits for the nodes of both")
    parser.add_argument("--speed", type=float, default=1.0, help="simulated seconds per second")
    parser.add_argument("--limit", type=float, default=240.0, help="simulated seconds after which goals are given up")
    parser.add_argument("--config", default="", help="YAML over the defaults of both, one section per node")
    parser.add_argument("--fly", metavar="FILE", help=argparse.SUPPRESS)  # the part that flies, on a running master
    return parser.parse_args(argv)


def ends(args: argparse.Namespace, seed: int) -> tuple[list[float], list[float]]:
    """Returns the places of start and goal of a world, x y z at flight height above the ground."""
    world = mission.simulated_world(args.world, seed)
    places = []
    for x, y in (world.config.start_m, world.config.goal_m):
        places.append([float(x), float(y), float(world.ground_height(x, y)) + HEIGHT_M])
    return places[0], places[1]


def fly(args: argparse.Namespace, seed: int) -> dict[str, Any]:
    """Flies one seed. Returns what FlightOfTwo.result() returns."""
    start, goal = ends(args, seed)
    log = os.path.join(args.out, "seed_%d.log" % seed)
    launched, env = processes.launch("two_uavs.launch", {
        "world_yaml": mission.world_file(args.world), "seed": seed, "speed_factor": args.speed,
        "lockstep": str(args.lockstep).lower(), "first_start": "%g, %g" % tuple(start[:2]),
        "second_start": "%g, %g" % tuple(goal[:2]),
        "custom_config": os.path.abspath(args.config) if args.config else ""}, log)
    result_file = os.path.join(args.out, "seed_%d.json" % seed)
    try:
        env.update(ROS_NAMESPACE="/", VOXNAV_GOALS=json.dumps([goal, start]))
        # rospy knows one master in its life, so each flight has a process of its own.
        command = [sys.executable, "-c", "from voxnav.demo.two_uavs import main; main()", "--fly", result_file,
                   "--limit", str(args.limit)]
        subprocess.run(command, env=dict(os.environ, **env), check=True)
        with open(result_file) as stream:
            result: dict[str, Any] = json.load(stream)
    finally:
        launched.stop()
    return result


def row(seed: int, result: dict[str, Any]) -> tuple[str, ...]:
    uavs = [result["uavs"][name] for name in NAMES]
    return (str(seed), " ".join("yes" if uav["reached"] else "no" for uav in uavs),
            "%.2f" % result["least_distance_m"], " ".join("%.2f" % uav["min_clearance_m"] for uav in uavs),
            " ".join("%.0f" % uav["flight_s"] for uav in uavs), "yes" if result["has_collided"] else "no",
            "; ".join(uav["reason"] for uav in uavs))


def main(argv: Sequence[str] | None = None) -> int:
    args = arguments(argv)
    if args.fly:
        from voxnav.nodes import two_uavs_mission  # needs the master

        result = two_uavs_mission.fly(NAMES, json.loads(os.environ["VOXNAV_GOALS"]), args.limit)
        with open(args.fly, "w") as stream:
            json.dump(result, stream, indent=1)
        return 0
    os.makedirs(args.out, exist_ok=True)
    processes.end_cleanly_when_terminated()
    print(" | ".join(HEADING), flush=True)
    is_good = True
    for seed in args.seeds:
        result = fly(args, seed)
        is_good = is_good and not result["has_collided"] and all(uav["reached"] for uav in result["uavs"].values())
        print(" | ".join(row(seed, result)), flush=True)
    return 0 if is_good else 1
