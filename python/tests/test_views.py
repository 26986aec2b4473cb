"""Views, compared with what raywalk-render writes."""

import subprocess
import threading
import time

import numpy as np
import pytest

import raywalk

def pixels_by_ffmpeg(picture, shape):
    """What another program reads from a picture file, as red, green, blue."""
    command = ["ffmpeg", "-v", "error", "-i", picture, "-f", "rawvideo", "-pix_fmt", "rgb24", "-"]
    return np.frombuffer(subprocess.run(command, capture_output=True).stdout, np.uint8).reshape(
        shape
    )

# What is asked of the module, and of the program.
VIEWS = {
    "two-sided": ({"method": "two-sided", "width_px": 256}, "--method two-sided --width 256"),
    "preset": ({"preset": "fast", "width_px": 256}, "--preset fast --width 256"),
    "parameters": (
        {"k_deg": 76, "overlap_deg": 7.5, "interpolation": "cubic", "stations_mixed": 3}
        | {"gains": False, "width_px": 128, "yaw_deg": 40.0, "pitch_deg": -10, "roll_deg": 3},
        "--k 76 --overlap-deg 7.5 --interpolation cubic --stations-mixed 3"
        " --no-gains --width 128 --yaw-deg 40 --pitch-deg -10 --roll-deg 3",
    ),
    "flat": (
        {"connection": "lfu", "method": "initial", "yaw_deg": -70, "fov_deg": 90, "size_px": (96, 128)},
        "--connection lfu --method initial --yaw-deg -70 --fov-deg 90 --size 96x128",
    ),
}

@pytest.mark.parametrize("name", VIEWS)
def test_a_view_is_what_the_program_writes(room, room_folder, render, tmp_path, name):
    settings, flags = VIEWS[name]
    written = tmp_path / "program.png"
    render("view", room_folder, "--at", "-0.1,0.25", *flags.split(), "--out", written)
    picture = room.view(-0.1, 0.25, **settings)
    assert np.array_equal(picture, pixels_by_ffmpeg(written, picture.shape))
    assert picture.flags.writeable and picture.flags.c_contiguous
    assert "-0.1,0.25" in room.write_view(tmp_path / "module.png", -0.1, 0.25, **settings)
    assert (tmp_path / "module.png").read_bytes() == written.read_bytes()
    assert np.array_equal(raywalk.read_picture(written), picture)

def test_heights_and_stereo_are_those_of_the_program(room, room_folder, render, tmp_path):
    written = tmp_path / "program.png"
    stereo = "--at -0.1,0.05,0.25 --stereo ods --ipd-mm 60 --width 128".split()
    render("view", room_folder, *stereo, "--out", written)
    picture = room.view(-0.1, 0.25, y_m=0.05, stereo="ods", ipd_mm=60, width_px=128)
    assert picture.shape == (128, 128, 3)
    assert np.array_equal(raywalk.read_picture(written), picture)
    (seen,) = room.path([[-0.1, 0.05, 0.25]], stereo="ods", ipd_mm=60, width_px=128)
    assert np.array_equal(seen, picture)
    raywalk.write_picture(tmp_path / "copy.png", picture)
    assert np.array_equal(raywalk.read_picture(tmp_path / "copy.png"), picture)

def test_a_settings_file_is_used_and_overridden(room, room_folder, render, tmp_path):
    (tmp_path / "view.yaml").write_text("method: two-sided\nk_deg: 80\nwidth_px: 128\n")
    settings = ["--settings", tmp_path / "view.yaml", "--k", "60"]
    render("view", room_folder, "--at", "0,0.1", *settings, "--out", tmp_path / "program.png")
    room.write_view(tmp_path / "module.png", 0.0, 0.1, settings=tmp_path / "view.yaml", k_deg=60)
    assert (tmp_path / "module.png").read_bytes() == (tmp_path / "program.png").read_bytes()
    used = room.view_settings(settings=tmp_path / "view.yaml", k_deg=60.0)
    assert used["method"] == "two-sided" and used["k_deg"] == 60.0
    assert used["width_px"] == 128 and used["k_source"] == "given"

TABLE = "name,x,z,yaw,pitch,roll\nfirst,0.0,0.38,0,0,0\nsecond,0.19,0.3,30,-5,2\n"

def test_a_path_is_what_the_program_writes(room, room_folder, render, tmp_path):
    table = tmp_path / "walk.csv"
    table.write_text(TABLE)
    render("path", room_folder, table, "--width", "128", "--out", tmp_path / "program")
    summary = room.write_path(table, tmp_path / "module", width_px=128)
    assert "2 views, 2 of them rendered now" in summary
    written = sorted(file.name for file in (tmp_path / "program").iterdir())
    assert written == ["first.png", "second.png", "views.json"]
    for name in written:
        by_module, by_program = tmp_path / "module" / name, tmp_path / "program" / name
        assert by_module.read_bytes() == by_program.read_bytes()

    path = room.path(table, width_px=128)
    assert len(path) == 2 and path.names == ["first", "second"]
    places = [[0.0, np.nan, 0.38], [0.19, np.nan, 0.3]]
    assert np.array_equal(path.viewpoints_m, places, equal_nan=True)
    by_points = room.path(
        path.viewpoints_m, yaw_deg=[0, 30], pitch_deg=[0, -5], roll_deg=[0, 2], width_px=128
    )
    for name, picture, same in zip(path.names, path, by_points):
        assert np.array_equal(picture, raywalk.read_picture(tmp_path / "module" / f"{name}.png"))
        assert np.array_equal(picture, same)
    assert list(path) == []

