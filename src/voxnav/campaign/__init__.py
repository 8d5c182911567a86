# SPDX-License-Identifier: BSD-3-Clause
"""Campaigns of simulated flights: a grid of worlds, seeds, densities, speeds and faults, flown in parallel."""
