# SPDX-License-Identifier: BSD-3-Clause
"""The folder of a campaign: its results, the worlds it flies in, its settings, and what its flights leave."""

from __future__ import annotations

import json
import os
from typing import Any, Sequence

from voxnav.campaign.errors import CampaignError
from voxnav.campaign.flight import FlightResult, replay_command
from voxnav.campaign.grid import FlightTask
from voxnav.campaign.progress import CampaignProgress, say
from voxnav.campaign.report import write_report
from voxnav.campaign.results import FlightResults
from voxnav.campaign.rows import FlightRow, key_of_task
from voxnav.campaign.runner import Fly, run
from voxnav.campaign.worlds import WorldText


class CampaignFolder:
    """A folder that is made, or that an earlier run with the same settings has left.

    like: a task with the settings that all flights share. Raises CampaignError if the folder was made with others.
    """

    def __init__(self, path: str, like: FlightTask) -> None:
        self.path, self._like = path, like
        os.makedirs(path, exist_ok=True)
        self._keep("settings.json", json.dumps({"limit_s": like.limit_s, "config": like.config}, indent=1) + "\n")
        if like.config:
            self._keep("config.yaml", like.config)

    def _keep(self, name: str, text: str) -> None:
        """Writes a file of which all flights of the folder depend, or compares it with the one that is there."""
        path = os.path.join(self.path, name)
        if os.path.exists(path):
            with open(path) as source:
                if source.read() != text:
                    raise CampaignError("the flights in %s were flown with another %s; choose another folder" % (
                        self.path, name))
            return
        os.makedirs(os.path.dirname(path), exist_ok=True)
        with open(path + ".part", "w") as out:
            out.write(text)
        os.replace(path + ".part", path)

    def fly(self, dask: Any, tasks: Sequence[FlightTask], fly_one: Fly) -> list[FlightRow]:
        """Flies those tasks whose rows are not in flights.csv. Returns the rows of all tasks, in their order.

        The report is written at the end, and also if the campaign is interrupted.
        """
        for world in {task.world for task in tasks}:
            self._keep(_world_name(world), world.text)
        with FlightResults(os.path.join(self.path, "flights.csv")) as results:
            if results.repaired:
                say(results.repaired)
            missing = [task for task in tasks if key_of_task(task) not in results.keys()]
            if len(missing) < len(tasks):
                say("%d of %d flights are in %s" % (len(tasks) - len(missing), len(tasks), results.path))
            progress = CampaignProgress(len(missing))

            def flown(task: FlightTask, result: FlightResult) -> None:
                self._keep_files(task, result.files)
                results.append(result.row)
                progress.add(result.row)
            try:
                run(dask, missing, flown, fly_one)
            finally:
                report = os.path.join(self.path, "report.html")
                if results.rows and (missing or not os.path.exists(report)):
                    write_report(report, results.rows, self.replay, self.picture)
            by_key = {row.key: row for row in results.rows}
            return [by_key[key_of_task(task)] for task in tasks]

    def _keep_files(self, task: FlightTask, files: dict[str, bytes]) -> None:
        folder = os.path.join(self.path, "flights", task.name)
        os.makedirs(folder, exist_ok=True)
        for name, content in files.items():
            with open(os.path.join(folder, name), "wb") as out:
                out.write(content)

    def replay(self, row: FlightRow) -> str:
        """Returns the command that flies a flight of this folder again."""
        task = self._task_of(row)
        config = os.path.join(self.path, "config.yaml") if task.config else ""
        return replay_command(task, os.path.join(self.path, _world_name(task.world)), config,
                              os.path.join(self.path, "replays", task.name))

    def picture(self, row: FlightRow) -> bytes | None:
        path = os.path.join(self.path, "flights", self._task_of(row).name, "top_view.png")
        if not os.path.exists(path):
            return None
        with open(path, "rb") as source:
            return source.read()

    def _task_of(self, row: FlightRow) -> FlightTask:
        return self._like._replace(world=WorldText(row.world, "", row.trees_per_ha), seed=row.seed,
                                   speed_mps=row.speed_mps, has_faults=row.faults)


def _world_name(world: WorldText) -> str:
    return os.path.join("worlds", "%s_%gtrees.yaml" % (world.name, world.trees_per_ha))
