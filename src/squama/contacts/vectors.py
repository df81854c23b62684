"""Vectors and rotations of the compiled model: tuples of three numbers, real or with a complex step."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from squama.batch.keeping import inlined as _in

Vector = tuple[float, float, float]


@_in
def unit(a: int, like: float) -> Vector:
    """Return a unit vector with the number type of ``like``."""
    one, none = 1.0 + 0.0 * like, 0.0 * like
    return (one, none, none) if a == 0 else ((none, one, none) if a == 1 else (none, none, one))


@_in
def dot(a: Vector, b: Vector) -> float:
    """Return a . b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@_in
def cross(a: Vector, b: Vector) -> Vector:
    """Return a x b."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@_in
def add(a: Vector, s: float, b: Vector) -> Vector:
    """Return a + s b."""
    return a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]


@_in
def scaled(s: float, a: Vector) -> Vector:
    """Return s a."""
    return s * a[0], s * a[1], s * a[2]


@_in
def mixed(a: float, x: Vector, b: float, y: Vector, c: float, z: Vector) -> Vector:
    """Return a x + b y + c z."""
    return a * x[0] + b * y[0] + c * z[0], a * x[1] + b * y[1] + c * z[1], a * x[2] + b * y[2] + c * z[2]


class Turned(NamedTuple):
    """A rotation by the vector w: sin(t)/t, (1 - cos t)/t^2 and (t - sin t)/t^3 of its angle t."""

    w: Vector
    a: float
    b: float
    c: float


@_in
def turned(w: Vector) -> Turned:
    """Return the rotation by the vector w (rad)."""
    q = dot(w, w)
    if q.real < 0.05:
        a = 1 - q / 6 * (1 - q / 20 * (1 - q / 42 * (1 - q / 72 * (1 - q / 110))))
        b = 0.5 - q / 24 * (1 - q / 30 * (1 - q / 56 * (1 - q / 90 * (1 - q / 132))))
        return Turned(w, a, b, 1 / 6 - q / 120 * (1 - q / 42 * (1 - q / 72 * (1 - q / 110))))
    t = np.sqrt(q)
    a = np.sin(t) / t
    return Turned(w, a, (1 - np.cos(t)) / q, (1 - a) / q)


@_in
def rotated(e: Turned, x: Vector) -> Vector:
    """Return the rotated vector E x."""
    y = cross(e.w, x)
    return add(add(x, e.a, y), e.b, cross(e.w, y))


@_in
def spin(e: Turned, dw: Vector) -> Vector:
    """Return the vector o for a change dw: E x changes by o x (E x)."""
    return add(mixed(e.a, dw, e.b, cross(e.w, dw), 0.0, dw), e.c * dot(e.w, dw), e.w)


@_in
def by_vector(e: Turned, moment: Vector) -> Vector:
    """Return the gradient by w of the work of a moment: the transposed map of :func:`spin`."""
    return add(mixed(e.a, moment, -e.b, cross(e.w, moment), 0.0, moment), e.c * dot(e.w, moment), e.w)
