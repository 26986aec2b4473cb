"""The embedded room, packed once, and the programs to compare with."""

import os
import pathlib
import subprocess

import pytest

import raywalk

PROGRAMS = pathlib.Path(os.environ["RAYWALK_PROGRAMS"])
SCENE = pathlib.Path(os.environ["RAYWALK_TEST_ROOM"])


def run(program, *arguments, cwd=None):
    """Runs a program of Raywalk to its end; returns what it printed."""
    command = [PROGRAMS / program, *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True, cwd=cwd)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture(scope="session")
def room_folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("room") / "room.lf"
    maps = ["--distance", SCENE / "dist"]
    run("raywalk-build-lf", "pack", "--frames", SCENE / "poses.csv", *maps, "--out", folder, "-q")
    return folder


@pytest.fixture(scope="session")
def room(room_folder):
    return raywalk.Room(room_folder)


@pytest.fixture(scope="session")
def render():
    """Runs raywalk-render."""
    return lambda *arguments, **options: run("raywalk-render", *arguments, **options)
