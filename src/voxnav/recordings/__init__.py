# SPDX-License-Identifier: BSD-3-Clause
"""What is in a recording: files, topics, clocks, frames, and what of it can be used."""
