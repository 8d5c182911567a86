# SPDX-License-Identifier: BSD-3-Clause
"""This package maps recordings as fast as the machine allows: readers, runner, outputs and report."""
