"""Compressed rooms: the same frames and views."""

import numpy as np
import pytest

import raywalk
from conftest import run


@pytest.fixture(scope="module")
def compressed(room_folder, tmp_path_factory):
    folder = tmp_path_factory.mktemp("compressed")
    for form in ("lossless", "jpeg:95"):
        out = folder / form.replace(":", "")
        run("raywalk-build-lf", "repack", room_folder, "--compress", form, "--out", out, "-q")
    return folder


def test_frames_are_what_was_packed(room_folder, compressed):
    raw = raywalk.Room(room_folder).frame("x0", 1)
    assert np.array_equal(raywalk.Room(compressed / "lossless").frame("x0", 1), raw)
    lossy = raywalk.Room(compressed / "jpeg95").frame("x0", 1)
    assert lossy.shape == raw.shape
    assert 0 < np.abs(lossy.astype(int) - raw).mean() < 3


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
