"""Python's values as the program's texts."""

from __future__ import annotations

import json
import os
import pathlib
from typing import Any, Iterable, Mapping

#: Begins the messages about a dict; it is one line of YAML, so the line's number says nothing.
SCENARIO_NAME = "scenario"
SWEEP_NAME = "sweep"


def _plain(value: Any) -> Any:
    """What json does not know by itself: paths, and numbers and arrays of numpy."""
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


def settings(values: Mapping[str, Any] | None, frames: int | None) -> list[tuple[str, str]]:
    """Overrides of a scenario's keys."""
    if values is None:
        values = {}
    if not isinstance(values, Mapping):
        raise TypeError(f'set: is {type(values).__name__}; use a dict, like {{"bus.width_bits": 64}}')
    pairs = []
    for key, value in values.items():
        if not isinstance(key, str):
            raise TypeError(f'set: the key {key!r} is no text; use one like "bus.width_bits"')
        pairs.append((key, setting_text(value)))
    if frames is not None:
        pairs.append(("frames", setting_text(frames)))
    return pairs


def list_text(values: Any) -> str:
    """The values of an axis as ``--over KEY=VALUES`` takes them: a text as it is, else each of several."""
    if isinstance(values, str):
        return values
    if not isinstance(values, Iterable) or isinstance(values, Mapping):
        values = [values]
    return ",".join(setting_text(value) for value in values)


def is_description(source: Any) -> bool:
    """Whether it is a dict, and not the name of a file."""
    if isinstance(source, Mapping):
        return True
    if isinstance(source, (str, bytes, os.PathLike)):
        return False
    raise TypeError(f"a file's name or a dict is wanted, not {type(source).__name__}")


def source(value: Any, name: str) -> tuple[bytes, str | None]:
    """What the extension takes for a file's name, or for a dict: the name in messages and its text."""
    if is_description(value):
        return name.encode(), yaml_text(value)
    return os.fsencode(value), None


def with_absolute_images(scenario: Mapping[str, Any]) -> dict[str, Any]:
    """The same scenario with images that are found from any folder; what is no scenario is left as it is."""
    copy = json.loads(yaml_text(scenario))
    renderers = copy.get("renderers")
    for renderer in renderers if isinstance(renderers, list) else []:
        frames = renderer.get("frames") if isinstance(renderer, dict) else None
        for frame in frames if isinstance(frames, list) else []:
            for key in ("image", "depth"):
                if isinstance(frame, dict) and isinstance(frame.get(key), str):
                    frame[key] = str(pathlib.Path.cwd() / frame[key])
    return copy
