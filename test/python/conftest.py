# SPDX-License-Identifier: BSD-3-Clause
"""Fixtures that several tests share."""

import os

import pytest

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))


@pytest.fixture(scope="session")
def data_dir():
    """Returns the folder of real recordings (VOXNAV_DATA, or ../shared/data beside the checkout), or skips the test."""
    path = os.environ.get("VOXNAV_DATA", os.path.join(ROOT, "..", "shared", "data"))
    if not os.path.isdir(path):
        pytest.skip("real recordings not found at %s; set VOXNAV_DATA" % path)
    return path
