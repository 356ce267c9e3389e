"""Sweeps, searches and tables of their results."""

from __future__ import annotations

import contextlib
import json
import os
import pathlib
import tempfile
from typing import TYPE_CHECKING, Any, Iterator, Mapping, Sequence

from . import _core, _texts
from ._errors import InputError
from ._run import Source, answer

if TYPE_CHECKING:
    import pandas

#: What a table's ``attrs`` say about the results besides the units.
_FACTS = ("name", "scenario", "level", "keys", "search_key", "goal")


def _frame(text: str) -> "pandas.DataFrame":
    """A table from the extension's answer."""
    import pandas  # loading it takes longer than a small run

    content = json.loads(text)
    frame = pandas.DataFrame(content["rows"], columns=content["columns"])
    frame.attrs["units"] = content["units"]
    frame.attrs.update({name: content[name] for name in _FACTS})
    return frame


def _how(processes: int | None, time_limit: float | None, level: str | None,
         quiet: bool) -> tuple[int | None, float | None, str, bool]:
    """How an exploration runs, as arguments of the extension."""
    return (_texts.whole("processes", processes), _texts.number("time_limit", time_limit), _texts.word("level", level),
            _texts.flag("quiet", quiet))


@contextlib.contextmanager
def _results_file(out: Any) -> Iterator[bytes]:
    """The file for the results: the one that is asked for, or a temporary one."""
    if out is not None:
        yield os.fsencode(out)
        return
    with tempfile.TemporaryDirectory(prefix="metabuffer-") as folder:
        yield os.fsencode(os.path.join(folder, "results.db"))


@contextlib.contextmanager
def _scenario_file(scenario: Any, out: Any) -> Iterator[bytes]:
    """The scenario as a file, since explorations read files. A dict is written to a temporary one."""
    if not _texts.is_description(scenario):
        yield os.fsencode(scenario)
        return
    if out is not None:
        raise InputError("out: results that are kept name the scenario's file, and a dict has none; write it into a file, "
                         "or leave out")
    with tempfile.TemporaryDirectory(prefix="metabuffer-") as folder:
        file = pathlib.Path(folder, f"{_texts.SCENARIO_NAME}.yaml")
        file.write_text(_texts.yaml_text(_texts.with_absolute_images(scenario)))
        try:
            yield os.fsencode(file)
        except InputError as error:
            # The user does not know the temporary file, so the message must not name it.
            raise InputError(str(error).replace(f"{file}:1: ", f"{_texts.SCENARIO_NAME}: ")
                             .replace(str(file), _texts.SCENARIO_NAME)) from None


def sweep(sweep: Source, *, out: Any = None, processes: int | None = None,
          level: str | None = None, time_limit: float | None = None, quiet: bool = False) -> "pandas.DataFrame":
    """Runs a scenario over ranges of its keys, as ``metabuffer sweep`` does.

    sweep: a sweep's YAML file, or a dict with the same keys: ``{"scenario": "case-4.yaml", "axes": [{"key":
        "bus.width_bits", "values": [64, 128]}]}``. Paths are relative to the file; in a dict, to the working directory.
    out: keep the results in this SQLite file. Points that an existing file has already are not run again, and Ctrl-C
        loses nothing. None: the results are in the table alone.
    processes: simulations at once; None: one for each processor and one more.
    level: ``"tlm"``, the default, or ``"rtl"``.
    time_limit: seconds after which a simulation is ended and counts as a crash.
    quiet: show no progress. Progress is shown on a terminal only.

    Returns a table as :func:`results` does, a row for each point. A point that fails is a row, too: its ``status`` and
    ``reason`` say why. Raises :class:`InputError` for bad input, and if no point makes a scenario.
    """
    with contextlib.ExitStack() as files:
        if _texts.is_description(sweep) and isinstance(sweep.get("scenario"), Mapping):
            file = files.enter_context(_scenario_file(sweep["scenario"], out))
            sweep = {**sweep, "scenario": os.fsdecode(file)}
        results_file = files.enter_context(_results_file(out))
        file, text = _texts.source(sweep, _texts.SWEEP_NAME)
        return _frame(answer(_core.sweep(file, text, results_file, *_how(processes, time_limit, level, quiet))))


def size(scenario: Source, minimize: str, *, over: Mapping[str, Any] | None = None,
         set: Mapping[str, Any] | None = None, frames: int | None = None, goal: str | None = None,
         frame_rate_hz: float | None = None, checks: int | None = None, out: Any = None, processes: int | None = None,
         level: str | None = None, time_limit: float | None = None, quiet: bool = False) -> "pandas.DataFrame":
    """The smallest value of a key at which a machine meets a goal, as ``metabuffer size`` finds it.

    scenario, set and frames: as :func:`run` has them.
    minimize: ``"composer.buffer_pixels"``, or with a range: ``"bus.burst_pixels=1..256"``,
        ``"clocks.core_mhz=50..200+0.5"``, ``"bus.width_bits=32,64,128"``.
    over: search at each of these values: ``{"bus.width_bits": [64, 128]}``. A text is a range, as ``"64..512*2"``.
    goal: says which values are good: an SQL expression over the figures of a run and the keys that vary; None: nothing
        starves, stalls or is rejected.
    frame_rate_hz: the machine must also show that many frames a second, which takes three frames or more.
    checks: further values that are tried, to check that the goal is monotonic; None: 16.
    out, processes, level, time_limit, quiet: as :func:`sweep` has them.

    Returns a table as :func:`results` does, a row for each setting of ``over``; ``smallest`` is the answer, in the unit of
    the key. Raises :class:`InputError`.
    """
    axes = [f"{key}={_texts.list_text(values)}" for key, values in _texts.keyed("over", over).items()]
    with _scenario_file(scenario, out) as file, _results_file(out) as results_file:
        return _frame(answer(_core.size(
            file, _texts.settings(set, frames), _texts.word("minimize", minimize), axes, _texts.word("goal", goal),
            _texts.number("frame_rate_hz", frame_rate_hz), _texts.whole("checks", checks), results_file,
            *_how(processes, time_limit, level, quiet))))


def results(db: "str | bytes | os.PathLike[Any]", *, where: str | None = None,
            columns: str | Sequence[str] | None = None) -> "pandas.DataFrame":
    """The results of a sweep or a search as a table, as ``metabuffer export --bookkeeping`` has them, even while
    it still runs.

    db: the SQLite file.
    where: only the points for which this SQL expression over the columns is true: ``"whole"``.
    columns: these expressions instead of all columns: a list, or a text with commas in between.

    Returns a row for each point, in the order of the axes' values: ``point``, the axes' keys, ``status``, ``reason``, and
    the figures of its run, which ``docs/results.md`` explains. ``table.attrs["units"]`` is a dict from a column to its
    unit (``"clocks"``, ``"pixels"``, ``"frames/s"``); columns without a unit are not in it. ``attrs`` has ``name``,
    ``scenario``, ``level``, ``keys``, ``search_key`` and ``goal`` of the results as well. Raises :class:`InputError`.
    """
    if columns is not None and not isinstance(columns, str):
        columns = ", ".join(columns)
    return _frame(answer(_core.results(os.fsencode(db), _texts.word("where", where), _texts.word("columns", columns))))
