"""Makes one call of the system after another fail under the built program, and checks what the program says and leaves.

usage: failing_calls_test.py METABUFFER LIBRARY [--calls N]

For each command and each function of the system: counts the calls of a run, then lets the first, the second, ... fail,
each in its own run. With --calls at most N of each, spread over all. Whatever fails, the program ends by itself with a
documented status, and reports a failure in one line. A run that reports success has left what it leaves otherwise.
After a run that reports a failure, the earlier results are there as they were, or the new ones.
"""

import argparse
import os
import pathlib
import re
import shutil
import sqlite3
import struct
import subprocess
import sys
import tempfile

import small_machine

DONE, BAD_INPUT = 0, 2
LONGEST_LINE = 400
FUNCTIONS = ("write", "open", "close", "rename", "mkdir", "unlink", "fsync", "fork", "pipe2", "mmap", "read", "socketpair",
             "sendmsg")
SCENARIO = small_machine.SCENARIO + "frames: 2\n"
EARLIER = SCENARIO.replace("frames: 2", "frames: 3")
SIZE = ["size", "scenario.yaml", "--minimize", "composer.buffer_pixels=1..8", "--over", "bus.width_bits=64,128",
        "--processes", "1", "--quiet", "--time-limit", "20"]
COMMANDS = {
    "run": ["run", "scenario.yaml", "--out", "out", "--quiet"],
    "waveform": ["run", "scenario.yaml", "--out", "out", "--quiet", "--trace", "t.vcd", "--trace-window", "startframe:0"],
    "schedule": ["run", "scenario.yaml", "--out", "out", "--quiet", "--trace", "t.json"],
    "check": ["run", "scenario.yaml", "--out", "out", "--quiet", "--check"],
    "view": ["view", "scenario.yaml", "-o", "t.html", "--quiet"],
    "compare": ["compare", "scenario.yaml"],
    "size": [*SIZE, "--out", "r.db"],
    "export": ["export", "good.db", "-o", "t.csv"],
    "merge": ["merge", "good.db", "-o", "t.db"],
    "report": ["report", "good.db", "-o", "t.html"],
    "plot": ["plot", "good.db", "--x", "smallest", "--y", "runs", "-o", "t.svg"],
}


def without_seconds(output):
    """The output without the times, which differ in each run."""
    return re.sub(rb"[0-9.]+", b"#", output)


def rows_of(database):
    """The points of a file of results; None if there is no file, or nothing in it yet."""
    if not database.exists() or database.stat().st_size == 0:
        return None
    connection = sqlite3.connect(database)
    try:
        # A file whose creation was cut short has no tables yet.
        if connection.execute("SELECT count(*) FROM sqlite_master").fetchone()[0] == 0:
            return None
        assert connection.execute("PRAGMA integrity_check").fetchone()[0] == "ok"
        return set(connection.execute("SELECT settings, status, smallest FROM points"))
    finally:
        connection.close()


