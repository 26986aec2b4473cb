"""Light-field rooms from 360-degree panoramas: views, captured frames, distances and their errors.

World frame: metres, x right, y up, z forward; theta = 0 looks to +z and grows towards +x. Pictures
are uint8 arrays (height, width, 3), red, green, blue. Panoramas are equirectangular.

Calls that work release the interpreter's lock and end with KeyboardInterrupt on Ctrl-C. Warnings
are RuntimeWarning. docs/python.md has examples.
"""

from . import error_model, metrics
from ._native import (
    Error,
    UsageError,
    __version__,
    read_picture,
    set_cache_mb,
    set_device,
    set_thread_count,
    thread_count,
    write_picture,
)
from ._room import Cell, DistanceMap, Line, Path, Room
from .view_settings import ViewSettings

__all__ = [
    "Cell",
    "DistanceMap",
    "Error",
    "Line",
    "Path",
    "Room",
    "UsageError",
    "ViewSettings",
    "__version__",
    "error_model",
    "metrics",
    "read_picture",
    "set_cache_mb",
    "set_device",
    "set_thread_count",
    "thread_count",
    "write_picture",
]
