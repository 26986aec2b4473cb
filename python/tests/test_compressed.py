"""Compressed rooms: the same views, and their volumes as h5py reads them."""

import h5py
import numpy as np
import pytest

import raywalk
import raywalk.hdf5
from conftest import run


@pytest.fixture(scope="module")
def compressed(room_folder, tmp_path_factory):
    folder = tmp_path_factory.mktemp("compressed")
    for form in ("lossless", "jpeg:95"):
        out = folder / form.replace(":", "")
        run("raywalk-build-lf", "repack", room_folder, "--compress", form, "--out", out, "-q")
    return folder


def rays(room, line="x0", station=1):
    with h5py.File(room / "lines" / f"{line}.h5") as file:
        return file["rays"][station]


def test_h5py_reads_what_was_packed(room_folder, compressed):
    raw = rays(room_folder)
    assert np.array_equal(rays(compressed / "lossless"), raw)
    lossy = rays(compressed / "jpeg95")
    assert lossy.shape == raw.shape
    assert 0 < np.abs(lossy.astype(int) - raw).mean() < 3


def test_frames_are_what_h5py_reads(compressed):
    for folder in compressed.iterdir():
        frame = raywalk.Room(folder).frame("x0", 1)
        stored = rays(folder)[: frame.shape[1]]
        assert np.array_equal(frame, stored.transpose(1, 0, 2))


def test_views_are_the_same_with_any_cache(room_folder, compressed):
    raw = raywalk.Room(room_folder).view(0.1, 0.1, method="two-sided")
    try:
        for megabytes in (1000, 1):
            raywalk.set_cache_mb(megabytes)
            view = raywalk.Room(compressed / "lossless").view(0.1, 0.1, method="two-sided")
            assert np.array_equal(view, raw)
        with pytest.raises(raywalk.UsageError):
            raywalk.set_cache_mb(0)
    finally:
        raywalk.set_cache_mb(1000)
