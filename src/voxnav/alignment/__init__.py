# SPDX-License-Identifier: BSD-3-Clause
"""How well the submap graph aligns: simulated flights with drift, without ROS. See scripts/evaluate_alignment."""
