# SPDX-License-Identifier: BSD-3-Clause
"""The numbers that voxnav gives its trajectories, by which they are told apart from those of other nodes.

MRS repeats the input_id of the tracker's last trajectory in its prediction. Other nodes leave it at zero or count from
there, so voxnav counts from a large number. The trackers keep it in 32 bits.
"""

FIRST_ID, LAST_ID = 1_987_000_000, 2_147_000_000


def is_own(input_id: int) -> bool:
    """Returns True if a trajectory of this number is one of voxnav, perhaps from before the node was restarted."""
    return FIRST_ID <= input_id <= LAST_ID


def after(input_id: int) -> int:
    """Returns the number that follows the given one of voxnav."""
    return FIRST_ID if input_id >= LAST_ID else input_id + 1
