# SPDX-License-Identifier: BSD-3-Clause
"""CloudFilter, through Python, filters synthetic clouds and real Ouster frames as documented."""
import os
import struct

import numpy as np
import pytest

import voxnav

DATA = os.environ.get("VOXNAV_DATA", os.path.join(os.path.dirname(__file__), "..", "..", "..", "shared", "data"))


def make_cloud(height=16, width=32):
    cloud = np.zeros((height, width, 4), np.float32)
    cloud[..., 0] = 5.0
    cloud[..., 1] = np.arange(width)
    cloud[..., 3] = 100.0
    return cloud


def ouster_cloud(number):
    path = os.path.join(DATA, "ouster_os0_128", "organised_%06d.npz" % number)
    if not os.path.exists(path):
        pytest.skip("needs the recording %s (set VOXNAV_DATA)" % path)
    data = np.load(path)
    cloud = np.empty(data["xyz"].shape[:2] + (4,), np.float32)
    cloud[..., :3] = data["xyz"]
    cloud[..., 3] = data["reflectivity"]
    return cloud, data["range"]


def test_apply_counts_every_point_once():
    cloud = make_cloud()
    cloud[0, :5] = 0.0
    cloud[1, :4, 0] = np.nan
    # The points of this cloud are no image of a surface, so that some would count as outliers.
    result = voxnav.CloudFilter(voxnav.CloudFilterConfig(remove_outliers=False)).apply(cloud)
    assert result.total == 16 * 32 == sum(result.counts.values())
    assert result.counts["zero"] == 5 and result.counts["nan"] == 4
    assert result.points.shape == (16 * 32 - 9, 4) and result.points.dtype == np.float32


def test_apply_accepts_unorganised_and_empty_clouds():
    assert voxnav.CloudFilter().apply(make_cloud().reshape(-1, 4)).points.shape == (512, 4)
    assert voxnav.CloudFilter().apply(np.zeros((0, 4), np.float32)).points.shape == (0, 4)


@pytest.mark.parametrize("bad", [np.zeros((4, 4, 3), np.float32), np.zeros((4, 4, 4)), np.zeros(4, np.float32)])
def test_apply_refuses_other_shapes_and_dtypes(bad):
    with pytest.raises(ValueError):
        voxnav.CloudFilter().apply(bad)


def test_config_refuses_unknown_and_out_of_range_fields():
    with pytest.raises(voxnav.ConfigError, match="max_range_m"):
        voxnav.CloudFilterConfig(max_range_m=-1.0)
    with pytest.raises(voxnav.ConfigError, match="unknown"):
        voxnav.CloudFilterConfig(max_rnage_m=10.0)


def test_apply_raw_reads_gazebo_bytes():
    fields = [("x", 0, 7, 1), ("y", 4, 7, 1), ("z", 8, 7, 1), ("intensity", 12, 7, 1), ("ring", 16, 2, 1),
              ("range", 17, 6, 1), ("t", 21, 6, 1), ("reflectivity", 25, 4, 1), ("ambient", 27, 4, 1)]
    point = struct.pack("<ffffBIIHH", 1.0, -2.0, 3.0, 9.0, 4, 3742, 5000, 7, 8)
    data = (point + b"\0" * 29) * 6
    result = voxnav.CloudFilter().apply_raw(data, voxnav.CloudLayout(height=3, width=4, point_step=29, fields=fields))
    assert result.counts["zero"] == 6 and result.counts["kept"] == 6
    assert result.points[0].tolist() == [1.0, -2.0, 3.0, 9.0]
    assert result.time_offsets_ns.tolist() == [5000] * 6


def test_apply_raw_names_what_is_wrong_with_a_cloud():
    fields = [("x", 0, 7, 1), ("y", 4, 7, 1), ("z", 8, 7, 1)]
    layout = voxnav.CloudLayout(height=1, width=10, point_step=12, fields=fields)
    with pytest.raises(ValueError, match="data has 119 bytes"):
        voxnav.CloudFilter().apply_raw(b"\0" * 119, layout)


@pytest.mark.parametrize("number", [1, 3, 4, 7])
def test_the_filter_removes_from_real_ouster_frames_only_points_with_a_reason(number):
    cloud, range_mm = ouster_cloud(number)
    config = voxnav.CloudFilterConfig(max_range_m=60.0)
    result = voxnav.CloudFilter(config).apply(cloud)
    # The sensor measures ranges from the lens and coordinates from its centre, so the two differ by centimetres.
    assert abs(result.counts["zero"] - int((range_mm == 0).sum())) <= 0.001 * range_mm.size
    norm = np.linalg.norm(cloud[..., :3].reshape(-1, 3), axis=1)
    within = int(((norm > 0.7) & (norm <= 60.0)).sum())
    assert result.counts["kept"] + result.counts["outlier"] == within
    assert result.counts["outlier"] <= 0.05 * within
    assert sum(result.counts.values()) == cloud.shape[0] * cloud.shape[1]


def test_pcl_filters_follow_in_the_order_given():
    random = np.random.default_rng(4)
    cloud = np.concatenate([random.uniform(-20, 20, (3000, 3)), np.full((3000, 1), 7.0)], axis=1).astype(np.float32)
    config = voxnav.PclFiltersConfig(filters=["crop_box", "voxel_grid"], crop_box_min=[-9, -9, -9],
                                     crop_box_max=[9, 9, 9], leaf_size=3.0)
    filters = voxnav.make_pcl_filters(config)
    assert [f.name for f in filters] == config.filters
    result = voxnav.CloudFilter().apply(cloud)
    before = result.points
    filters[0].apply(result)
    np.testing.assert_array_equal(result.points, before[(np.abs(before[:, :3]) <= 9).all(axis=1)])
    cells = np.unique(np.floor(result.points[:, :3] / 3.0), axis=0)
    filters[1].apply(result)
    assert len(result.points) == len(cells)
    assert result.counts["pcl"] == len(before) - len(cells) and result.counts["kept"] == len(cells)
    assert sum(result.counts.values()) == result.total
    assert len(result.sweep(0).points) == len(cells)
    assert voxnav.make_pcl_filters(voxnav.PclFiltersConfig()) == []


def test_bad_pcl_filters_are_refused_by_name():
    with pytest.raises(voxnav.ConfigError, match="'bilateral'.*pass_through"):
        voxnav.PclFiltersConfig(filters=["bilateral"])
    with pytest.raises(voxnav.ConfigError, match="filter_limit_min = 3.*below filter_limit_max"):
        voxnav.PclFiltersConfig(filters=["pass_through"], filter_limit_min=3.0, filter_limit_max=2.0)
    with pytest.raises(voxnav.ConfigError, match="leaf_size"):
        voxnav.PclFiltersConfig(leaf_size=-0.1)
