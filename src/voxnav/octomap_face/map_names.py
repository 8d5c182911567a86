# SPDX-License-Identifier: BSD-3-Clause
"""Names of maps, as mrs_octomap_server takes them: a file NAME.ot in one folder."""

import os
import re
from typing import List

NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_-]{0,99}")
ENDING = ".ot"


class MapNameError(ValueError):
    """The name cannot be that of a map; the text says why."""


def map_path(folder: str, name: str) -> str:
    """Returns the path of a map. folder: may begin with ~. Raises MapNameError for what is no plain name."""
    if not NAME.fullmatch(name):
        raise MapNameError("'%s' is no name of a map: letters, digits, _ and - only, and 100 at most" % name[:200])
    folder = os.path.realpath(os.path.expanduser(folder))
    path = os.path.join(folder, name + ENDING)
    if os.path.realpath(path) != path:
        raise MapNameError("%s is a link, which is not followed" % path)
    return path


def backup_path(path: str) -> str:
    """Returns where the last version of a map is kept while it is replaced."""
    return path[:-len(ENDING)] + "_backup" + ENDING


def unfinished_path(path: str) -> str:
    """Returns where a map is written before it replaces the last version."""
    return path[:-len(ENDING)] + ".unfinished" + ENDING


def replace_with_backup(unfinished: str, path: str) -> None:
    """Gives a written map its name; the last version becomes the backup.

    At every moment one of the two files is a whole map. Raises OSError.
    """
    if os.path.exists(path):
        os.replace(path, backup_path(path))
    os.replace(unfinished, path)


def known_names(folder: str) -> List[str]:
    """Returns the names of the maps in a folder, sorted."""
    folder = os.path.expanduser(folder)
    if not os.path.isdir(folder):
        return []
    names = [entry[:-len(ENDING)] for entry in os.listdir(folder) if entry.endswith(ENDING)]
    return sorted(name for name in names if NAME.fullmatch(name))
