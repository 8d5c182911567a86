# SPDX-License-Identifier: BSD-3-Clause
"""``make demo``: one flight through a simulated world, from nothing to a summary and pictures."""

from __future__ import annotations

import argparse
import os
import sys
import time
from typing import Any, Sequence

from voxnav.demo import mission, processes, summary
from voxnav.demo.rviz import Rviz, show
from voxnav.demo.record import FlightRecord


def arguments(argv: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--world", default="forest", help="name of a file in worlds/ (forest, meadow, firetruck), or "
                        "path of a file that ends in .yaml")
    parser.add_argument("--seed", type=int, default=1, help="of world and sensor noise")
    parser.add_argument("--out", default="build/demo", help="folder for summary.json and the pictures")
    parser.add_argument("--lockstep", action="store_true", help="results independent of the machine's load")
    parser.add_argument("--speed", type=float, default=1.0, help="simulated seconds per second")
    parser.add_argument("--max-speed", type=float, metavar="MPS", help="horizontal speed limit of the vehicle")
    parser.add_argument("--faults", action="store_true", help="a vehicle with the faults of config/faults.yaml")
    parser.add_argument("--limit", type=float, metavar="S", help="simulated seconds after which the goal is given up; "
                        "default: no limit")
    parser.add_argument("--config", default="", help="YAML over the defaults, one section per node")
    parser.add_argument("--no-rviz", action="store_true", help="no rviz picture")
    parser.add_argument("--end-with-parent", action="store_true", help="end when standard input is closed")
    return parser.parse_args(argv)


def launch_arguments(args: argparse.Namespace) -> dict[str, Any]:
    """Returns the arguments of launch/simulation.launch; those that were not asked for keep their defaults."""
    out = {"world_yaml": mission.world_file(args.world), "seed": args.seed, "speed_factor": args.speed,
           "lockstep": str(args.lockstep).lower(), "lockstep_leader": "demo" if args.lockstep else "",
           "custom_config": os.path.abspath(args.config) if args.config else ""}
    if args.max_speed is not None:
        out["max_speed_mps"] = args.max_speed
    if args.faults:
        out["faults"] = "true"
    return out


def main(argv: Sequence[str] | None = None) -> int:
    args = arguments(argv)
    os.makedirs(args.out, exist_ok=True)
    record = FlightRecord(os.path.splitext(os.path.basename(args.world))[0], args.seed)
    record.speed_factor = args.speed
    log = os.path.join(args.out, "roslaunch.log")
    started = time.monotonic()
    world = mission.simulated_world(args.world, args.seed)
    print("demo: flying world %s, seed %d; logs in %s" % (args.world, args.seed, log), flush=True)
    rviz = None
    processes.end_cleanly_when_terminated()
    if args.end_with_parent:
        processes.end_with_parent()
    launched, env = processes.launch("simulation.launch", launch_arguments(args), log)
    try:
        os.environ.update(ROS_MASTER_URI=env["ROS_MASTER_URI"], ROS_IP=env["ROS_IP"], ROS_NAMESPACE="/uav1")
        config = mission.repository_file("rviz/planning.rviz")
        # With a display people watch the flight. Drawing by software would cost the flight its processor.
        if os.environ.get("DISPLAY") and not args.no_rviz:
            rviz = Rviz(env, config, os.path.join(args.out, "rviz.log"))
        from voxnav.nodes import demo_mission  # rospy reads master and namespace from the environment when imported

        demo_mission.fly(record, mission.goal_of(world), os.path.join(args.out, "map"),
                         is_leader=args.lockstep, limit_s=args.limit)
        notes = show(args, env, record, rviz, config, mission.trunks(world))
    finally:
        if rviz:
            rviz.stop()
        launched.stop()
    result = summary.summarise(record)
    summary.write_json(os.path.join(args.out, "summary.json"), result)
    print(summary.table(result))
    for note in notes:
        print("note: " + note)
    print("\npictures and summary.json in %s (%.0f s)" % (args.out, time.monotonic() - started))
    if not record.reached:
        print("demo: NOT reached: %s\nthe nodes' logs: %s" % (record.reason, log), file=sys.stderr)
    return 0 if record.reached else 1
