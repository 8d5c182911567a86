# SPDX-License-Identifier: BSD-3-Clause
"""Poses that a recording has on /tf only are mapped as those of odometry messages; joints are not taken for poses."""

import json

import numpy as np
import pytest

pytest.importorskip("voxnav.simulation")
pytest.importorskip("rosbag")

import voxnav  # noqa: E402
from recordings import (SWEEP_S, body_pose, flight, imu_message, link, of_topic, sweeps,  # noqa: E402
                        write_messages)
from voxnav import files, simulation  # noqa: E402
from voxnav.offline.check import main as check_recording  # noqa: E402
from voxnav.offline.cli import NOT_COVERED, main as map_bag  # noqa: E402

NUM_SCANS, FIRST_S = 12, 100.0
TIMES_S = np.arange(0.9, 1.3 + SWEEP_S * NUM_SCANS, 0.02)


@pytest.fixture(scope="module")
def scans():
    return sweeps(num_scans=NUM_SCANS)


def sent(parent, child, T_of, times_s=TIMES_S):
    """Messages of a link that moves. T_of: its transform at a time of the flight."""
    return [[t + FIRST_S - 1.0, "/tf", link(parent, child, T_of(t), t + FIRST_S - 1.0)] for t in times_s]


def recording(scans, links):
    return flight(scans[1], with_odometry=False, first_stamp_s=FIRST_S) + links


class Run:
    """A run of map_bag on messages, and its results."""

    def __init__(self, tmp_path, messages, config="", name="flight"):
        self.bag, self.out = write_messages(str(tmp_path / (name + ".bag")), messages), str(tmp_path / name)
        path = tmp_path / (name + ".yaml")
        path.write_text("run: {write_mesh: false%s}\n" % config)
        self.status = map_bag([self.bag, "--config", str(path), "--out", self.out])
        if self.status in (0, NOT_COVERED):
            with open(self.out + "/metrics.json") as source:
                self.metrics = json.load(source)
            self.stamps, self.poses = files.read_tum(self.out + "/trajectory_odom.txt")

    def error_m(self):
        """Returns the largest distance from the true trajectory; a pose holds for the middle of its sweep."""
        return max(np.linalg.norm((T - body_pose(t - FIRST_S + 1.0 + 0.5 * SWEEP_S))[:3, 3])
                   for t, T in zip(self.stamps, self.poses))

    def share_right(self, world):
        points = voxnav.SubmapCollection.load(self.out + "/map").occupied_points().astype(np.float64)
        return np.mean(world.surface_distance(points) < 0.2)


def test_one_moving_link_is_mapped_as_odometry_messages_of_the_same_poses_are(scans, tmp_path, capsys):
    run = Run(tmp_path, recording(scans, sent("odom", "body", body_pose)))
    said = capsys.readouterr().out
    assert run.status == 0 and run.metrics["counts"]["scans"] == NUM_SCANS and run.metrics["left_out"] == []
    assert "transforms odom -> body (50 Hz), because no topic has odometry" in said
    odometry = Run(tmp_path, flight(scans[1], first_stamp_s=FIRST_S), name="odometry")
    assert np.array_equal(run.stamps, odometry.stamps)
    assert np.allclose(run.poses, odometry.poses, atol=1e-5)
    assert run.share_right(scans[0]) == pytest.approx(odometry.share_right(scans[0]), abs=1e-3)
    assert check_recording([run.bag]) == 0


def test_links_of_different_rates_are_composed_and_corrections_of_drift_are_not_taken(scans, tmp_path, capsys):
    def foot(t):
        return simulation.pose(2.0 * t, 0.0, 0.0, 0.3 * t)
    links = sent("odom", "foot", foot)
    links += sent("foot", "body", lambda t: np.linalg.inv(foot(t)) @ body_pose(t), TIMES_S[::3])
    # The map jumps against the odometry, which is no motion of the vehicle.
    links += sent("map", "odom", lambda t: simulation.pose(0.5 * (t > 1.5), 0.0, 0.0), TIMES_S[::5])
    # A link that stands still is static, so that the height has to move.
    for i, message in enumerate(of_topic(links, "/tf")):
        transform = message[2].transforms[0]
        if transform.child_frame_id == "body":
            transform.transform.translation.z += 1e-2 * (i % 2)
    run = Run(tmp_path, recording(scans, links))
    assert "transforms odom -> foot -> body" in capsys.readouterr().out
    assert run.status == 0 and run.metrics["counts"]["scans"] == NUM_SCANS
    assert run.error_m() < 0.06 and run.share_right(scans[0]) > 0.95
    corrected = Run(tmp_path, recording(scans, links), ", odometry_frame: map", name="corrected")
    assert "transforms map -> odom -> foot -> body" in capsys.readouterr().out
    assert corrected.poses[-1][0, 3] == pytest.approx(run.poses[-1][0, 3] + 0.5, abs=1e-3)


