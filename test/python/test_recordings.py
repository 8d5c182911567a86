# SPDX-License-Identifier: BSD-3-Clause
"""A fault in a recording loses only the messages that it concerns, and it is counted and named."""

import copy
import json
import re

import numpy as np
import pytest

pytest.importorskip("voxnav.simulation")
pytest.importorskip("rosbag")

import voxnav  # noqa: E402
from recordings import (MOUNT, SWEEP_S, body_pose, flight, link, of_topic, odometry_message,  # noqa: E402
                        sweeps, write_messages)
from voxnav import files  # noqa: E402
from voxnav.offline.check import main as check_recording  # noqa: E402
from voxnav.offline.cli import NOT_COVERED, main as map_bag  # noqa: E402
from voxnav.offline.configs import mount_of  # noqa: E402

NUM_SCANS, FIRST_S = 14, 100.0
CONFIG = "run: {write_mesh: false%s}\nschedule: {period_s: 0.7, min_period_s: 0.5}\n"


@pytest.fixture(scope="module")
def scans():
    return sweeps(num_scans=NUM_SCANS)


class Run:
    """A run of map_bag on a bag of messages, and its results."""

    def __init__(self, tmp_path, messages, *options, run="", name="flight"):
        bag, config, out = (str(tmp_path / (name + end)) for end in (".bag", ".yaml", ""))
        with open(config, "w") as target:
            target.write(CONFIG % (", " + run if run else ""))
        write_messages(bag, messages)
        self.bag, self.out = bag, out
        self.status = map_bag([bag, "--config", config, "--out", out] + list(options))
        self.metrics = {}
        if self.status in (0, NOT_COVERED):
            with open(out + "/metrics.json") as source:
                self.metrics = json.load(source)

    @property
    def num_scans(self):
        return self.metrics["counts"]["scans"]

    @property
    def left_out(self):
        return "\n".join(self.metrics["left_out_lines"])

    @property
    def warnings(self):
        return "\n".join(self.metrics["warnings"])

    def share_right(self, world, T_W_O=np.eye(4)):
        """Returns the share of the map's points within half a voxel of the true surface."""
        points = voxnav.SubmapCollection.load(self.out + "/map").occupied_points().astype(np.float64)
        assert len(points) > 100
        return np.mean(world.surface_distance(points @ T_W_O[:3, :3].T + T_W_O[:3, 3]) < 0.2)

    def error_m(self):
        """Returns the largest distance from the true trajectory; a pose holds for the middle of its sweep."""
        stamps, poses = files.read_tum(self.out + "/trajectory_odom.txt")
        return max(np.linalg.norm((T - body_pose(t - FIRST_S + 1.0 + 0.5 * SWEEP_S))[:3, 3])
                   for t, T in zip(stamps, poses))


def good(scans, **options):
    return flight(scans[1], first_stamp_s=FIRST_S, **options)


def moved(msg, seconds):
    """Returns a copy of a message with a later stamp."""
    import rospy

    out = copy.copy(msg)
    out.header = copy.deepcopy(msg.header)
    out.header.stamp += rospy.Duration.from_sec(seconds)
    return out


def spoil_pose(msg, **values):
    for name, value in values.items():
        setattr(msg.pose.pose.position if name in "xyz" else msg.pose.pose.orientation, name.strip("_"), value)


def no_quaternion(msg):
    spoil_pose(msg, _x=0.0, _y=0.0, _z=0.0, _w=0.0)
    msg.pose.pose.orientation.x = msg.pose.pose.orientation.y = msg.pose.pose.orientation.z = 0.0


def all_nan(msg):
    rows = np.frombuffer(msg.data, np.uint8).reshape(-1, msg.point_step).copy()
    rows[:, :12] = np.frombuffer(np.full(3, np.nan, "<f4").tobytes(), np.uint8)
    msg.data = rows.tobytes()


