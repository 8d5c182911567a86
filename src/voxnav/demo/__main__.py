# SPDX-License-Identifier: BSD-3-Clause
"""Makes ``python3 -m voxnav.demo`` what scripts/demo is, wherever the package is installed."""

import sys

from voxnav.demo.flight import main

sys.exit(main())
