"""Runs and analyses of a scenario."""

from __future__ import annotations

import dataclasses
import json
import mmap
import os
from typing import Any, Mapping, Union

import numpy

from . import _core, _texts
from ._errors import BY_STATUS, UNSOUND_BY_STATUS, CrashError, Error

#: A scenario or a sweep: a YAML file, or a dict with the same keys.
Source = Union[str, bytes, "os.PathLike[Any]", Mapping[str, Any]]


@dataclasses.dataclass(frozen=True, repr=False)
class Result:
    """What a run leaves. The names are those of report.json, which ``docs/report.md`` explains."""

    #: report.json. Cycles are clocks of the core.
    report: dict[str, Any]
    #: What the displays show, from the first on: for each an array of ``uint8`` with the shape (frames shown, height,
    #: width, 3), in red, green and blue. Without images the arrays have no frames.
    displays: list[numpy.ndarray]
    #: What the program prints after a run.
    summary: str
    #: The scenario with every key and its value, as YAML; images relative to the working directory of the run.
    effective_scenario: str
    #: The text of report.json, to the byte.
    report_json: str
    #: Wall time in the simulator; 0 at level functional.
    simulation_seconds: float
    #: Displays side by side in a row of the wall.
    columns: int

    @property
    def frames(self) -> list[dict[str, Any]]:
        """Each composited frame's clocks, pairs, starved and wrong pixels; level functional has none."""
        return self.report.get("frames", [])

    @property
    def rates(self) -> dict[str, Any]:
        """Frames a second, by what is counted; level functional has none."""
        return self.report.get("rates", {})

    @property
    def frames_per_second(self) -> float | None:
        """The least of the machine's rates; None with fewer than three frames."""
        return self.rates.get("frames_per_second")

    @property
    def totals(self) -> dict[str, Any]:
        """The counters of all renderers, composers and displays together."""
        return self.report.get("totals", {})

    @property
    def starved_pixels(self) -> int | None:
        """Raster pixels whose local pixel did not come in time, all composers."""
        return self.totals.get("starved_pixels")

    @property
    def wrong_pixels(self) -> int | None:
        """Shown pixels that differ from those of a machine in which nothing starves; None if they were not counted."""
        return self.totals.get("wrong_pixels")

    @property
    def core_cycles(self) -> int | None:
        """Clocks of the core until the last frame has been shown."""
        return self.report.get("core_cycles")

    def wall(self, frame: int = -1) -> numpy.ndarray:
        """A frame on all displays side by side, ``uint8`` with the shape (height, width, 3) of the wall."""
        pictures = [display[frame] for display in self.displays]
        rows = [numpy.concatenate(pictures[first:first + self.columns], axis=1)
                for first in range(0, len(pictures), self.columns)]
        return numpy.concatenate(rows, axis=0)

    def __repr__(self) -> str:
        return self.summary.rstrip("\n")


def answer(reply: tuple[int, bytes, bool]) -> str:
    """The text of the extension's answer. Raises the error that the answer reports."""
    status, data, crashed = reply
    text = data.decode(errors="backslashreplace")
    if crashed:
        raise CrashError(f"metabuffer: the process of the call {text}")
    if status != 0 and status not in UNSOUND_BY_STATUS:
        raise BY_STATUS.get(status, Error)(text.replace(f"{_texts.SCENARIO_NAME}:1: ", f"{_texts.SCENARIO_NAME}: ")
                                           .replace(f"{_texts.SWEEP_NAME}:1: ", f"{_texts.SWEEP_NAME}: "))
    return text


def _displays(pictures: int, content: dict[str, Any]) -> list[numpy.ndarray]:
    """The arrays of a run, in the memory into which its process has written them."""
    frames, height, width = content["frames"], content["height"], content["width"]
    shown = content["shown"]
    if not any(shown):
        return [numpy.zeros((0, height, width, 3), numpy.uint8) for _ in shown]
    values = numpy.frombuffer(mmap.mmap(pictures, 0), numpy.uint8)
    wall = values.reshape(len(shown), frames, height, width, 3)
    return [wall[display, :count] for display, count in enumerate(shown)]


def run(scenario: Source, *, level: str | None = None, set: Mapping[str, Any] | None = None,
        frames: int | None = None, images: bool = True, check: bool = False) -> Result:
    """Runs a scenario, as ``metabuffer run`` does.

    The run is a process of its own: whatever happens there, the interpreter goes on. Ctrl-C ends it. Several threads
    may run at once.

    scenario: a YAML file, or a dict with the same keys. Paths of images are relative to the file; in a dict, to the
        working directory. Values may also be paths, and numbers and arrays of numpy.
    level: ``"tlm"`` (by transactions, the default), ``"rtl"`` (clock by clock; the default with check) or
        ``"functional"`` (the pictures alone, no time).
    set: values that replace those of the scenario: ``{"bus.width_bits": 64}``. A text is YAML, as on the command line.
    frames: composited frames to show, instead of the scenario's number.
    images: False: counters alone. Level tlm then composites nothing, which is faster.
    check: check every wire against the machine's rules and every pixel against level functional (level rtl), or the
        pictures alone (level tlm).

    Returns a :class:`Result`: the report as a dict, and for each display an array of ``uint8`` with the shape (frames,
    height, width, 3).

    Raises :class:`InputError` for bad input; :class:`WatchdogError` if nothing moved any more, and :class:`CheckError`
    if a rule was broken, each with the ``result``; :class:`ModelError` if the model is at fault; :class:`CrashError` if
    its process ended without an answer.
    """
    file, text = _texts.source(scenario, _texts.SCENARIO_NAME)
    settings = _texts.settings(set, frames)
    pictures = os.memfd_create("metabuffer")
    try:
        reply = _core.run(file, text, settings, _texts.word("level", level), _texts.flag("images", images),
                          _texts.flag("check", check), pictures)
        content = json.loads(answer(reply))
        result = Result(json.loads(content["report"]), _displays(pictures, content), content["summary"],
                        content["effective_scenario"], content["report"], content["simulation_seconds"],
                        content["columns"])
    finally:
        os.close(pictures)
    if reply[0] != 0:
        raise UNSOUND_BY_STATUS[reply[0]](content["judgement"].rstrip("\n"), result)
    return result


def analyze(scenario: Source, *, set: Mapping[str, Any] | None = None, frames: int | None = None,
            frame_rate_hz: float | None = None) -> dict[str, Any]:
    """Bandwidth and buffers of a scenario by arithmetic, without a run, as ``metabuffer analyze --json`` has them.

    scenario, set and frames: as :func:`run` has them.
    frame_rate_hz: frames a second to be carried; None: as fast as the raster goes.

    Returns a dict whose keys' names have the units. ``docs/analysis.md`` explains it. Raises :class:`InputError`.
    """
    file, text = _texts.source(scenario, _texts.SCENARIO_NAME)
    settings = _texts.settings(set, frames)
    return json.loads(answer(_core.analyze(file, text, settings, _texts.number("frame_rate_hz", frame_rate_hz))))
