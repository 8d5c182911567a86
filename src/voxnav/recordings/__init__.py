# SPDX-License-Identifier: BSD-3-Clause
"""This package finds out what is in a recording (files, topics, clocks, frames) and which parts of it can be used."""
