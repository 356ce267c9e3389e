"""Shows how far a long run is."""

import sys
import time

SECONDS_BETWEEN_LINES = 10  # if the output is no terminal


class Progress:
    """On a terminal one line, which is overwritten; elsewhere a new line now and then."""

    def __init__(self, what: str, total: int):
        self.what, self.total, self.done = what, total, 0
        self.started = self.shown = time.monotonic()
        self.terminal = sys.stdout.isatty()

    def seconds(self) -> float:
        return time.monotonic() - self.started

    def step(self, count: int = 1, note: str = "") -> None:
        """Adds to the count, and shows it with the note after it."""
        self.done += count
        now = time.monotonic()
        if self.terminal or now - self.shown >= SECONDS_BETWEEN_LINES:
            self.shown = now
            self.show(note)

    def finish(self) -> None:
        """Shows the last line, which stays."""
        if self.total > 0:
            self.show()
            if self.terminal:
                print()

    def show(self, note: str = "") -> None:
        line = f"{self.done} of {self.total} {self.what}{note}, {self.seconds():.0f} s"
        print(f"\r{line}\033[K" if self.terminal else line, end="" if self.terminal else "\n", flush=True)

    def say(self, line: str) -> None:
        """Prints a line that stays, and does not change the count."""
        print(f"\r{line}\033[K" if self.terminal else line, flush=True)
