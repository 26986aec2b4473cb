"""The keyword arguments of views, for type checkers."""

from __future__ import annotations

import os
from typing import Literal, TypedDict

File = str | os.PathLike[str]


class ViewSettings(TypedDict, total=False):
    """How views are rendered: the keys of a settings file, see docs/render.md.

    What is not given, or None, has the default of ``raywalk-render view``.
    """

    settings: File
    """A YAML file of settings; the arguments override it."""
    preset: Literal["none", "fast", "balanced", "accurate"]
    """Defaults for the others."""
    connection: Literal["hybrid", "lfu", "rayspace360"]
    """Where lines connect."""
    budget_ms: float
    """Take the most accurate setting that a trade measured to be this fast, milliseconds."""
    min_psnr_db: float
    """Take the fastest setting that reached this PSNR in that measurement, dB."""

    method: Literal["initial", "hlf-vd", "two-sided"]
    """Vertical cut, corrected by distance, or corrected from both sides."""
    k_deg: float
    """Largest incidence angle of the hybrid connection, 45 to 90 degrees."""
    overlap_deg: float
    """Width of the blend at a connection, 0 to 45 degrees."""
    width_px: int
    """Width of the panorama in pixels, a multiple of 4; 0: as captured."""
    interpolation: Literal["linear", "cubic"]
    """How a pixel is read from a panorama."""
    stations_mixed: int
    """Stations of each line that are mixed in a pixel, 1 to 16."""
    station_fade: float
    """Part of the stations' spacing over which one fades into the next, 0.1 to 1."""
    distance_maps: int
    """Distance maps that a view's distances are gathered from, 1 to 8."""
    second_side: Literal["everywhere", "faded"]
    """Where a two-sided view reads both sides."""
    gains: bool | Literal["off", "on"]
    """Whether stations are multiplied by their gains."""

    fov_deg: float
    """Horizontal field of view of a flat picture, above 0 to 170 degrees; 0: a panorama."""
    size_px: tuple[int, int]
    """Width and height of the flat picture, pixels; (1280, 720) if not given."""
    stereo: Literal["ods"]
    """Two panoramas for two eyes, the left one's above the right one's."""
    ipd_mm: float
    """Distance between the eyes, 1 to 200 millimetres; 63 if not given."""
