"""Rooms and what is in them."""

from __future__ import annotations

import os
import pathlib
from typing import TYPE_CHECKING, Any, Iterator, NamedTuple, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _native
from .view_settings import File, ViewSettings

if TYPE_CHECKING:
    from typing_extensions import Unpack


class Line(NamedTuple):
    """One straight run of the slider. Arrays are read-only."""

    id: str
    """"x0", "x1", ... ordered by z; "z0", "z1", ... ordered by x."""
    axis: str
    """The axis that the line follows, "x" or "z"."""
    origin_m: tuple[float, float]
    """x, z of the place from which ``along_m`` counts."""
    direction: tuple[float, float]
    """x, z of the unit vector along the line."""
    height_m: float
    """Mean y of the stations."""
    positions_m: NDArray[np.float64]
    """(stations, 3): x, y, z of every station."""
    along_m: NDArray[np.float64]
    """(stations,): where the stations are along the line, increasing."""
    files: tuple[str, ...]
    """Of every station, as the frame list named it."""
    distance_stations: NDArray[np.int32]
    """The stations that have a distance map, increasing."""


class Cell(NamedTuple):
    """A rectangle of the plan whose four sides are lines; metres, and the ids of the lines."""

    x_min_m: float
    x_max_m: float
    z_min_m: float
    z_max_m: float
    front: str
    right: str
    back: str
    left: str


class DistanceMap(NamedTuple):
    """What is known of the distances around a station; read-only views of the mapped volume."""

    distance_m: NDArray[np.float32]
    """(height, width): metres along the ray to the first surface; infinite where there is none."""
    confidence: NDArray[np.uint8]
    """(height, width): 0 is unknown, 255 certain; views ignore what is below 64."""


class Path(Iterator[NDArray[np.uint8]]):
    """Views along a path, rendered one by one; made by :meth:`Room.path`."""

    def __init__(self, views: _native.PathViews) -> None:
        self._views = views
        self.names: list[str] = views.names()
        """Of the views, as the table has them; of viewpoints without a table "0", "1", ..."""
        self.viewpoints_m: NDArray[np.float64] = np.reshape(views.viewpoints_m(), (-1, 3))
        """(views, 3): x, y, z of every view; y is NaN where it is that of the lines around."""

    def __len__(self) -> int:
        """How many views the path has, those already rendered included."""
        return len(self.names)

    def __next__(self) -> NDArray[np.uint8]:
        return self._views.next_view()


def _name_of(line: int | str | Line) -> int | str:
    return line.id if isinstance(line, Line) else line


def _rows(viewpoints_m: ArrayLike, angles_deg: Sequence[ArrayLike]) -> NDArray[np.float64]:
    """(views, 6): x, y, z, yaw, pitch, roll; y is NaN where none is given."""
    points = np.asarray(viewpoints_m, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] not in (2, 3):
        raise _native.UsageError(
            f"viewpoints have the shape {points.shape}; "
            "give (views, 2), x and z in metres, or (views, 3), x, y and z"
        )
    if not np.isfinite(points[:, [0, -1]]).all() or np.isinf(points).any():
        raise _native.UsageError("a viewpoint is not finite; give x and z, or x, y and z, in metres")
    if points.shape[1] == 2:
        points = np.insert(points, 1, np.nan, axis=1)
    try:
        angles = [np.broadcast_to(np.asarray(a, dtype=np.float64), len(points)) for a in angles_deg]
    except ValueError:
        raise _native.UsageError(
            f"yaw_deg, pitch_deg and roll_deg are not one number, or one for each of "
            f"{len(points)} views"
        ) from None
    return np.column_stack([points, *angles])


