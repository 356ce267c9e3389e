"""The Metabuffer, an executable model of image-compositing hardware, from Python.

>>> import metabuffer
>>> result = metabuffer.run("scenarios/case-1.yaml", set={"bus.width_bits": 64})
>>> result.starved_pixels, result.displays[0].shape
(0, (1, 100, 100, 3))

Functions are those of the program: :func:`run`, :func:`analyze`, :func:`sweep`, :func:`size` and :func:`results`. Each
call works in a process of its own, so a crash of the model is an exception, and Ctrl-C ends it. Errors are subclasses
of :class:`Error`, with the program's message.
"""

try:
    from ._core import build as __build__
    from ._core import version as __version__
except ModuleNotFoundError as _error:
    from ._texts import other_python

    raise ImportError(other_python(__file__)) from _error
from ._errors import (CheckError, CrashError, Error, InputError, ModelError, StoppedError, UnsoundRunError,
                      WatchdogError)
from ._run import Result, analyze, run
from ._tables import results, size, sweep

__all__ = ["CheckError", "CrashError", "Error", "InputError", "ModelError", "Result", "StoppedError", "UnsoundRunError",
           "WatchdogError", "__build__", "__version__", "analyze", "results", "run", "size", "sweep"]

# So that messages and help() name the package that users import.
for _name in __all__:
    if isinstance(globals()[_name], type):
        globals()[_name].__module__ = __name__
