# SPDX-License-Identifier: BSD-3-Clause
"""The demonstration flights: starting the nodes, the summary, the pictures."""