class Bench:
    def __init__(self, program, library, place):
        self.program = program
        self.library = library
        self.place = place
        self.complaints = []
        self.earlier = place / "earlier"
        self.earlier.mkdir()
        small_machine.fill(self.earlier, EARLIER)
        for words in (COMMANDS["run"], [*SIZE, "--out", "good.db"]):
            assert self.run(self.earlier, words).returncode == DONE
        for name, text in (("t.vcd", "old"), ("t.json", "old"), ("t.csv", "old"), ("t.html", "old"), ("t.svg", "old")):
            (self.earlier / name).write_text(text)
        (self.earlier / "scenario.yaml").write_text(SCENARIO)

    def run(self, folder, words, function=None, at=0):
        environment = dict(os.environ, TMPDIR=str(folder))
        count = self.place / "count"
        if function is not None:
            count.write_bytes(bytes(8))
            environment.update(LD_PRELOAD=str(self.library), FAILING_CALL=function, FAILING_AT=str(at),
                               FAILING_COUNT=str(count))
        done = subprocess.run([self.program, *words], cwd=folder, env=environment, stdin=subprocess.DEVNULL,
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE, timeout=120, check=False)
        done.calls = struct.unpack("q", count.read_bytes())[0] if function is not None else 0
        return done

    def fresh(self):
        folder = self.place / "work"
        shutil.rmtree(folder, ignore_errors=True)
        shutil.copytree(self.earlier, folder)
        return folder

    @staticmethod
    def files_of(folder):
        """The content of the files that matter, by name. Files with temporary names may be left by a run that was cut
        short."""
        files = {}
        for path in sorted(folder.rglob("*")):
            name = str(path.relative_to(folder))
            if path.is_file() and ".metabuffer-" not in name and not name.startswith("r.db") and name != "t.vcd":
                files[name] = path.read_bytes()
        # The stock writer puts the date into a waveform.
        waveform = folder / "t.vcd"
        files["t.vcd"] = b"\n".join(line for line in waveform.read_bytes().split(b"\n") if not line.startswith(b"     "))
        return files

    def complain(self, where, what):
        self.complaints.append(f"{where}: {what}")
        print(f"{where}: {what}", flush=True)

    def try_command(self, name, words, most):
        folder = self.fresh()
        before = self.files_of(folder)
        good = self.run(folder, words)
        assert good.returncode == DONE, good.stderr
        after = self.files_of(folder)
        rows = rows_of(folder / "r.db")
        tried = 0
        for function in FUNCTIONS:
            calls = self.run(self.fresh(), words, function).calls
            chosen = range(1, calls + 1)
            if most and calls > most:
                chosen = sorted({1 + (calls - 1) * n // (most - 1) for n in range(most)})
            for at in chosen:
                self.judge(f"{name}, {function} {at} of {calls}", words, (function, at), (before, after, rows, good.stdout))
                tried += 1
        return tried

    def judge(self, where, words, call, expected):
        before, after, rows, output = expected
        folder = self.fresh()
        try:
            done = self.run(folder, words, *call)
        except subprocess.TimeoutExpired:
            self.complain(where, "does not end")
            return
        text = done.stderr.decode(errors="replace")
        if done.returncode not in (DONE, 1, BAD_INPUT):
            self.complain(where, f"status {done.returncode}: {text[:500]}")
        left = self.files_of(folder)
        if call[0] == "unlink":
            # A lock file that could not be deleted holds nothing: the lock itself ended with the process.
            left = {name: content for name, content in left.items() if not name.endswith(".lock")}
        if done.returncode == DONE:
            if left != after:
                changed = {name for name, content in left.items() if after.get(name) != content}
                changed |= after.keys() - left.keys()
                self.complain(where, f"done, with other results: {', '.join(sorted(changed))}")
            if without_seconds(done.stdout) != without_seconds(output):
                self.complain(where, "done, with other output")
            if rows_of(folder / "r.db") != rows:
                self.complain(where, "done, with other points")
            return
        if text.count("\n") != 1 or len(text) > LONGEST_LINE + 1:
            self.complain(where, f"status {done.returncode}, not one line: {text[:500]!r}")
        if "at fault" in text:
            self.complain(where, f"status {done.returncode}: {text[:300]}")
        if left not in (before, after):
            # The trace has its final name before the results have theirs.
            only_trace = {**before, **{name: after[name] for name in ("t.vcd", "t.json")}}
            if left != only_trace and not (left.keys() <= before.keys() | after.keys() and
                                           "out/report.json" not in left):
                names = {name for name in left.keys() | before.keys() if left.get(name) != before.get(name)}
                self.complain(where, f"status {done.returncode}, but changed: {', '.join(sorted(names))}")
        held = rows_of(folder / "r.db")
        if held is not None and rows is not None and not held <= rows:
            self.complain(where, f"wrong points: {held - rows}")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("library", type=pathlib.Path)
    parser.add_argument("--calls", type=int, default=0)
    parser.add_argument("--commands", default=",".join(COMMANDS))
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        bench = Bench(options.program.resolve(), options.library.resolve(), pathlib.Path(scratch).resolve())
        for name in options.commands.split(","):
            tried = bench.try_command(name, COMMANDS[name], options.calls)
            print(f"{name}: {tried} calls failed", flush=True)
    return 1 if bench.complaints else 0


if __name__ == "__main__":
    sys.exit(main())
