"""What a command costs, and tables of it."""

import os
import subprocess
import sys
import tempfile
import time
from typing import Any, NamedTuple, Sequence

from lib.project import SCRIPT


class Measurement(NamedTuple):
    """Wall time, and processor time in the program (user) and in the system's kernel for it (system)."""

    output: str
    seconds: float
    user_seconds: float
    system_seconds: float
    mebibytes: float


def measured(*command: Any, stderr: Any = None, cwd: Any = None) -> Measurement:
    """Runs a command, which must succeed. Processes that it starts count if it waits for them."""
    words = [str(word) for word in command]
    with tempfile.TemporaryFile("w+") as output:
        started = time.perf_counter()
        process = subprocess.Popen(words, stdin=subprocess.DEVNULL, stdout=output, stderr=stderr, cwd=cwd)
        _, status, usage = os.wait4(process.pid, 0)
        seconds = time.perf_counter() - started
        process.returncode = os.waitstatus_to_exitcode(status)
        if process.returncode != 0:
            sys.exit(f"{SCRIPT}: exit status {process.returncode}: {' '.join(words)}")
        output.seek(0)
        return Measurement(output.read(), seconds, usage.ru_utime, usage.ru_stime, usage.ru_maxrss / 1024)


def print_aligned(rows: Sequence[Sequence[Any]]) -> None:
    """Prints a table with text in the first column and figures in the others."""
    widths = [max(len(str(row[column])) for row in rows) for column in range(len(rows[0]))]
    for row in rows:
        cells = [str(cell).ljust(width) if column == 0 else str(cell).rjust(width)
                 for column, (cell, width) in enumerate(zip(row, widths))]
        print("  " + "   ".join(cells).rstrip())


def print_markdown(rows: Sequence[Sequence[Any]]) -> None:
    """Prints a table in Markdown, everything in it to the right. The first row has the headings."""
    cells = [[str(cell) for cell in row] for row in rows]
    widths = [max(map(len, column)) for column in zip(*cells)]
    cells.insert(1, ["-" * (width - 1) + ":" for width in widths])
    for row in cells:
        print("| " + " | ".join(cell.rjust(width) for cell, width in zip(row, widths)) + " |")
