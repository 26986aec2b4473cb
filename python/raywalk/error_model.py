"""The paper's error model, equations (1) to (10), on arrays.

Lengths are metres; angles are radians but k and corner angles, which are degrees. Arguments are
numbers or arrays and are broadcast as NumPy does; the result is a float where all are numbers, else
an array of float64. ``d_src_m`` is the distance from the acquisition point to the source, 0 to
infinity; ``phi_rad`` is the latitude of the source seen from there, -pi/2 to pi/2. A value outside
of its range raises :class:`raywalk.UsageError`.
"""

from __future__ import annotations

from typing import NamedTuple, Tuple, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _native

__all__ = [
    "ConnectionErrorCurve",
    "bending_distance",
    "connection_error_curve",
    "connection_range",
    "corner_angle_deg",
    "corrected_latitude",
    "latitude_shift",
    "mismatch_distance",
]

Numbers = Union[float, NDArray[np.float64]]


def latitude_shift(d_src_m: ArrayLike, phi_rad: ArrayLike, apart_m: ArrayLike) -> Numbers:
    """(1), (2), (4): the difference in latitude, radians, between two acquisition points.

    The second one is ``apart_m`` >= 0 farther from the source in the plan: d_p for the vertical
    parallax phi - phi* that (1) means, \\|D_b\\| of :func:`bending_distance` for (2), D_m of
    :func:`mismatch_distance` for (4).
    """
    return _native.latitude_shift(d_src_m, phi_rad, apart_m)


def bending_distance(
    d_src_m: ArrayLike, phi_rad: ArrayLike, theta_rad: ArrayLike, step_m: ArrayLike
) -> Numbers:
    """(3): the difference in plan distance, metres, to the source between neighbouring stations.

    ``step_m`` >= 0 is their spacing, ``theta_rad`` the incidence angle in -pi/2..pi/2, positive
    where the second station is farther away from the source.
    """
    return _native.bending_distance(d_src_m, phi_rad, theta_rad, step_m)


def corrected_latitude(d_src_m: ArrayLike, d_p_m: ArrayLike, phi_rad: ArrayLike) -> Numbers:
    """(5): the latitude phi*, radians, at which the viewpoint sees what the line sees at phi.

    ``d_p_m`` is the plan distance from viewpoint to acquisition point, negative where the viewpoint
    is in front of the line. ``phi_rad`` may go past the pole, -pi to pi.
    """
    return _native.corrected_latitude(d_src_m, d_p_m, phi_rad)


def corner_angle_deg(to_side_m: ArrayLike, to_front_m: ArrayLike) -> Numbers:
    """The angle, 0 to 90 degrees, between the front line's normal and a corner.

    ``to_side_m`` and ``to_front_m`` >= 0 are the distances from the viewpoint to the two lines that
    meet there, the paper's N/2 - x and N/2 - z.
    """
    return _native.corner_angle_deg(to_side_m, to_front_m)


def mismatch_distance(to_side_m: ArrayLike, to_front_m: ArrayLike, k_deg: ArrayLike) -> Numbers:
    """(8): D_m, metres, between the points at which two lines read the ray of incidence k.

    ``k_deg`` is in 45..90; the result is 0 for k at or above the corner angle, a physical
    connection. The others are as in :func:`corner_angle_deg`.
    """
    return _native.mismatch_distance(to_side_m, to_front_m, k_deg)


def connection_range(to_side_m: ArrayLike, to_front_m: ArrayLike) -> Tuple[float, Numbers]:
    """(9): the least and the largest k, degrees, that have an effect at a corner.

    The arguments are as in :func:`corner_angle_deg`. The least is 45 everywhere; a corner angle below
    45 degrees is measured from the other line.
    """
    return 45.0, _native.largest_k_deg(to_side_m, to_front_m)


class ConnectionErrorCurve(NamedTuple):
    """The errors of a cell's views at each whole degree of k."""

    k_deg: NDArray[np.float64]
    """45, 46, ..., 90."""
    e_m_rad: NDArray[np.float64]
    """E_m (7): mismatching, falls to 0 at 90 degrees."""
    e_b_rad: NDArray[np.float64]
    """E_b (10): bending, grows with k."""
    e_t: NDArray[np.float64]
    """E_t (6): the sum of both, each as a share of its maximum over k; 0 to 2."""
    optimum_k_deg: int
    """The k of the least E_t."""


def connection_error_curve(
    d_src_m: ArrayLike, side_m: float = 1.0, step_m: float = 0.01, viewpoints: int = 49
) -> ConnectionErrorCurve:
    """(6), (7), (10): the errors over k of a cell whose sources are at ``d_src_m``, metres.

    With several distances E_m and E_b are summed over them before (6). ``side_m`` is N, ``step_m``
    the spacing of the stations, which the paper does not state; viewpoints are the centres of
    ``viewpoints`` x ``viewpoints`` sub-cells. Takes about 0.1 s a distance.
    """
    fields = _native.connection_error_curve(d_src_m, side_m, step_m, viewpoints)
    return ConnectionErrorCurve(k_deg=np.arange(45.0, 91.0), **fields)
