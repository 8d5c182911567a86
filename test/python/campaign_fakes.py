# SPDX-License-Identifier: BSD-3-Clause
"""Flights of campaigns that take no time, in place of simulated ones. They lie in a file of their own, so that the
workers of a Dask cluster can import them."""

import os
import time

import yaml

from voxnav.campaign.flight import FlightResult
from voxnav.campaign.rows import row_of

PICTURE = b"\x89PNG picture of a failure"


def summary(**changes):
    """Returns the content of a summary.json of a flight of 80 m in 20 s that reached its goal."""
    out = {"reached": True, "reason": "goal reached", "min_clearance_m": 1.25, "has_collided": False,
           "path_length_m": 80.0, "straight_m": 75.0, "flight_s": 20.0, "num_hovers": 0, "num_shortened": 2}
    return dict(out, **changes)


def fly(task):
    """Fails in flights with an odd seed; flights of seed 3 raise, as in a worker that is broken."""
    if task.seed == 3:
        raise RuntimeError("the worker is broken")
    count(task)
    if task.seed % 2:
        row = row_of(task, "", summary(reached=False, reason="stuck, behind\na tree", has_collided=True,
                                       min_clearance_m=0.2), 1.5)
        return FlightResult(row, {"top_view.png": PICTURE, "demo.log": b"log"})
    return FlightResult(row_of(task, "", summary(), 1.5), {"summary.json": b"{}"})


def count(task):
    """Leaves a line in the file that the environment names, so that a test knows what was flown."""
    if "VOXNAV_TEST_FLOWN" in os.environ:
        with open(os.environ["VOXNAV_TEST_FLOWN"], "a") as out:
            out.write("%s %d\n" % (task.name, os.getpid()))


def fly_with_ratio(task):
    """Is fastest where the configured ratio is 0.7, and comes too near above 0.75."""
    ratio = yaml.safe_load(task.config)["planning_manager"]["manager"]["deceleration_ratio"]
    count(task)
    clearance_m = 1.2 if ratio < 0.75 else 0.4
    flight_s = 20.0 + 50.0 * abs(ratio - 0.7)
    return FlightResult(row_of(task, "", summary(flight_s=flight_s, min_clearance_m=clearance_m)), {})


def fly_slowly(task):
    """Takes a minute, unless the seed is 2."""
    time.sleep(0.0 if task.seed == 2 else 60.0)
    return fly(task)
