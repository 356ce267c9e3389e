"""Python's values as the program's texts."""

from __future__ import annotations

import json
import numbers
import operator
import os
import pathlib
import shutil
import sys
from typing import Any, Iterable, Mapping

#: Messages about a dict begin with this name. The dict is one line of YAML, so a line number would say nothing.
SCENARIO_NAME = "scenario"
SWEEP_NAME = "sweep"


def other_python(package: str) -> str:
    """Why the package's module cannot be imported: it is for one version of Python."""
    modules = sorted(pathlib.Path(package).parent.glob("_core.cpython-*.so"))
    here = f"CPython {sys.version_info.major}.{sys.version_info.minor} ({sys.executable})"
    if not modules:
        return f"metabuffer has no module _core beside {package}; build and install it, see docs/installing.md"
    tag = modules[0].name.split("-")[1]
    version = f"{tag[0]}.{tag[1:]}"
    program = shutil.which(f"python{version}", path="/usr/bin")
    return (f"metabuffer's module {modules[0].name} is for CPython {version}{f' ({program})' if program else ''}, and this "
            f"is {here}; use that one, or build the module for this one with cmake -DPython_EXECUTABLE={sys.executable}")


def _plain(value: Any) -> Any:
    """Converts values that json does not know: paths, and numbers and arrays of numpy."""
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    for convert in ("tolist", "item"):
        if hasattr(value, convert):
            return getattr(value, convert)()
    raise TypeError(f"{type(value).__name__} is not a value of a scenario; use numbers, texts, lists and dicts")


def yaml_text(value: Any) -> str:
    """As YAML in flow style, on one line."""
    return json.dumps(value, default=_plain)


def setting_text(value: Any) -> str:
    """A value as ``--set KEY=VALUE`` takes it: a text is YAML already."""
    return value if isinstance(value, str) else yaml_text(value)


def _wrong_type(name: str, value: Any, wanted: str) -> TypeError:
    return TypeError(f"{name}: is {type(value).__name__}; use {wanted}")


def word(name: str, value: str | None) -> str:
    """An argument that is a text; None becomes the empty one."""
    if value is not None and not isinstance(value, str):
        raise _wrong_type(name, value, "a text")
    return value or ""


def flag(name: str, value: bool) -> bool:
    """An argument that is True or False, numpy's among them."""
    if str(value) not in ("True", "False") or isinstance(value, str):
        raise _wrong_type(name, value, "True or False")
    return bool(value)


def whole(name: str, value: int | None) -> int | None:
    """An argument that is a whole number or None."""
    if value is None:
        return None
    try:
        # These limits are beyond any option's range, but the extension can still convert them.
        return max(-2**31, min(2**31 - 1, operator.index(value)))
    except TypeError:
        raise _wrong_type(name, value, "a whole number") from None


def number(name: str, value: float | None) -> float | None:
    """An argument that is a number or None."""
    if value is not None and not isinstance(value, numbers.Real):
        raise _wrong_type(name, value, "a number")
    return None if value is None else float(value)


def keyed(name: str, values: Mapping[str, Any] | None) -> Mapping[str, Any]:
    """An argument that is a dict by scenario keys; None becomes the empty one."""
    if values is None:
        return {}
    if not isinstance(values, Mapping):
        raise _wrong_type(name, values, 'a dict, like {"bus.width_bits": 64}')
    for key in values:
        if not isinstance(key, str):
            raise TypeError(f'{name}: the key {key!r} is no text; use one like "bus.width_bits"')
    return values


def settings(values: Mapping[str, Any] | None, frames: int | None) -> list[tuple[str, str]]:
    """Overrides of a scenario's keys."""
    pairs = [(key, setting_text(value)) for key, value in keyed("set", values).items()]
    if frames is not None:
        pairs.append(("frames", setting_text(frames)))
    return pairs


def list_text(values: Any) -> str:
    """The values of an axis as ``--over KEY=VALUES`` takes them: a text as it is, others joined by commas."""
    if isinstance(values, str):
        return values
    if not isinstance(values, Iterable) or isinstance(values, Mapping):
        values = [values]
    return ",".join(setting_text(value) for value in values)


def is_description(source: Any) -> bool:
    """Whether the source is a dict and not the name of a file."""
    if isinstance(source, Mapping):
        return True
    if isinstance(source, (str, bytes, os.PathLike)):
        return False
    raise TypeError(f"a file's name or a dict is wanted, not {type(source).__name__}")


def source(value: Any, name: str) -> tuple[bytes, str | None]:
    """The extension's arguments for a source: a file's name and None; for a dict its name in messages and its YAML."""
    if is_description(value):
        return name.encode(), yaml_text(value)
    return os.fsencode(value), None


def with_absolute_images(scenario: Mapping[str, Any]) -> dict[str, Any]:
    """The same scenario with absolute paths of its images, for any folder. Parts with other types stay as they are."""
    copy = json.loads(yaml_text(scenario))
    renderers = copy.get("renderers")
    for renderer in renderers if isinstance(renderers, list) else []:
        frames = renderer.get("frames") if isinstance(renderer, dict) else None
        for frame in frames if isinstance(frames, list) else []:
            for key in ("image", "depth"):
                if isinstance(frame, dict) and isinstance(frame.get(key), str):
                    frame[key] = str(pathlib.Path.cwd() / frame[key])
    return copy
