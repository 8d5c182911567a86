# SPDX-License-Identifier: BSD-3-Clause
"""The rospy nodes; the only place in the package that imports rospy."""