BROKEN = {
    "odometry with a NaN position": ("/odom", lambda msg: spoil_pose(msg, x=float("nan")), "odometry", "finite"),
    "odometry with a NaN quaternion": ("/odom", lambda msg: spoil_pose(msg, w=float("nan")), "odometry", "finite"),
    "odometry without rotation": ("/odom", no_quaternion, "odometry", "quaternion"),
    "odometry with a pose far off": ("/odom", lambda msg: spoil_pose(msg, x=60.0), "odometry", "alone"),
    "odometry of another body": ("/odom", lambda msg: setattr(msg, "child_frame_id", "gps"), "odometry", "'gps'"),
    "cloud of another frame": ("/points", lambda msg: setattr(msg.header, "frame_id", "map"), "cloud", "'map'"),
    "cloud cut short": ("/points", lambda msg: setattr(msg, "data", msg.data[:len(msg.data) // 2]), "cloud", "bytes"),
    "cloud without fields": ("/points", lambda msg: setattr(msg, "fields", []), "cloud", "'x' is missing"),
    "cloud without points": ("/points", lambda msg: (setattr(msg, "width", 0), setattr(msg, "data", b"")), "cloud",
                             "no points"),
    "cloud of NaN": ("/points", all_nan, "cloud", "nan"),
    "big-endian cloud": ("/points", lambda msg: setattr(msg, "is_bigendian", True), "cloud", "big-endian"),
    "cloud with a field beyond its points": ("/points", lambda msg: setattr(msg.fields[2], "offset", 4000), "cloud",
                                             "field 'z'"),
}


@pytest.mark.parametrize("which", [1, 6])
@pytest.mark.parametrize("fault", sorted(BROKEN))
def test_a_faulty_message_loses_only_itself(fault, which, scans, tmp_path, capsys):
    topic, spoil, what, word = BROKEN[fault]
    messages = good(scans)
    spoil(of_topic(messages, topic)[which][2])
    run = Run(tmp_path, messages)
    assert run.status == 0
    assert run.num_scans == NUM_SCANS - (what == "cloud")
    assert len(run.metrics["left_out"]) == 1 and run.metrics["left_out"][0]["count"] == 1
    assert run.metrics["left_out"][0]["what"] == what and word in run.metrics["left_out"][0]["reason"].lower()
    assert capsys.readouterr().out.rstrip().endswith(run.metrics["left_out_lines"][-1])  # losses are printed last
    assert run.metrics["left_out_lines"][0] in run.metrics["warnings"]
    with open(run.out + "/report.html") as source:
        assert "What was left out" in source.read()


@pytest.mark.parametrize("place", ["somewhere", "the header of a chunk", "the index of a chunk"])
def test_a_damaged_part_of_the_file_loses_only_the_messages_in_it(place, scans, tmp_path):
    bag = write_messages(str(tmp_path / "flight.bag"), good(scans), "bz2")
    with open(bag, "rb") as source:
        content = bytearray(source.read())
    begin = len(content) // 2
    if place != "somewhere":
        begin = content.find(b"op=\x05" if place == "the header of a chunk" else b"op=\x04", begin)
    content[begin:begin + 100] = bytes(100)
    with open(bag, "wb") as out:
        out.write(content)
    assert map_bag([bag, "--out", str(tmp_path / "out")]) in (0, NOT_COVERED)
    metrics = json.loads((tmp_path / "out" / "metrics.json").read_text())
    num = metrics["counts"]["scans"]
    assert NUM_SCANS - 4 <= num <= NUM_SCANS
    if place == "the index of a chunk":
        assert num == NUM_SCANS
    else:
        assert "part of the file is damaged" in metrics["left_out_lines"][0]


@pytest.mark.parametrize("topic, number", [("/points", 5), ("/points", 0), ("/odom", 20), ("/odom", 0)])
@pytest.mark.parametrize("away_s", [3600.0, -90.0])
def test_a_lone_stamp_on_another_clock_loses_only_its_message(topic, number, away_s, scans, tmp_path):
    import rospy

    messages = good(scans)
    msg = of_topic(messages, topic)[number][2]
    msg.header.stamp += rospy.Duration.from_sec(away_s)
    run = Run(tmp_path, messages)
    assert run.status == 0 and run.num_scans == NUM_SCANS - (topic == "/points")
    assert run.metrics["left_out"][0]["count"] == 1 and "alone" in run.left_out
    assert run.error_m() < 0.06


@pytest.mark.parametrize("topic", ["/points", "/odom"])
def test_messages_from_before_the_clock_was_set_are_used(topic, scans, tmp_path):
    import rospy

    messages = good(scans)
    for message in of_topic(messages, topic)[:5]:
        message[2].header.stamp += rospy.Duration.from_sec(3600.0)
    run = Run(tmp_path, messages)
    assert run.status == 0 and run.num_scans == NUM_SCANS and run.error_m() < 0.06
    assert "was set by" in run.warnings


def test_a_recorder_whose_clock_was_set_while_it_recorded_is_understood(scans, tmp_path):
    import rospy

    messages = sorted(good(scans), key=lambda message: message[0])
    for message in messages:
        if message[0] < FIRST_S + 0.52:
            message[0] += 3600.0
            if message[1] != "/tf_static":
                message[2].header.stamp += rospy.Duration.from_sec(3600.0)
    bag = write_messages(str(tmp_path / "flight.bag"), messages, is_sorted=False)
    assert map_bag([bag, "--out", str(tmp_path / "out")]) == 0
    run = Run.__new__(Run)
    run.out = str(tmp_path / "out")
    assert len(files.read_tum(run.out + "/trajectory_odom.txt")[0]) == NUM_SCANS and run.error_m() < 0.1
    assert "clock of the recorder was set by -3" in (tmp_path / "out" / "metrics.json").read_text()


def test_swapped_clouds_are_sorted_and_repeated_ones_left_out(scans, tmp_path):
    messages = good(scans)
    clouds = of_topic(messages, "/points")
    clouds[4][0], clouds[5][0] = clouds[5][0], clouds[4][0]
    messages += [[message[0] + 0.001] + copy.deepcopy(message[1:]) for message in clouds[8:11]]
    run = Run(tmp_path, messages)
    assert run.status == 0 and run.num_scans == NUM_SCANS
    assert run.left_out.startswith("3 x cloud left out") and "repeats" in run.left_out


@pytest.mark.parametrize("late_s", [{"/points": -SWEEP_S}, {"/imu": 0.17}, {"/imu": 0.6}, {"/points": 0.7}])
def test_a_cloud_waits_for_the_imu_of_its_sweep(late_s, scans, tmp_path):
    stamps = []
    for late in ({}, late_s):
        messages = good(scans, with_odometry=False, with_imu=True)
        for message in messages:
            message[0] += late.get(message[1], 0.0)
        run = Run(tmp_path, messages, name="late" if late else "good")
        assert run.status == 0
        stamps.append(files.read_tum(run.out + "/trajectory_odom.txt"))
    assert np.array_equal(stamps[0][0], stamps[1][0]) and np.array_equal(stamps[0][1], stamps[1][1])


def test_with_lidar_odometry_the_trajectory_is_that_of_the_imu_wherever_it_sits(scans, tmp_path):
    T_B_I = mount_of((-0.1, 0.2, -0.2), (0.0, 0.0, 0.0))
    messages = [m for m in good(scans, with_odometry=False, with_imu=True) if m[1] != "/tf_static"]
    for message in of_topic(messages, "/imu"):
        message[2].header.frame_id = "imu"
    messages.append([FIRST_S - 0.1, "/tf_static", link("imu", "lidar", np.linalg.inv(T_B_I) @ MOUNT)])
    run = Run(tmp_path, messages)
    assert run.status == 0
    stamps, poses = files.read_tum(run.out + "/trajectory_odom.txt")
    true = [body_pose(t - FIRST_S + 1.0 + 0.5 * SWEEP_S) @ T_B_I for t in stamps]
    T_W_O = true[1] @ np.linalg.inv(poses[1])  # at its first scan, LiDAR odometry does not know yet that it moves
    errors = [np.linalg.norm((T_W_O @ T)[:3, 3] - T_true[:3, 3]) for T, T_true in zip(poses[1:], true[1:])]
    assert max(errors) < 0.06


def test_a_gap_of_odometry_is_filled_by_lidar_odometry_and_never_interpolated(scans, tmp_path):
    def is_silent(message):
        return message[1] == "/odom" and FIRST_S + 0.45 < message[0] < FIRST_S + 1.05
    messages = [message for message in good(scans) if not is_silent(message)]
    run = Run(tmp_path, messages)
    assert run.status == 0 and run.num_scans == NUM_SCANS
    assert "silent for 0.6" in run.warnings and "covered by LiDAR odometry" in run.warnings
    assert run.error_m() < 0.1 and run.share_right(scans[0]) > 0.95
    left = Run(tmp_path, messages, run="pose_source: recording", name="recording")
    assert left.status == NOT_COVERED and NUM_SCANS - 8 <= left.num_scans <= NUM_SCANS - 6
    assert "apart" in left.left_out and "no pose" in left.warnings and "does not cover" in \
        left.metrics["coverage"]["sentence"]
    assert left.error_m() < 0.06


def test_lidar_odometry_continues_where_odometry_ends_early(scans, tmp_path):
    messages = [message for message in good(scans) if message[1] != "/odom" or message[0] < FIRST_S + 0.8]
    run = Run(tmp_path, messages)
    assert run.status == 0 and run.num_scans >= NUM_SCANS - 1 and "to the end" in run.warnings
    assert run.error_m() < 0.1


def test_several_bags_are_one_flight(scans, tmp_path):
    messages = sorted(good(scans), key=lambda message: message[0])
    parts = [messages[:len(messages) // 2], messages[len(messages) // 2:]]
    bags = [write_messages(str(tmp_path / ("%d.bag" % i)), part) for i, part in enumerate(parts)]
    assert map_bag(bags[::-1] + ["--out", str(tmp_path / "out")]) == 0
    whole = write_messages(str(tmp_path / "whole.bag"), messages)
    assert map_bag([whole, "--out", str(tmp_path / "whole")]) == 0
    for name in ("trajectory_odom.txt", "occupied.ply"):
        assert (tmp_path / "out" / name).read_bytes() == (tmp_path / "whole" / name).read_bytes()


def test_positions_in_utm_are_shifted_to_the_origin_and_this_is_reported(scans, tmp_path, capsys):
    plain = Run(tmp_path, good(scans), name="plain")
    messages = good(scans)
    for message in of_topic(messages, "/odom"):
        message[2].pose.pose.position.x += 465000.0
        message[2].pose.pose.position.y += 5580000.0
    capsys.readouterr()
    run = Run(tmp_path, messages)
    assert run.status == 0
    origin = np.array(run.metrics["origin_m"])
    assert np.all(origin[:2] > 4e5) and origin[2] == 0.0 and np.array_equal(origin, np.round(origin))
    assert "%.0f %.0f 0 m is subtracted" % (origin[0], origin[1]) in capsys.readouterr().out
    T_W_O = mount_of(origin - (465000.0, 5580000.0, 0.0), (0, 0, 0))
    assert run.share_right(scans[0], T_W_O) > 0.95 and plain.metrics["origin_m"] == [0.0, 0.0, 0.0]


def test_the_topic_of_the_lidar_is_recognised_by_its_clouds(scans, tmp_path, capsys):
    messages = good(scans)
    for record_s, _, msg in of_topic(messages, "/points"):
        narrow = copy.deepcopy(msg)  # a cloud like those of a depth camera: near, ahead, without point times
        rows = np.frombuffer(msg.data, np.uint8).reshape(-1, msg.point_step)
        xyz = rows[:, :12].copy().view("<f4")
        near = rows[(np.abs(xyz[:, 1]) < xyz[:, 0]) & (np.linalg.norm(xyz, axis=1) < 4.0)]
        narrow.fields, narrow.height, narrow.width = narrow.fields[:3], 1, len(near)
        narrow.row_step, narrow.data = narrow.point_step * len(near), near.tobytes()
        messages.append([record_s, "/camera/points", narrow])
        world_frame = copy.deepcopy(msg)
        world_frame.header.frame_id = "odom"
        messages.append([record_s, "/a_registered", world_frame])
    run = Run(tmp_path, messages)
    assert run.status == 0 and run.share_right(scans[0]) > 0.95
    said = capsys.readouterr().out
    assert "clouds       /points (" in said and "rather than /camera/points (" in said
    assert "no point times" in said and "already in the frame of the odometry" in said
    assert Run(tmp_path, messages, run="cloud_topic: /nowhere").status == 1
    assert "/camera/points" in capsys.readouterr().err


def test_a_mount_over_a_chain_of_tf_and_tf_static_is_found(scans, tmp_path, capsys):
    T_B_S = mount_of((0.4, -0.2, 0.1), (0.2, 0.1, 2.0))
    T_S_L = np.linalg.inv(T_B_S) @ MOUNT
    messages = [message for message in good(scans) if message[1] != "/tf_static"]
    for message in of_topic(messages, "/points"):
        message[2].header.frame_id = "/lidar"
    without = list(messages)
    messages.append([FIRST_S - 0.1, "/tf_static", link("sensor", "lidar", T_S_L)])
    messages += [[FIRST_S + 0.1 * i, "/tf", link("/body", "/sensor", T_B_S)] for i in range(10)]
    run = Run(tmp_path, messages)
    assert run.status == 0 and run.share_right(scans[0]) > 0.95
    assert "body -> sensor -> lidar" in capsys.readouterr().out
    unknown = Run(tmp_path, without, name="unknown")
    assert unknown.status == 1
    error = capsys.readouterr().err
    assert "'body'" in error and "'lidar'" in error and "--mount" in error
    assert check_recording([unknown.bag]) == 1
    assert "'body'" in capsys.readouterr().out
    words = "%.6f %.6f %.6f 0 0 0" % tuple(MOUNT[:3, 3])
    given = Run(tmp_path, without, "--mount", words, name="given")
    assert given.status == 0 and given.share_right(scans[0]) > 0.95


def test_the_page_of_a_good_recording_shows_no_problem(scans, tmp_path, capsys):
    bag = write_messages(str(tmp_path / "good.bag"), good(scans, with_imu=True))
    assert check_recording([bag]) == 0
    page = capsys.readouterr().out
    for words in ("/points (10.0 Hz", "/odom (50 Hz", "/imu (200 Hz", "LiDAR at 0.100 0.000 0.150 m", "m/s^2", "memory",
                  "problems     none"):
        assert words in page


def test_the_page_of_a_bad_recording_names_each_problem_and_what_to_do(scans, tmp_path, capsys):
    import rospy

    messages = good(scans, with_odometry=False, with_imu=True)
    of_topic(messages, "/points")[4][2].header.stamp += rospy.Duration(3600)
    of_topic(messages, "/points")[6][2].data = b"short"
    for message in of_topic(messages, "/imu"):
        message[2].linear_acceleration.z = 1.0
        message[2].header.stamp += rospy.Duration(50)
    for number in range(40, 240):
        messages.remove(of_topic(messages, "/imu")[40])
    bag = write_messages(str(tmp_path / "bad.bag"), messages)
    assert check_recording([bag]) == 3
    page = capsys.readouterr().out
    for words in ("alone", "/points: 1 of 14 messages that were looked at cannot be used: data has 5 bytes", "is of g",
                  "silent once", "50.1 s apart"):
        assert words in page
    lines = page[page.index("\nproblems"):].splitlines()[2:]
    assert len(lines) >= 8 and len(lines) % 2 == 0
    for what, to_do in zip(lines[::2], lines[1::2]):
        assert re.match(r"  \d+\. \S", what) and to_do.startswith("     -> "), what


def test_the_page_names_gaps_of_odometry_and_invalid_transforms(scans, tmp_path, capsys):
    messages = [message for message in good(scans)
                if message[1] != "/odom" or not FIRST_S + 0.4 < message[0] < FIRST_S + 0.9]
    broken = link("body", "camera", np.eye(4))
    broken.transforms[0].transform.rotation.w = 0.0
    messages.append([FIRST_S, "/tf_static", broken])
    odometry = of_topic(messages, "/odom")
    no_quaternion(odometry[5][2])
    spoil_pose(odometry[9][2], x=60.0)
    odometry[12][2].child_frame_id = "gps"
    of_topic(messages, "/points")[6][2].header.frame_id = "map"
    assert check_recording([write_messages(str(tmp_path / "gap.bag"), messages)]) == 3
    page = capsys.readouterr().out
    assert "/odom is silent once longer than 0.3 s, for 0.5 s" in page and "LiDAR odometry covers it" in page
    assert "body to camera is not one" in page
    for words in ("quaternion", "its pose is alone", "its body is 'gps'", "its frame is 'map'"):
        assert re.search("1 of [0-9]+ messages that were looked at cannot be used: .*" + words, page)


def test_a_large_recording_is_surveyed_in_windows_with_the_same_result(scans, tmp_path, capsys, monkeypatch):
    messages = good(scans, with_imu=True)
    later = []
    for i in range(1, 20):  # the same flight again and again
        later += [[record_s + 1.72 * i, topic, moved(msg, 1.72 * i)] for record_s, topic, msg in messages[1:]]
    bag = write_messages(str(tmp_path / "long.bag"), messages + later)
    monkeypatch.setattr("voxnav.recordings.survey._WHOLE_BYTES", 1000)
    check_recording([bag])
    page = capsys.readouterr().out
    assert "looked at in windows" in page and "repeats" not in page and "cannot be used" not in page
    for words in ("/points (", "/odom (50 Hz", "/imu (200 Hz", "body -> lidar", "m/s^2"):
        assert words in page


def test_odometry_on_another_clock_or_too_slow_is_not_used(scans, tmp_path):
    import rospy

    messages = good(scans, with_imu=True)
    for message in of_topic(messages, "/odom"):
        message[2].header.stamp += rospy.Duration(1000)
    run = Run(tmp_path, messages)
    assert run.status == 0 and "1000." in run.warnings and "LiDAR odometry instead" in run.warnings
    slow = [message for message in good(scans, with_imu=True) if message[1] != "/odom"]
    slow += [[FIRST_S + t, "/odom", odometry_message(FIRST_S + t, body_pose(1.0 + t))] for t in (0.0, 0.7, 1.4)]
    run = Run(tmp_path, slow, name="slow")
    assert run.status == 0 and "max_pose_gap_s" in run.warnings


@pytest.mark.parametrize("content, words", [
    ("1 0 0 0 0 0 0 1\n2 0 0 0 0 0 0 1\n1.5 0 0 0 0 0 0 1\n", "line 3: time does not increase"),
    ("# t x y z\n1,0,0,0,0,0,0,1\nrubbish\n", "line 3"), ("1 0 0 0 0 0 0\n", "line 1"),
    ("1 0 0 0 0 0 0 1\n2 0 0 0 0 0 0 0\n", "line 2"), ("1 0 0 0 0 0 0 1\n\n3 0 0 \xff 0 0 0 1\n", "line 3")])
def test_errors_in_text_files_name_their_line(content, words, scans, tmp_path, capsys):
    path = tmp_path / "reference.txt"
    path.write_bytes(content.encode("latin-1"))
    bag = write_messages(str(tmp_path / "good.bag"), good(scans))
    assert map_bag([bag, "--reference", str(path), "--out", str(tmp_path / "out")]) == 1
    error = capsys.readouterr().err
    assert "reference.txt " + words in error
    broken = tmp_path / "broken.yaml"
    broken.write_text("map:\n  resolution_m: [0.2\nrun: {}\n")
    assert map_bag([bag, "--config", str(broken), "--out", str(tmp_path / "out")]) == 1
    assert "broken.yaml" in capsys.readouterr().err
