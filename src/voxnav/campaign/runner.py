# SPDX-License-Identifier: BSD-3-Clause
"""Flies tasks in parallel on Dask: on a cluster of this machine, or on a running scheduler given by its address."""

from __future__ import annotations

import contextlib
import logging
import os
import time
import uuid
from typing import Any, Callable, Iterator, Sequence

from voxnav.campaign.errors import CampaignError
from voxnav.campaign.flight import FlightResult, fly, num_flying, stop_flights
from voxnav.campaign.grid import FlightTask
from voxnav.campaign.rows import row_of

# A flight in lock-step keeps about this many processors busy.
_CPUS_PER_FLIGHT = 2
CONNECTION_LIMIT_S = 20.0
# Interrupted flights have this long to end their nodes.
_END_LIMIT_S = 90.0
Fly = Callable[[FlightTask], FlightResult]


def sensible_workers() -> int:
    """Returns how many flights this machine can fly at a time."""
    return max(1, len(os.sched_getaffinity(0)) // _CPUS_PER_FLIGHT)


def _dask() -> Any:
    try:
        import distributed
    except ImportError as error:
        raise CampaignError("campaigns need Dask (package python3-distributed): %s" % error) from error
    logging.getLogger("distributed").setLevel(logging.CRITICAL)  # errors come as exceptions as well
    return distributed


@contextlib.contextmanager
def client(scheduler: str | None, num_workers: int) -> Iterator[Any]:
    """Yields a Dask client. scheduler: address such as tcp://host:8786, or None for a cluster of num_workers threads.

    Threads are enough, because a flight is a process and the thread only waits for it.
    """
    distributed = _dask()
    with contextlib.ExitStack() as stack:
        if scheduler is None:
            scheduler = stack.enter_context(distributed.LocalCluster(
                n_workers=1, threads_per_worker=num_workers, processes=False, memory_limit=0,
                dashboard_address="127.0.0.1:0"))
        try:
            dask = stack.enter_context(distributed.Client(scheduler, timeout=CONNECTION_LIMIT_S))
        except OSError as error:
            raise CampaignError("no Dask scheduler answers at %s: %s" % (scheduler, error)) from error
        deadline = time.monotonic() + CONNECTION_LIMIT_S
        while not dask.scheduler_info()["workers"]:
            if time.monotonic() > deadline:
                raise CampaignError("the Dask scheduler at %s has no workers" % scheduler)
            time.sleep(0.1)
        yield dask


def run(dask: Any, tasks: Sequence[FlightTask], flown: Callable[[FlightTask, FlightResult], None],
        fly_one: Fly = fly) -> None:
    """Flies all tasks and calls flown(task, result) in this thread as each ends, in the order in which they end.

    A task that raised, or whose workers died again and again, becomes a row with that reason. If this call is
    interrupted, the flights that are in the air are stopped and are not reported. Raises CampaignError if the scheduler
    is lost.
    """
    from distributed import as_completed

    name = uuid.uuid4().hex
    # With keys of their own flights of an earlier campaign on the same scheduler are not taken for these.
    waiting = {dask.submit(fly_one, task._replace(campaign=name), key="flight-%s-%d" % (name, i), pure=False): task
               for i, task in enumerate(tasks)}
    try:
        for future in as_completed(list(waiting)):
            task = waiting.pop(future)
            flown(task, _result(future, task))
            future.release()
    except BaseException:
        with contextlib.suppress(OSError):  # without a scheduler flights end by their own limits
            dask.cancel(list(waiting))
            _stop(dask, name)
        raise


def _stop(dask: Any, name: str) -> None:
    """Stops the flights in the air, which Dask cannot cancel because threads wait for them, and waits for their end."""
    dask.run(stop_flights, name)
    deadline = time.monotonic() + _END_LIMIT_S
    while sum(dask.run(num_flying, name).values()) > 0 and time.monotonic() < deadline:
        time.sleep(0.2)


def _result(future: Any, task: FlightTask) -> FlightResult:
    if future.cancelled():
        raise CampaignError("the Dask scheduler was lost; the same command goes on with the campaign")
    error = future.exception()
    if error is None:
        return future.result()  # type: ignore[no-any-return]
    return FlightResult(row_of(task, "crashed: %s: %s" % (type(error).__name__, error)), {})
