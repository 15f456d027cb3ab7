"""The types that all packages share: numbers per axis, points in space, arrays."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

AXES = ("swing", "boom", "stick")  # the joints, in the order of every `Vec3` that has one number per axis

Vec3 = tuple[float, float, float]  # one number per axis, or x, y, z
Matrix3 = tuple[Vec3, Vec3, Vec3]  # rows
Quaternion = tuple[float, float, float, float]  # x, y, z, w
ZERO: Vec3 = (0.0, 0.0, 0.0)

Floats = NDArray[np.float64]
Complexes = NDArray[np.complexfloating[Any, Any]]
Bools = NDArray[np.bool_]
