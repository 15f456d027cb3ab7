"""Arithmetic of triples: points in space, or one number per axis; all values of a triple have one unit."""

import math

from forest_description.types import Vec3


def plus(a: Vec3, b: Vec3) -> Vec3:
    """Return a + b."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def minus(a: Vec3, b: Vec3) -> Vec3:
    """Return a - b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def scaled(a: Vec3, factor: float) -> Vec3:
    """Return a times a factor."""
    return factor * a[0], factor * a[1], factor * a[2]


def dot(a: Vec3, b: Vec3) -> float:
    """Return the scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def norm(a: Vec3) -> float:
    """Return the length."""
    return math.sqrt(dot(a, a))
