# SPDX-License-Identifier: BSD-3-Clause
"""Mapping from recordings as fast as the machine allows: readers, runner, outputs, report."""
