# SPDX-License-Identifier: BSD-3-Clause
"""Measures how well the submap graph aligns submaps on simulated flights that drift; see scripts/evaluate_alignment."""
