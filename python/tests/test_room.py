"""What a room holds, compared with its files as h5py reads them."""

import gc
import pathlib
import subprocess
import sys
import warnings
import weakref

import h5py
import numpy as np
import pytest

import raywalk


def test_frame_is_the_mapped_volume_without_a_copy(room, room_folder):
    line = room.line("x0")
    frame = room.frame("x0", 7)
    with h5py.File(room_folder / "lines" / "x0.h5") as file:
        stored = file["rays"][7][: room.panorama_size_px[0]]  # theta, phi, rgb
    assert np.array_equal(frame, stored.transpose(1, 0, 2))
    assert frame.shape == (256, 512, 3) and frame.strides == (3, 3 * 256, 1)
    again = room.frame(line, 7)
    assert np.shares_memory(frame, again)
    assert np.array_equal(room.frame(0, 7), frame)


def test_distances_are_the_mapped_volume_without_a_copy(room, room_folder):
    line = room.lines[2]
    assert len(line.distance_stations) > 2
    station = int(line.distance_stations[1])
    found = room.distances(line, station)
    with h5py.File(room_folder / "distances" / "given" / f"{line.id}.h5") as file:
        assert np.array_equal(file["station"][:], line.distance_stations)
        assert np.array_equal(found.distance_m, file["distance_m"][1].T)
        assert np.array_equal(found.confidence, file["confidence"][1].T)
    assert found.distance_m.dtype == np.float32 and found.confidence.dtype == np.uint8
    assert np.shares_memory(found.distance_m, room.distances(line.id, station).distance_m)


def test_mapped_arrays_cannot_be_written(room):
    station = room.lines[0].distance_stations[0]
    for array in (room.frame("z1", 0), *room.distances(0, station)):
        with pytest.raises(ValueError):
            array[0] = 1
        with pytest.raises(ValueError):
            array.setflags(write=True)
        with pytest.raises(ValueError):
            array.T[::2].setflags(write=True)
    for array in (room.lines[0].along_m, room.lines[0].positions_m):
        with pytest.raises(ValueError):
            array[0] = 1


def test_arrays_keep_the_volume_mapped(room_folder):
    room = raywalk.Room(room_folder)
    gone = weakref.ref(room)
    part = room.frame("x1", 3)[10:20, ::7]
    distances = room.distances("x1", room.lines[1].distance_stations[0]).distance_m
    expected, expected_m = part.copy(), distances.copy()
    del room
    gc.collect()
    assert gone() is None
    mapped = pathlib.Path("/proc/self/maps").read_text()
    assert str(room_folder / "lines" / "x1.h5") in mapped
    assert np.array_equal(part, expected) and np.array_equal(distances, expected_m)


def test_nothing_stays_mapped_without_arrays(room_folder):
    script = (
        "import gc, pathlib, sys, raywalk\n"
        "room = raywalk.Room(sys.argv[1])\n"
        "frame = room.frame('x0', 0)\n"
        "path = room.path([[0.0, 0.0]], width_px=64)\n"
        "for name in ('room', 'frame', 'path'):\n"
        "    print('x0.h5' in pathlib.Path('/proc/self/maps').read_text())\n"
        "    del globals()[name]\n"
        "    gc.collect()\n"
        "print('x0.h5' in pathlib.Path('/proc/self/maps').read_text())\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", script, room_folder], capture_output=True, text=True
    )
    assert done.stdout.split() == ["True", "True", "True", "False"], done.stderr


def test_lines_and_cells(room):
    assert [line.id for line in room.lines] == ["x0", "x1", "z0", "z1"]
    back = room.lines[0]
    assert back.axis == "x" and back.direction == pytest.approx((1.0, 0.0))
    assert back.positions_m.shape == (31, 3)
    assert back.positions_m[0] == pytest.approx([-0.75, 0.0, -0.5])
    assert np.diff(back.along_m) == pytest.approx(np.full(30, 0.05))
    assert back.files[1].endswith("back_002.jpg")
    assert room.line(back) is room.lines[0] and room.line(3).id == "z1"
    (cell,) = room.cells
    assert cell[:4] == pytest.approx((-0.5, 0.5, -0.5, 0.5))
    assert (cell.front, cell.right, cell.back, cell.left) == ("x1", "z1", "x0", "z0")
    assert room.cell_at(0.1, -0.2) == cell and room.cell_at(2.0, 0.0) is None
    assert room.distances_origin == "given"
    assert "4 lines, 1 cell, panoramas 512x256" in repr(room)


def test_what_is_not_there_is_named(room, room_folder, tmp_path):
    with pytest.raises(raywalk.Error, match="nothing.lf"):
        raywalk.Room(tmp_path / "nothing.lf")
    with pytest.raises(raywalk.UsageError, match="no line 'x9'; did you mean"):
        room.frame("x9", 0)
    with pytest.raises(raywalk.UsageError, match="no line 4; give 0 to 3"):
        room.frame(4, 0)
    for station in (-1, 31):
        with pytest.raises(raywalk.UsageError, match=f"no station {station}; give 0 to 30"):
            room.frame("x0", station)
    with pytest.raises(raywalk.Error, match="station 1 of line x0 has no distance map; stations 0"):
        room.distances("x0", 1)
    assert issubclass(raywalk.UsageError, raywalk.Error)
    assert issubclass(raywalk.UsageError, ValueError)


def test_warnings_are_those_of_python(room_folder, tmp_path):
    folder = tmp_path / "old.lf"
    folder.mkdir()
    for part in room_folder.iterdir():
        (folder / part.name).symlink_to(part)
    (folder / "gains.h5").write_bytes(b"of no one")
    with pytest.warns(RuntimeWarning, match="not recorded") as caught:
        assert raywalk.Room(folder).distances_origin == "given"
    assert caught[0].filename == __file__
    with warnings.catch_warnings(), pytest.raises(RuntimeWarning):
        warnings.simplefilter("error")
        raywalk.Room(folder)
