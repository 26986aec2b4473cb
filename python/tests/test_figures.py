"""Error model and metrics, compared with the programs and the equations."""

import json

import numpy as np
import pytest

import raywalk
from raywalk import error_model, metrics

from conftest import SCENE

def printed_shift(d_src_m, phi_rad, apart_m):
    """(2) and (4) as the paper prints them."""
    rise, plan = d_src_m * np.sin(phi_rad), d_src_m * np.cos(phi_rad)
    return np.arctan2(rise, plan) - np.arctan2(rise, plan + apart_m)

def test_error_model_follows_the_printed_equations():
    d_src = np.array([0.7, 1.5, 4.0])[:, None, None]
    phi = np.radians(np.linspace(-80.0, 80.0, 9))[:, None]
    apart = np.array([0.01, 0.2, 1.1])
    shift = error_model.latitude_shift(d_src, phi, apart)
    assert shift.shape == (3, 9, 3)
    assert shift == pytest.approx(printed_shift(d_src, phi, apart), abs=1e-12)

    theta = np.radians(np.array([-85.0, 0.0, 30.0, 89.0]))
    plan = d_src * np.cos(phi)
    printed = np.sqrt((plan * np.cos(theta)) ** 2 + (plan * np.sin(theta) + 0.05) ** 2) - plan
    assert error_model.bending_distance(d_src, phi, theta, 0.05) == pytest.approx(
        printed, abs=1e-12
    )

    printed = np.arctan2(d_src * np.sin(phi), d_src * np.cos(phi) + apart)
    assert error_model.corrected_latitude(d_src, apart, phi) == pytest.approx(printed, abs=1e-12)
    # (1): the parallax that (5) corrects, d_p sin(phi) / d_src to first order.
    assert phi - error_model.corrected_latitude(d_src, apart, phi) == pytest.approx(
        shift, abs=1e-12
    )
    assert error_model.latitude_shift(150.0, 1.0, 1e-3) == pytest.approx(
        1e-3 * np.sin(1.0) / 150.0, rel=1e-5
    )

    to_side, to_front = np.array([0.9, 0.5, 0.05]), np.array([0.1, 0.4, 0.6])
    corner = np.degrees(np.arctan2(to_side, to_front))
    assert error_model.corner_angle_deg(to_side, to_front) == pytest.approx(corner)
    least, largest = error_model.connection_range(to_side, to_front)
    assert least == 45.0 and largest == pytest.approx(np.maximum(corner, 90.0 - corner))
    k = np.radians(47.0)
    printed = np.maximum((to_side - to_front * np.tan(k)) / np.cos(np.radians(90.0) - k), 0.0)
    assert error_model.mismatch_distance(to_side, to_front, 47.0) == pytest.approx(printed)

def test_error_model_of_numbers_is_a_number_and_of_nonsense_an_error():
    assert isinstance(error_model.latitude_shift(1.5, 0.3, 0.1), float)
    assert error_model.latitude_shift(np.inf, 0.3, 0.1) == 0.0
    assert error_model.latitude_shift(np.empty((0, 3)), 0.3, 0.1).shape == (0, 3)
    for arguments, words in [
        ((-1.0, 0.3, 0.1), "d_src_m is -1; it must be in 0..inf"),
        ((1.0, [0.3, np.nan], 0.1), "phi_rad is nan at value 1"),
        ((1.0, 0.3, -0.1), "apart_m is -0.1"),
        ((1.0, "near", 0.1), "phi_rad is neither a number"),
    ]:
        with pytest.raises(raywalk.UsageError, match=words):
            error_model.latitude_shift(*arguments)
    with pytest.raises(ValueError, match="broadcast"):
        error_model.latitude_shift(np.ones(2), np.zeros(3), 0.1)

def test_error_curves_are_those_of_the_program(render, tmp_path):
    options = "--step-m 0.15 --d-src 1.2,2.5 --viewpoints 9".split()
    render("error-model", *options, "--report", tmp_path / "fig11")
    report = json.loads((tmp_path / "fig11" / "error-model.json").read_text())
    for stated in report["curves"]:
        curve = error_model.connection_error_curve(stated["d_src_m"], step_m=0.15, viewpoints=9)
        assert curve.k_deg.tolist() == report["k_deg"]
        assert curve.e_m_rad == pytest.approx(stated["e_m_rad"], rel=1e-12, abs=1e-12)
        assert curve.e_b_rad == pytest.approx(stated["e_b_rad"], rel=1e-12, abs=1e-12)
        assert curve.e_t == pytest.approx(stated["e_t"], rel=1e-12, abs=1e-12)
        assert curve.optimum_k_deg == stated["optimum_k_deg"]

def test_metrics_are_those_of_the_program(room, room_folder, render, tmp_path):
    name = "quarter_pp"
    (tmp_path / "gt.csv").write_text(f"file,x,y,z\n{SCENE}/gt/{name}.png,0.25,0,0.25\n")
    truth = ["--truth", tmp_path / "gt.csv", "--method", "hlf-vd", "--viewpoints", "1"]
    render("validate", room_folder, *truth, "--report", tmp_path / "report")
    stated = json.loads((tmp_path / "report" / "metrics.json").read_text())
    scores = stated["views"][0]
    truth = raywalk.read_picture(SCENE / "gt" / f"{name}.png")
    view = room.view(0.25, 0.25, method="hlf-vd")
    assert metrics.psnr_db(view, truth) == scores["psnr_db"]
    assert metrics.ws_psnr_db(view, truth) == scores["ws_psnr_db"]
    assert metrics.ssim(view, truth) == scores["ssim"]
    assert metrics.fsim(view, truth) == scores["fsim"]

def test_metrics_by_their_definitions():
    rng = np.random.default_rng(5)
    a, b = rng.integers(0, 256, (2, 32, 64, 3), dtype=np.uint8)
    squares = (a.astype(float) - b) ** 2
    assert metrics.mean_squared_error(a, b) == pytest.approx(squares.mean(), rel=1e-14)
    assert metrics.psnr_db(a, b) == pytest.approx(
        10 * np.log10(255**2 / squares.mean()), rel=1e-14
    )
    weights = np.cos(np.pi / 2 - (np.arange(32) + 0.5) / 32 * np.pi)
    weighted = (weights @ squares.mean(axis=(1, 2))) / weights.sum()
    assert metrics.ws_psnr_db(a, b) == pytest.approx(10 * np.log10(255**2 / weighted), rel=1e-14)
    assert metrics.psnr_db(a, a) == np.inf
    assert metrics.ssim(a, a) == 1.0 and metrics.fsim(a, a) == 1.0
    # Colours are not exchanged: luma weighs red and blue differently.
    assert metrics.ssim(a, b) != metrics.ssim(a[..., ::-1], b[..., ::-1])
    mask = rng.random((32, 64)) < 0.3
    assert metrics.mean_squared_error(a, b, mask) == pytest.approx(squares[mask].mean(), rel=1e-14)
    turned = np.asfortranarray(a[::-1, ::2])
    assert metrics.mean_squared_error(turned, b[::-1, ::2]) == pytest.approx(
        squares[::-1, ::2].mean(), rel=1e-14
    )
    with pytest.raises(raywalk.Error, match="different sizes, 64x32 and 32x32"):
        metrics.ssim(a, b[:, :32])
    with pytest.raises(raywalk.UsageError, match="mask"):
        metrics.psnr_db(a, b, np.ones((32, 64)))
