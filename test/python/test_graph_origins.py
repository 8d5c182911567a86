# SPDX-License-Identifier: BSD-3-Clause
"""What was expressed in one origin of the odometry is expressed in the next, or refused; the map does not move."""

import numpy as np
import pytest

import voxnav
from voxnav.optimizer_session import OptimizerSession, SubmapRecord

origins = pytest.importorskip("voxnav.nodes.graph_origins")
Change = origins.Change


def pose(x, y, z, yaw):
    return voxnav.pose_from_yaw(np.array([x, y, z], dtype=float), yaw)


A_B, B_C = pose(3.0, -2.0, 1.0, 0.3), pose(-5.0, 4.0, 0.5, -1.0)  # where the second origin is in the first


def message(frame, previous="", T_O_previous=None):
    msgs, poses = pytest.importorskip("voxnav.msg"), pytest.importorskip("voxnav.nodes.poses")
    out = msgs.OdometryOrigin(previous_frame=previous, is_related=T_O_previous is not None,
                              T_O_previous=poses.pose_to_msg(np.eye(4) if T_O_previous is None else T_O_previous))
    out.header.frame_id = frame
    return out


def test_the_first_message_names_the_origin_and_a_repeated_one_changes_nothing():
    seen = origins.GraphOrigins("odom")
    for _ in range(2):
        assert seen.follow(message("a", "z", A_B)) == (Change.NONE, None) and seen.frame == "a"
    assert np.array_equal(seen.into("a"), np.eye(4)) and np.array_equal(seen.into(""), np.eye(4))


def test_a_pose_in_the_newest_origin_stays_as_it_is_to_the_last_bit():
    T = pose(1.0, 2.0, 3.0, 0.4)
    T[2, 3] = -0.0
    seen = origins.GraphOrigins("a")
    assert np.signbit(seen.express("a", T)[2, 3]) and np.signbit(seen.express("", T)[2, 3])
    seen.follow(message("a"))
    seen.follow(message("b", "a", np.linalg.inv(A_B)))
    assert np.allclose(seen.express("a", T), np.linalg.inv(A_B) @ T)


def test_poses_in_former_origins_are_expressed_in_the_newest():
    seen = origins.GraphOrigins("")
    seen.follow(message("a"))
    change, T_b_a = seen.follow(message("b", "a", np.linalg.inv(A_B)))
    assert change is Change.RELATED and np.allclose(T_b_a, np.linalg.inv(A_B)) and seen.frame == "b"
    assert np.allclose(seen.into("a"), T_b_a)
    change, T_c_b = seen.follow(message("c", "b", np.linalg.inv(B_C)))
    assert change is Change.RELATED and np.allclose(seen.into("a"), T_c_b @ T_b_a)
    change, back = seen.follow(message("a", "c", A_B @ B_C))
    assert change is Change.RELATED and np.allclose(back @ seen.into("a"), A_B @ B_C)
    assert np.allclose(seen.into("b"), A_B) and np.array_equal(seen.into("a"), np.eye(4))


@pytest.mark.parametrize("other", [message("b"), message("b", "a"), message("b", "never heard of", A_B)],
                         ids=["restarted mapper", "no transform", "a change was missed"])
def test_an_origin_that_does_not_relate_is_told_and_former_poses_are_refused(other):
    seen = origins.GraphOrigins("a")
    seen.into("a")
    seen.follow(message("a"))
    assert seen.follow(other) == (Change.UNRELATED, None) and seen.frame == "b"
    with pytest.raises(ValueError, match="frame a does not relate to b"):
        seen.into("a")


def record(number, T_O_S):
    return SubmapRecord(number, 10.0 * number, 10.0 * number + 9.0, T_O_S, np.array([10.0 * number]),
                        np.eye(4).reshape(1, 4, 4))


def test_the_map_does_not_move_when_its_odometry_gets_another_origin():
    """Two flights, one of which changes its origin halfway, give the same map."""
    same, changed = OptimizerSession(), OptimizerSession()
    way = [pose(4.0 * i, 0.5 * i, 2.0, 0.1 * i) for i in range(4)]
    for number in (0, 1):
        same.add_submap(record(number, way[number]))
        changed.add_submap(record(number, way[number]))
    same.optimize()
    changed.optimize()
    before = {number: T.copy() for number, T in changed.graph.poses().items()}
    T_B_A = np.linalg.inv(A_B)
    body_A = pose(6.0, 1.0, 2.0, 0.4)
    in_W = changed.T_W_O @ body_A
    changed.change_origin(T_B_A)
    assert np.allclose(changed.T_W_O @ T_B_A @ body_A, in_W)
    assert all(np.allclose(T, before[number]) for number, T in changed.graph.poses().items())
    for number in (2, 3):
        same.add_submap(record(number, way[number]))
        changed.add_submap(record(number, T_B_A @ way[number]))
    same.optimize()
    changed.optimize()
    for number, T in same.graph.poses().items():
        assert np.allclose(T, changed.graph.poses()[number], atol=1e-6)
    assert np.allclose(same.T_W_O, changed.T_W_O @ T_B_A, atol=1e-6)
    assert np.allclose(same.trajectory()[1], changed.trajectory()[1], atol=1e-6)