def test_a_path_keeps_its_room(room_folder):
    path = raywalk.Room(room_folder).path([[0.0, 0.1], [0.1, 0.1]], method="initial")
    assert [picture.shape for picture in path] == [(256, 512, 3)] * 2

def test_wrong_settings_are_refused_before_any_work(room, tmp_path):
    with pytest.raises(TypeError, match="unexpected keyword argument 'witdh_px'; .*'width_px'"):
        room.view(0.0, 0.0, witdh_px=64)
    for settings, words in [
        ({"k_deg": 44}, "--k is '44'; it must be in 45..90 degrees"),
        ({"width_px": 66}, "--width is '66'; it must be 0 or a multiple of 4 in 4..32768"),
        ({"method": "best"}, "--method is 'best'; it is not a valid choice"),
        ({"connection": "lfuu"}, "connection is 'lfuu'; did you mean 'lfu'"),
        ({"connection": "lfu", "k_deg": 80}, "connection lfu is k = 45 degrees"),
        ({"size_px": (64, 64)}, "give --fov-deg too"),
        ({"fov_deg": 200}, "field of view"),
        ({"fov_deg": "wide"}, "fov_deg is 'wide'; give a number"),
        ({"fov_deg": 90, "size_px": 64}, "size_px is '64'; give \\(width, height\\)"),
        ({"budget_ms": -1}, "--budget-ms is -1"),
        ({"stereo": "odss"}, "stereo is 'odss'; did you mean 'ods'"),
        ({"ipd_mm": 60}, "give --stereo ods too"),
    ]:
        with pytest.raises(raywalk.UsageError, match=words):
            room.view(0.0, 0.0, **settings)
    with pytest.raises(raywalk.Error, match="no trade was measured"):
        room.view(0.0, 0.0, budget_ms=50)
    with pytest.raises(raywalk.Error):
        room.view(float("nan"), 0.0)
    with pytest.raises(raywalk.Error, match="viewpoints: view '1'"):
        room.path([[0.0, 0.0], [9.0, 0.0]])
    with pytest.raises(raywalk.UsageError, match="shape \\(3,\\)"):
        room.path([0.0, 1.0, 2.0])
    with pytest.raises(raywalk.UsageError, match="yaw_deg"):
        room.path([[0.0, 0.0]] * 3, yaw_deg=[1.0, 2.0])
    with pytest.raises(raywalk.Error, match="walk.csv"):
        room.path(tmp_path / "walk.csv")

def test_pictures_that_are_none_are_refused(tmp_path):
    for picture in (np.zeros((4, 4)), np.zeros((4, 4), np.uint8), np.zeros((4, 4, 4), np.uint8)):
        with pytest.raises(raywalk.UsageError, match="give uint8 \\(height, width, 3\\)"):
            raywalk.write_picture(tmp_path / "picture.png", picture)
    with pytest.raises(raywalk.UsageError, match="end the name in .png, .jpg, .webp or .tif"):
        raywalk.write_picture(tmp_path / "picture.gif", np.zeros((4, 4, 3), np.uint8))
    assert list(tmp_path.iterdir()) == []

def test_other_threads_go_on_while_a_view_is_rendered(room):
    started = threading.Event()

    def work():
        started.set()
        room.view(0.1, 0.1, method="two-sided", width_px=4096)

    worker = threading.Thread(target=work)
    worker.start()
    started.wait()
    turns = 0
    while worker.is_alive():
        time.sleep(0.001)
        turns += 1
    assert turns > 20

@pytest.mark.parametrize("method", ["initial", "hlf-vd", "two-sided"])
def test_a_graphics_card_or_what_stands_in_for_one_shows_the_same(room, method):
    cell = room.cells[0]
    places = [
        (cell.x_min_m + right * (cell.x_max_m - cell.x_min_m), cell.z_min_m + far * (cell.z_max_m - cell.z_min_m))
        for right in (0.1, 0.95)
        for far in (0.05, 0.4)
    ]

    def views():
        return list(room.path(np.array(places), method=method))

    cpu = views()
    try:
        if raywalk.set_device("gpu") == "the processor":
            pytest.skip("no EGL here")
        gpu = views()
        single = [room.view(*place, method=method) for place in places]
    finally:
        assert raywalk.set_device("cpu") == "the processor"
    assert all(np.array_equal(a, b) for a, b in zip(single, gpu))
    assert min(raywalk.metrics.psnr_db(a, b) for a, b in zip(gpu, cpu)) > 45

def test_another_device_is_refused():
    with pytest.raises(raywalk.UsageError, match="'tpu' is unknown; use cpu, gpu, auto"):
        raywalk.set_device("tpu")