class Room:
    """A room made by ``raywalk-build-lf pack``. Its volumes are mapped: data is read on first use.

    A line is named by its id, its index or a :class:`Line`; stations count from 0. Arrays keep what
    they look into mapped, also when the room itself is gone.
    """

    def __init__(self, directory: File) -> None:
        """Raises :class:`raywalk.Error` unless the room is complete."""
        self._room = _native.Room(directory)
        self._lines = tuple(Line(*fields) for fields in self._room.lines())
        self._cells = tuple(Cell(*fields) for fields in self._room.cells())

    def __repr__(self) -> str:
        return repr(self._room)

    @property
    def directory(self) -> pathlib.Path:
        return self._room.directory()

    @property
    def panorama_size_px(self) -> tuple[int, int]:
        """Width and height of every captured panorama."""
        return self._room.panorama_size_px()

    @property
    def lines(self) -> tuple[Line, ...]:
        return self._lines

    def line(self, line: int | str | Line) -> Line:
        """A line by its id or index."""
        return self._lines[self._room.line_index(_name_of(line))]

    @property
    def cells(self) -> tuple[Cell, ...]:
        """Empty if no four lines close one."""
        return self._cells

    def cell_at(self, x_m: float, z_m: float) -> Cell | None:
        """The cell that holds a viewpoint, borders included; None if none does."""
        index = self._room.cell_index(x_m, z_m)
        return None if index is None else self._cells[index]

    @property
    def distances_origin(self) -> str:
        """Where the distances come from: "given", "estimated by sweep", ..., or "none"."""
        return self._room.distances_origin()

    def frame(self, line: int | str | Line, station: int) -> NDArray[np.uint8]:
        """A captured panorama, (height, width, 3): a read-only view of the mapped volume, no copy.

        Columns of the panorama are contiguous: the strides are (3, 3 * height, 1).
        """
        return self._room.frame(_name_of(line), station)

    def distances(self, line: int | str | Line, station: int) -> DistanceMap:
        """The distance map of a station, one of :attr:`Line.distance_stations`."""
        return DistanceMap(*self._room.distances(_name_of(line), station))

    def view(
        self,
        x_m: float,
        z_m: float,
        *,
        y_m: float | None = None,
        yaw_deg: float = 0.0,
        pitch_deg: float = 0.0,
        roll_deg: float = 0.0,
        **settings: Unpack[ViewSettings],
    ) -> NDArray[np.uint8]:
        """The view at x, z: a panorama, or with ``fov_deg`` a flat picture; (height, width, 3).

        The eye is at the height ``y_m``, or at that of the lines around. With ``stereo="ods"`` the
        panorama of the left eye is above that of the right one.

        The pixels are those of ``raywalk-render view`` with the same settings, which
        :class:`ViewSettings` lists. The camera is turned by yaw to the right, pitch up and roll
        clockwise. Raises :class:`raywalk.Error` where the room cannot be rendered.
        """
        angles = {"yaw_deg": yaw_deg, "pitch_deg": pitch_deg, "roll_deg": roll_deg}
        return _native.view(self._room, x_m, z_m, y_m, {**angles, **settings})

    def write_view(
        self,
        file: File,
        x_m: float,
        z_m: float,
        *,
        y_m: float | None = None,
        yaw_deg: float = 0.0,
        pitch_deg: float = 0.0,
        roll_deg: float = 0.0,
        **settings: Unpack[ViewSettings],
    ) -> str:
        """Writes a view to ``file``, .png, .jpg, .webp or .tif, as ``raywalk-render view`` does.

        Unlike the array of :meth:`view`, the file says what it shows (Photo Sphere metadata, focal
        length). Returns a summary.
        """
        angles = {"yaw_deg": yaw_deg, "pitch_deg": pitch_deg, "roll_deg": roll_deg}
        return _native.write_view(self._room, file, x_m, z_m, y_m, {**angles, **settings})

    def view_settings(self, **settings: Unpack[ViewSettings]) -> dict[str, Any]:
        """The settings that views are rendered with, each by its key, and why.

        "k_source" says how k was chosen, "reason" what a preset or a measured choice followed.
        """
        return _native.view_settings(self._room, dict(settings))

    def path(
        self,
        views: File | ArrayLike,
        *,
        yaw_deg: ArrayLike = 0.0,
        pitch_deg: ArrayLike = 0.0,
        roll_deg: ArrayLike = 0.0,
        **settings: Unpack[ViewSettings],
    ) -> Path:
        """The views along a path, as an iterator that renders one when it is asked for it.

        ``views`` is an array (views, 2) of x, z in metres, or (views, 3) of x, y, z, or the table of
        ``raywalk-render path``: a CSV file with the columns name,x,z and optionally
        y,yaw,pitch,roll. The angles are one for all or one for each view of an array; a table has
        its own. Every viewpoint is checked before the first is rendered.
        """
        angles = [yaw_deg, pitch_deg, roll_deg]
        if not isinstance(views, (str, os.PathLike)):
            rows = _rows(views, angles).tolist()
            return Path(_native.path_of_rows(self._room, rows, dict(settings)))
        if any(np.any(angle) for angle in angles):
            raise _native.UsageError(
                "the table has the angles of its views; leave out yaw_deg, pitch_deg and roll_deg"
            )
        return Path(_native.path_of_file(self._room, views, dict(settings)))

    def write_path(
        self,
        table: File,
        out: File | None = None,
        *,
        replace: bool = False,
        **settings: Unpack[ViewSettings],
    ) -> str:
        """Writes every view of a table to ``out``/<name>.png as ``raywalk-render path`` does.

        ``out`` is the table's name without .csv if it is not given. Called again it renders what is
        missing; ``replace`` renders the directory anew. Returns a summary.
        """
        if out is None:
            out = pathlib.Path(table).stem
        return _native.write_path(self._room, table, out, replace, dict(settings))
