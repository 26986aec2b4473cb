"""That everything public is documented."""

import inspect
import typing

import raywalk
from raywalk import view_settings


def test_view_settings_lists_every_setting(room):
    listed = set(typing.get_type_hints(view_settings.ViewSettings))
    used = set(room.view_settings()) - {"k_source", "reason"}
    # A settings file may name a preset; what is demanded of a measurement is no setting of a view.
    others = ["settings", "preset", "budget_ms", "min_psnr_db"]
    assert listed == used.union(others, ["fov_deg", "size_px", "stereo", "ipd_mm"])


def test_everything_public_is_documented():
    for module in (raywalk, raywalk.metrics, raywalk.error_model):
        for name in module.__all__:
            thing = getattr(module, name)
            if inspect.isfunction(thing) or inspect.isclass(thing):
                assert thing.__doc__, name
    for name, method in vars(raywalk.Room).items():
        if inspect.isfunction(method) and not name.startswith("_"):
            assert method.__doc__, name
