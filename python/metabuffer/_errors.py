"""What can go wrong, by the program's exit statuses."""

from __future__ import annotations

from typing import Any


class Error(Exception):
    """An error with the program's message. ``status`` is the exit status with which the program would end."""

    status: int = 1


class InputError(Error, ValueError):
    """Bad input, or a file that cannot be written. The message says where, what is wrong, and what would be right."""

    status = 2


class ModelError(Error):
    """A block found its protocol broken: the model is at fault."""

    status = 1


class CrashError(Error):
    """The process of the call ended without an answer, by a signal or for lack of memory. The interpreter goes on."""

    status = 1


class StoppedError(Error):
    """Another signal than Ctrl-C's stopped an exploration. With results in a file the same call goes on from there."""

    status = 130


class UnsoundRunError(Error):
    """A run that ended, but cannot be trusted. ``result`` is what it has left, as :func:`run` returns it."""

    def __init__(self, message: str, result: Any = None) -> None:
        super().__init__(message)
        self.result = result


class WatchdogError(UnsoundRunError):
    """Nothing moved any more, and the watchdog ended the run. The message says which block waits for what."""

    status = 4


class CheckError(UnsoundRunError):
    """A checked run broke a rule of the machine. The message has the first violations."""

    status = 5


#: The errors that have no result.
BY_STATUS = {error.status: error for error in (ModelError, InputError, StoppedError)}
UNSOUND_BY_STATUS = {error.status: error for error in (WatchdogError, CheckError)}
