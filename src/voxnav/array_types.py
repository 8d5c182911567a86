# SPDX-License-Identifier: BSD-3-Clause
"""Names for numpy arrays in annotations; shapes, dtypes and units stand in the docstrings."""

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    import numpy.typing as npt  # absent from numpy 1.17, which Ubuntu 20.04 has

    Array = npt.NDArray[Any]
    ArrayLike = npt.ArrayLike
else:
    Array = np.ndarray
    ArrayLike = Any
