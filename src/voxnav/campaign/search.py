# SPDX-License-Identifier: BSD-3-Clause
"""Searches parameters with Optuna: each trial flies the same grid with other values of some parameters."""

from __future__ import annotations

import copy
import hashlib
import json
import os
from typing import Any, Callable, Dict, NamedTuple, Sequence, Union

import yaml

from voxnav.campaign.errors import CampaignError
from voxnav.campaign.progress import say
from voxnav.campaign.rows import FlightRow
from voxnav.demo.mission import repository_file

_RANGE_KEYS = {"low", "high", "step", "log"}
_CHOICE_KEYS = {"choices"}
# Values of parameters by their path, such as ("planning_manager", "search", "weight").
Values = Dict[str, Union[float, int, str, bool]]


class ParameterSpace(NamedTuple):
    """What is searched. parameters: path with "/" -> range (low, high, and step or log) or choices; min_clearance_m:
    a flight that comes nearer counts as failed; seed: of the sampler."""

    parameters: dict[str, dict[str, Any]]
    min_clearance_m: float
    seed: int


def read_space(path: str) -> ParameterSpace:
    """Reads a YAML file with parameters, nested as in config/<node>.yaml, min_clearance_m and seed."""
    try:
        with open(path) as source:
            content = yaml.safe_load(source)
        unknown = set(content) - {"parameters", "min_clearance_m", "seed"}
        if unknown:
            raise CampaignError("%s: unknown %s" % (path, ", ".join(sorted(unknown))))
        space = ParameterSpace(dict(_leaves(content["parameters"], ())), float(content.get("min_clearance_m", 0.0)),
                               int(content.get("seed", 1)))
    except (OSError, yaml.YAMLError, KeyError, TypeError, ValueError) as error:
        raise CampaignError("%s cannot be read as a space of parameters: %r" % (path, error)) from error
    for name in space.parameters:
        _check_exists(path, name)
    return space


def _check_exists(path: str, name: str) -> None:
    """Raises CampaignError unless the configuration of a node has the parameter: nodes stop at one they do not know."""
    node, *keys = name.split("/")
    try:
        with open(repository_file("config/%s.yaml" % node)) as source:
            content = yaml.safe_load(source)
    except FileNotFoundError as error:
        raise CampaignError("%s: there is no node %s with a file in config/" % (path, node)) from error
    for key in keys:
        if not isinstance(content, dict) or key not in content:
            raise CampaignError("%s: config/%s.yaml has no parameter %s" % (path, node, "/".join(keys)))
        content = content[key]


def _leaves(node: Any, path: tuple[str, ...]) -> Any:
    """Yields (path, range) of every parameter. Raises CampaignError."""
    if not isinstance(node, dict) or not node:
        raise CampaignError("parameter %s: a range {low: 1.0, high: 2.0} or {choices: [...]} is expected" %
                            "/".join(path))
    if set(node) == _CHOICE_KEYS or {"low", "high"} <= set(node) <= _RANGE_KEYS:
        yield "/".join(path), node
        return
    for key, child in node.items():
        yield from _leaves(child, path + (str(key),))


def merged(config: str, values: Values) -> str:
    """Returns the YAML text of a configuration with some of its values replaced."""
    content = copy.deepcopy(yaml.safe_load(config) or {}) if config else {}
    for path, value in values.items():
        *parents, last = path.split("/")
        node = content
        for key in parents:
            node = node.setdefault(key, {})
        node[last] = value
    return str(yaml.safe_dump(content, default_flow_style=False, sort_keys=True))


def score(rows: Sequence[FlightRow], min_clearance_m: float) -> float:
    """Returns the mean speed over all flights in m/s, in which a flight that failed or came too near counts as 0."""
    def one(row: FlightRow) -> float:
        is_good = row.is_success and row.min_clearance_m is not None and row.min_clearance_m >= min_clearance_m
        return row.mean_speed_mps or 0.0 if is_good else 0.0
    return sum(one(row) for row in rows) / len(rows)


def trial_folder(values: Values) -> str:
    """Returns the name of the folder of a trial, which is that of its values: equal values are not flown twice."""
    return hashlib.sha256(json.dumps(values, sort_keys=True).encode()).hexdigest()[:12]


def _optuna() -> Any:
    try:
        import optuna
    except ImportError as error:
        raise CampaignError("the search of parameters needs Optuna (package python3-optuna of Debian 12 and Ubuntu "
                            "24.04; elsewhere `pip install optuna`): %s" % error) from error
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    return optuna


def search(out: str, space: ParameterSpace, num_trials: int, measure: Callable[[Values], float]) -> Values:
    """Runs trials until the study of the folder has num_trials that are finished. Returns the best values.

    measure: flies the grid with some values, and returns the score. An interrupted trial is taken up again.
    """
    optuna = _optuna()
    os.makedirs(out, exist_ok=True)
    study = optuna.create_study(direction="maximize", study_name="voxnav", load_if_exists=True,
                                storage="sqlite:///" + os.path.abspath(os.path.join(out, "study.db")))
    states = optuna.trial.TrialState
    for trial in study.get_trials(states=(states.RUNNING,)):
        study.tell(trial.number, state=states.FAIL)
        study.enqueue_trial(trial.params)
    finished = len(study.get_trials(states=(states.COMPLETE,)))
    # A sampler whose seed did not change would repeat its first values when a search goes on.
    study.sampler = optuna.samplers.TPESampler(seed=space.seed + finished)
    while finished < num_trials:
        trial = study.ask()
        values = {path: _suggest(trial, path, span) for path, span in space.parameters.items()}
        say("trial %d of %d: %s" % (finished + 1, num_trials, _words(values)))
        value = measure(values)
        study.tell(trial, value)
        finished += 1
        say("trial %d of %d: score %.3f m/s, best %.3f m/s" % (finished, num_trials, value, study.best_value))
    return dict(study.best_params)


def _suggest(trial: Any, path: str, span: dict[str, Any]) -> Any:
    if "choices" in span:
        return trial.suggest_categorical(path, span["choices"])
    low, high, step, log = span["low"], span["high"], span.get("step"), bool(span.get("log", False))
    if all(isinstance(value, int) for value in (low, high, 1 if step is None else step)):
        return trial.suggest_int(path, low, high, step=step or 1, log=log)
    return trial.suggest_float(path, low, high, step=step, log=log)


def _words(values: Values) -> str:
    return ", ".join("%s = %s" % item for item in sorted(values.items()))
