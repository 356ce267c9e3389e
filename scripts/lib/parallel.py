"""Work on several cores: a pool of threads, and the processes that they wait for."""

import concurrent.futures
import os
import pathlib
import signal
import subprocess
import threading
from typing import Any, Callable, Iterable, Iterator, Optional


def in_parallel(jobs: int, function: Callable[[Any], Any], items: Iterable[Any],
                stop: Callable[[], None] = lambda: None) -> Iterator[tuple[Any, Any]]:
    """Yields each item with the function's result, in the order in which the calls end. If the caller's loop ends
    early, as by Ctrl-C, calls that have not begun are left out, and stop is called, which must end the others."""
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        waiting = {pool.submit(function, item): item for item in items}
        try:
            for future in concurrent.futures.as_completed(waiting):
                yield waiting[future], future.result()
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            stop()
            raise


def alive_in(group: int) -> list[int]:
    """The living processes of a process group."""
    alive = []
    for entry in pathlib.Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                fields = (entry / "stat").read_text().rsplit(")", 1)[1].split()
            except OSError:  # it has just ended
                continue
            if int(fields[2]) == group and fields[0] != "Z":
                alive.append(int(entry.name))
    return alive


class Children:
    """The processes that the threads of a pool wait for; one object for all threads."""

    def __init__(self) -> None:
        self.running: set[subprocess.Popen] = set()
        self.lock = threading.Lock()
        self.stopped = False

    def run(self, command: list, timeout: float, **options: Any) -> tuple[Optional[int], str, str]:
        """Runs a process. Returns exit status, output and errors, the latter two if the options have them piped. A
        status of None is a timeout. Nothing that the process has started outlives it."""
        with self.lock:
            if self.stopped:
                raise InterruptedError
            process = subprocess.Popen(list(map(str, command)), stdin=subprocess.DEVNULL, start_new_session=True,
                                       **options)
            self.running.add(process)
        try:
            out, err = process.communicate(timeout=timeout)
            return process.returncode, out or "", err or ""
        except subprocess.TimeoutExpired:
            self.end(process)
            process.communicate()
            return None, "", ""
        finally:
            self.end(process)
            with self.lock:
                self.running.discard(process)

    @staticmethod
    def end(process: subprocess.Popen) -> None:
        """Ends the process and what it has started."""
        try:
            os.killpg(process.pid, signal.SIGKILL)
        except ProcessLookupError:
            pass
        process.wait()

    def stop(self) -> None:
        """Ends what runs, and lets nothing more start."""
        with self.lock:
            self.stopped = True
            running = list(self.running)
        for process in running:
            self.end(process)