def test_the_inverted_tree_of_the_mrs_system_is_understood(scans, tmp_path, capsys):
    links = sent("body", "gnss_odom", lambda t: np.linalg.inv(body_pose(t)))
    links += sent("body", "propeller", lambda t: simulation.pose(0.2, 0.2, 0.0, 40.0 * t))
    run = Run(tmp_path, recording(scans, links))
    assert "transforms gnss_odom -> body" in capsys.readouterr().out
    assert run.status == 0 and run.error_m() < 0.06 and run.share_right(scans[0]) > 0.95


@pytest.mark.parametrize("spoil, word", [
    (lambda msg: setattr(msg.transforms[0].transform.translation, "x", float("nan")), "finite"),
    (lambda msg: setattr(msg.transforms[0].header.stamp, "secs", 9000), "alone")])
def test_a_wrong_transform_loses_only_itself(spoil, word, scans, tmp_path):
    links = sent("odom", "body", body_pose)
    spoil(links[20][2])
    run = Run(tmp_path, recording(scans, links))
    assert run.status == 0 and run.metrics["counts"]["scans"] == NUM_SCANS and run.error_m() < 0.06
    assert [(row["what"].split()[0], row["count"]) for row in run.metrics["left_out"]] == [("transform", 1)]
    assert word in run.metrics["left_out_lines"][0]


def test_transforms_from_before_the_clock_was_set_are_used(scans, tmp_path):
    messages = recording(scans, sent("odom", "body", body_pose))
    for record_s, topic, msg in messages:
        if record_s < FIRST_S + 0.5 and topic != "/tf_static":
            (msg.transforms[0] if topic == "/tf" else msg).header.stamp.secs += 3600
    run = Run(tmp_path, messages)
    assert run.status == 0 and run.metrics["counts"]["scans"] == NUM_SCANS and run.error_m() < 0.06
    assert "was set by" in "\n".join(run.metrics["warnings"])


def test_transforms_that_end_early_are_followed_by_lidar_odometry(scans, tmp_path):
    links = sent("odom", "body", body_pose, TIMES_S[TIMES_S < 1.7])
    run = Run(tmp_path, recording(scans, links))
    assert run.status == 0 and run.metrics["counts"]["scans"] >= NUM_SCANS - 1
    assert "to the end" in "\n".join(run.metrics["warnings"]) and run.error_m() < 0.1
    alone = Run(tmp_path, recording(scans, links), ", pose_source: recording", name="alone")
    assert alone.status == NOT_COVERED and alone.metrics["counts"]["scans"] < NUM_SCANS


def test_a_joint_that_turns_the_lidar_is_not_taken_for_the_way_of_the_vehicle(scans, tmp_path, capsys):
    messages = [m for m in recording(scans, []) if m[1] != "/tf_static"]
    messages += sent("base", "lidar", lambda t: simulation.pose(0.1, 0.0, 0.2, 2.0 * t))
    bag = write_messages(str(tmp_path / "flight.bag"), messages)
    check_recording([bag])
    said = capsys.readouterr().out
    assert "the recording has no odometry: poses come from LiDAR odometry" in said and "transforms base" not in said


def test_a_large_recording_is_looked_at_in_windows_and_mapped_whole(scans, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("voxnav.recordings.survey._WHOLE_BYTES", 1000)
    monkeypatch.setattr("voxnav.recordings.survey._MAX_TF_MESSAGES", 10)
    monkeypatch.setattr("voxnav.recordings.survey._BEGIN_S", 0.4)
    monkeypatch.setattr("voxnav.recordings.survey._WINDOW_S", 0.1)
    monkeypatch.setattr("voxnav.recordings.survey._NUM_WINDOWS", 3)
    run = Run(tmp_path, recording(scans, sent("odom", "body", body_pose)))
    said = capsys.readouterr().out
    assert "looked at in windows" in said and "transforms odom -> body (50 Hz)" in said and "silent" not in said
    assert run.status == 0 and run.metrics["counts"]["scans"] == NUM_SCANS and run.error_m() < 0.06


def test_a_frame_without_transforms_to_it_is_refused_by_name(scans, tmp_path, capsys):
    run = Run(tmp_path, recording(scans, sent("odom", "body", body_pose)), ", odometry_frame: world")
    assert run.status == 1
    error = capsys.readouterr().err
    assert "'world' (run/odometry_frame)" in error and "body, lidar, odom" in error


def test_positions_in_utm_on_tf_are_shifted_to_the_origin(scans, tmp_path):
    far = simulation.pose(465000.0, 5580000.0, 0.0)
    run = Run(tmp_path, recording(scans, sent("utm", "body", lambda t: far @ body_pose(t))))
    assert run.status == 0 and np.all(np.array(run.metrics["origin_m"])[:2] > 4e5)
    assert np.abs(run.poses[:, :3, 3]).max() < 50.0


def test_an_imu_on_the_body_stays_usable(scans, tmp_path, capsys):
    messages = recording(scans, sent("odom", "body", body_pose))
    messages += [[t + FIRST_S - 1.0, "/imu", imu_message(t + FIRST_S - 1.0)] for t in np.arange(0.9, 2.5, 0.005)]
    assert check_recording([write_messages(str(tmp_path / "flight.bag"), messages)]) == 0
    assert "on 'body': transforms body -> lidar" in capsys.readouterr().out
