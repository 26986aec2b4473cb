"""That the stub tells what the extension has, and that everything public is documented."""

import ast
import inspect
import pathlib
import typing

import raywalk
from raywalk import _native, view_settings


def test_the_stub_tells_what_the_extension_has():
    stub = ast.parse(pathlib.Path(_native.__file__).with_name("_native.pyi").read_text())
    told = {node.name for node in stub.body if isinstance(node, (ast.FunctionDef, ast.ClassDef))}
    assert told == {name for name in vars(_native) if not name.startswith("_")}
    for node in stub.body:
        if isinstance(node, ast.ClassDef) and node.name in ("Room", "PathViews"):
            methods = {f.name for f in node.body if isinstance(f, ast.FunctionDef)} - {"__init__"}
            assert methods == {
                n for n in vars(getattr(_native, node.name)) if not n.startswith("_")
            }
    assert pathlib.Path(_native.__file__).with_name("py.typed").exists()


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
