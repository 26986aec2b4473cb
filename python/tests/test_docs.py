"""The code of docs/python.md, on small sizes."""

import functools
import os
import pathlib
import re
import sys
from unittest import mock

import numpy as np
import pytest

from raywalk import error_model

from conftest import PROGRAMS, SCENE

PAGE = (pathlib.Path(os.environ["RAYWALK_DOCS"]) / "python.md").read_text()


def code(begin, language="python"):
    """The block of the page that begins with these words."""
    blocks = re.findall(rf"^```{language}\n(.*?)^```$", PAGE, re.DOTALL | re.MULTILINE)
    (block,) = [block for block in blocks if block.startswith(begin)]
    return block


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """An empty working folder, with the programs on the path and nothing drawn."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PATH", f"{PROGRAMS}{os.pathsep}{os.environ['PATH']}")
    pyplot = mock.MagicMock()
    pyplot.subplots.return_value = (mock.MagicMock(), [mock.MagicMock() for _ in range(3)])
    monkeypatch.setitem(sys.modules, "matplotlib", mock.MagicMock(pyplot=pyplot))
    monkeypatch.setitem(sys.modules, "matplotlib.pyplot", pyplot)
    return tmp_path


def test_rooms_and_views(folder, room_folder, capsys):
    (folder / "room.lf").symlink_to(room_folder)
    (folder / "walk.csv").write_text("\n".join((SCENE / "walk.csv").read_text().splitlines()[:4]))
    exec(code("import raywalk").replace("1024", "64").replace("(1440, 1600)", "(144, 160)"), {})
    assert capsys.readouterr().out.splitlines()[0] == "walk_000 (32, 64, 3)"
    assert (folder / "view.png").exists()


def test_figure_11(folder, monkeypatch, capsys):
    fewer = functools.partial(error_model.connection_error_curve, viewpoints=7)
    monkeypatch.setattr(error_model, "connection_error_curve", fewer)
    exec(code("# fig11.py"), {})
    assert re.fullmatch(r"(\S+ N: least E_t 0\.\d+ at k = [78]\d\n){3}", capsys.readouterr().out)


def test_figure_13(folder):
    small = code("# fig13.yaml", "yaml").replace("1024", "128").replace("50}", "200}")
    (folder / "fig13.yaml").write_text(small)
    names = {}
    exec(code("# fig13.py"), names)
    assert names["z_cm"] == pytest.approx([80, 60, 40, 20])
    psnr_db = {method: np.array(all)[:, 0] for method, all in names["scores"].items()}
    assert (psnr_db["hlf-vd"] > psnr_db["initial"] + 3.0).all()
