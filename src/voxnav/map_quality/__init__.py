# SPDX-License-Identifier: BSD-3-Clause
"""How faithfully a local map holds what a simulated LiDAR saw: foliage as it is, rain, thin things."""
