"""The paper's error model, equations (1) to (10), on arrays.

Lengths are metres; angles are radians but k and corner angles, which are degrees. Arguments are
numbers or arrays and are broadcast as NumPy does; the result is a float where all are numbers, else
an array of float64. ``d_src_m`` is the distance from the acquisition point to the source, 0 to
infinity; ``phi_rad`` is the latitude of the source seen from there, -pi/2 to pi/2. A value outside
of its range raises :class:`raywalk.UsageError`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._native import UsageError

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

Numbers = float | NDArray[np.float64]

_LARGEST = float(np.finfo(np.float64).max)
# Where the functions are defined.
_RANGES = {
    "d_src_m": (0.0, np.inf),
    "d_p_m": (-_LARGEST, _LARGEST),
    "phi_rad": (-np.pi / 2, np.pi / 2),
    "theta_rad": (-np.pi / 2, np.pi / 2),
    "apart_m": (0.0, _LARGEST),
    "step_m": (0.0, _LARGEST),
    "to_side_m": (0.0, _LARGEST),
    "to_front_m": (0.0, _LARGEST),
    "k_deg": (45.0, 90.0),
    "side_m": (np.finfo(np.float64).tiny, _LARGEST),
    "viewpoints": (1.0, 1000.0),
}


def _checked(name: str, given: ArrayLike, turns: float = 1.0) -> NDArray[np.float64]:
    """The values of an argument, which are within ``turns`` times the range of its name."""
    try:
        values = np.asarray(given, dtype=np.float64)
    except (TypeError, ValueError):
        raise UsageError(f"{name} is neither a number nor an array of them") from None
    least, most = (turns * limit for limit in _RANGES[name])
    for at in np.flatnonzero(~((values >= least) & (values <= most)))[:1]:
        where = f" at value {at}" if values.ndim else ""
        raise UsageError(
            f"{name} is {values.flat[at]:g}{where}; it must be in {least:g}..{most:g}"
        )
    return values


def latitude_shift(d_src_m: ArrayLike, phi_rad: ArrayLike, apart_m: ArrayLike) -> Numbers:
    """(1), (2), (4): the difference in latitude, radians, between two acquisition points.

    The second one is ``apart_m`` >= 0 farther from the source in the plan: d_p for the vertical
    parallax phi - phi* that (1) means, \\|D_b\\| of :func:`bending_distance` for (2), D_m of
    :func:`mismatch_distance` for (4).
    """
    d, phi = _checked("d_src_m", d_src_m), _checked("phi_rad", phi_rad)
    return _shift(d, phi, _checked("apart_m", apart_m))


def _shift(d: NDArray[np.float64], phi: NDArray[np.float64], apart: NDArray[np.float64]) -> Numbers:
    # (2) and (4) are the angle between v = d (cos phi, sin phi) and w = v + (D, 0), of which the
    # cross product is d D sin phi and the scalar product d^2 + d D cos phi. Both are divided by d D,
    # which leaves no cancellation.
    with np.errstate(divide="ignore", invalid="ignore"):
        shift = np.arctan2(np.sin(phi), d / apart + np.cos(phi))
    shift = np.where((apart == 0.0) | np.isinf(d), 0.0, np.minimum(np.abs(shift), np.abs(phi)))
    return np.copysign(shift, phi)[()]


def bending_distance(
    d_src_m: ArrayLike, phi_rad: ArrayLike, theta_rad: ArrayLike, step_m: ArrayLike
) -> Numbers:
    """(3): the difference in plan distance, metres, to the source between neighbouring stations.

    ``step_m`` >= 0 is their spacing, ``theta_rad`` the incidence angle in -pi/2..pi/2, positive
    where the second station is farther away from the source.
    """
    c = _checked("d_src_m", d_src_m) * np.cos(_checked("phi_rad", phi_rad))
    theta, step = _checked("theta_rad", theta_rad), _checked("step_m", step_m)
    # (3) is h - c with c = d cos phi and h = hypot(c cos theta, c sin theta + s); times (h + c) /
    # (h + c) it has no cancellation: s (2 c sin theta + s) / (h + c).
    sine = np.sin(theta)
    with np.errstate(divide="ignore", invalid="ignore"):
        farther = np.hypot(c * np.cos(theta), c * sine + step)
        distance = step * ((2.0 * c * sine + step) / (farther + c))
    distance = np.where(np.isinf(c), step * sine, np.where(step == 0.0, 0.0, distance))
    return np.clip(distance, -step, step)[()]  # the triangle inequality, in spite of rounding


def corrected_latitude(d_src_m: ArrayLike, d_p_m: ArrayLike, phi_rad: ArrayLike) -> Numbers:
    """(5): the latitude phi*, radians, at which the viewpoint sees what the line sees at phi.

    ``d_p_m`` is the plan distance from viewpoint to acquisition point, negative where the viewpoint
    is in front of the line. ``phi_rad`` may go past the pole, -pi to pi.
    """
    d, apart = _checked("d_src_m", d_src_m), _checked("d_p_m", d_p_m)
    phi = _checked("phi_rad", phi_rad, turns=2.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        corrected = np.arctan2(np.sin(phi), np.cos(phi) + apart / d)
    # Towards the horizon it never increases, in spite of rounding.
    nearer = np.copysign(np.minimum(np.abs(corrected), np.abs(phi)), phi)
    corrected = np.where(apart < 0.0, corrected, nearer)
    return np.where((apart == 0.0) | np.isinf(d), phi, corrected)[()]


def corner_angle_deg(to_side_m: ArrayLike, to_front_m: ArrayLike) -> Numbers:
    """The angle, 0 to 90 degrees, between the front line's normal and a corner.

    ``to_side_m`` and ``to_front_m`` >= 0 are the distances from the viewpoint to the two lines that
    meet there, the paper's N/2 - x and N/2 - z.
    """
    a, b = _checked("to_side_m", to_side_m), _checked("to_front_m", to_front_m)
    return np.degrees(np.arctan2(a, b))


def mismatch_distance(to_side_m: ArrayLike, to_front_m: ArrayLike, k_deg: ArrayLike) -> Numbers:
    """(8): D_m, metres, between the points at which two lines read the ray of incidence k.

    ``k_deg`` is in 45..90; the result is 0 for k at or above the corner angle, a physical
    connection. The others are as in :func:`corner_angle_deg`.
    """
    a, b = _checked("to_side_m", to_side_m), _checked("to_front_m", to_front_m)
    k = _checked("k_deg", k_deg)
    # The ray of incidence k crosses the front line at b tan k; from there its distance to the side
    # line is (a - b tan k) / sin k. By the complement of k, as tan k is exact then near 90 degrees;
    # pi/4 is no double, so its tangent would not be 1.
    complement = np.radians(90.0 - k)
    with np.errstate(divide="ignore", invalid="ignore"):
        tangent = np.where(k == 45.0, 1.0, 1.0 / np.tan(complement))
        distance = np.maximum((a - b * tangent) / np.cos(complement), 0.0)
    physical = (k >= 90.0) | (k >= corner_angle_deg(a, b))
    return np.where(physical, 0.0, distance)[()]


def connection_range(to_side_m: ArrayLike, to_front_m: ArrayLike) -> tuple[float, Numbers]:
    """(9): the least and the largest k, degrees, that have an effect at a corner.

    The arguments are as in :func:`corner_angle_deg`. The least is 45 everywhere; a corner angle below
    45 degrees is measured from the other line.
    """
    corner = corner_angle_deg(to_side_m, to_front_m)
    return 45.0, np.where(np.add(to_side_m, to_front_m) == 0.0, 45.0, np.maximum(corner, 90.0 - corner))[()]


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
    distances = np.ravel(_checked("d_src_m", d_src_m))
    _checked("side_m", side_m), _checked("step_m", step_m), _checked("viewpoints", viewpoints)
    if distances.size == 0:
        raise UsageError("there must be at least one source distance")
    k_deg = np.arange(45.0, 91.0)
    phi = np.radians(np.arange(1.0, 91.0))  # rows below the horizon have the same errors
    # A viewpoint nearer to the side line is measured from that line: it mirrors one with a > b.
    centres = (np.arange(viewpoints) + 0.5) * (side_m / viewpoints)
    side, front = np.tril_indices(viewpoints, -1)
    theta = np.radians(np.arange(91.0))[:, None]
    e_m_rad, e_b_rad = np.zeros(46), np.zeros(46)
    for d in distances:
        for i, k in enumerate(k_deg):
            apart = np.asarray(mismatch_distance(centres[side], centres[front], k))
            e_m_rad[i] += 4.0 * np.sum(_shift(d, phi, apart[apart > 0.0, None]))
        bending = np.asarray(bending_distance(d, phi, theta, step_m))
        e_b_rad += 2.0 * np.cumsum(np.sum(_shift(d, phi, bending), axis=1))[45:]
    e_t = sum(e / max(np.max(e), np.finfo(np.float64).tiny) for e in (e_m_rad, e_b_rad))
    # Of equal errors the largest k, as it connects physically.
    optimum = int(k_deg[np.flatnonzero(e_t == np.min(e_t))[-1]])
    return ConnectionErrorCurve(k_deg, e_m_rad, e_b_rad, np.asarray(e_t), optimum)
