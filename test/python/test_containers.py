# SPDX-License-Identifier: BSD-3-Clause
import numpy as np
import pytest

import voxnav


def random_grid(seed):
    states = np.random.RandomState(seed).randint(0, 3, (20, 18, 9)).astype(np.int8)
    return states, voxnav.StateGrid.from_array(states, (-4.0, 0.0, 0.4), 0.4)


def test_snapshot_applied_to_another_grid_gives_the_same_states():
    _, source = random_grid(1)
    _, copy = random_grid(2)
    copy.apply_update(**source.snapshot())
    points = np.random.RandomState(3).uniform(-6, 6, (2000, 3)).astype(np.float32)
    np.testing.assert_array_equal(source.states(points), copy.states(points))


def test_apply_update_takes_message_fields_as_rospy_gives_them():
    _, source = random_grid(1)
    update = source.snapshot()
    grid = voxnav.StateGrid(0.4)
    grid.apply_update(list(update["block_indices"].ravel()), update["states"], [], True)
    assert grid.num_blocks == source.num_blocks
    grid.apply_update([], b"", list(update["block_indices"].ravel()), False)
    assert grid.num_blocks == 0


def test_apply_update_refuses_lengths_that_do_not_match():
    grid = voxnav.StateGrid(0.4)
    with pytest.raises(ValueError, match="bytes of states"):
        grid.apply_update([0, 0, 0], b"\0" * 1023, [], False)


def test_centers_are_where_the_states_are():
    states, grid = random_grid(1)
    centers = grid.centers(2)
    assert centers.shape == ((states == 2).sum(), 3)
    assert (grid.states(centers) == 2).all()
