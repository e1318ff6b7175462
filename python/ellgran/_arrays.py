# SPDX-License-Identifier: MIT OR Apache-2.0
"""Which arrays the library can read in place, and how others become such."""
from __future__ import annotations

from typing import Any, Optional, Tuple

import numpy as np


def in_place(value: Any, shape: Tuple[Optional[int], ...], name: str, kind: Any = np.float64) -> Any:
    """The array itself where it has this type, is C-contiguous, aligned and of this shape, else a copy that is.

    A length of None is any. A value that lacks the first axis is repeated along it where that length is known. An empty list has no
    rows of any shape.
    """
    array = np.asarray(value)
    if array.shape == (0,) and not shape[0]:
        array = array.reshape((0,) + tuple(length or 0 for length in shape[1:]))
    if array.ndim == len(shape) - 1 and shape[0] is not None:
        # A copy: numpy's is read-only, and where the length is 1 it is the caller's own array.
        array = np.broadcast_to(array, (shape[0],) + array.shape).copy()
    fits = array.ndim == len(shape) and all(
        wanted is None or wanted == length for wanted, length in zip(shape, array.shape)
    )
    if not fits:
        wanted_shape = "(" + ", ".join("n" if length is None else str(length) for length in shape) + ")"
        raise ValueError(f"{name} has the shape {np.shape(value)}, it must be {wanted_shape}")
    if kind is not np.float64 and array.dtype.kind not in "iu" and array.size:
        raise TypeError(f"{name} must hold integers, not {array.dtype}")
    if kind is not np.float64 and array.size and not np.can_cast(array.dtype, kind):
        least, most = np.iinfo(kind).min, np.iinfo(kind).max
        for number in (array.min(), array.max()):
            if not least <= int(number) <= most:
                raise ValueError(f"{name} holds {number}, which is not from {least} to {most}")
    return np.require(array, dtype=kind, requirements=["C", "A"])


def pointer(array: Optional[Any]) -> Optional[int]:
    """Address of an array's memory; None, the C interface's NULL, for none."""
    return None if array is None else int(array.ctypes.data)
