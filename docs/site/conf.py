# SPDX-License-Identifier: BSD-3-Clause
"""What Sphinx is told; scripts/dev/run_docs says where Doxygen left its XML."""

import os

project = "voxnav"
author = copyright = "voxnav developers"
extensions = ["myst_parser", "breathe", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
root_doc = "index"
html_theme = "furo"
html_title = "voxnav"
html_copy_source = False
exclude_patterns = ["docs/site"]

# Headings can be linked to from other pages, as on the pages of the repository.
myst_heading_anchors = 3
suppress_warnings = ["myst.header"]

breathe_projects = {"voxnav": os.environ["VOXNAV_DOXYGEN_XML"]}
breathe_default_project = "voxnav"
primary_domain = None

autodoc_member_order = "bysource"
autodoc_typehints = "signature"
# The pages are built without ROS.
autodoc_mock_imports = ["rospy", "rosbag", "rospkg", "genpy", "matplotlib"]
