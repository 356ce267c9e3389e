"""Cuts the power during a sweep, many times. The disk keeps what it was told to sync, and of the rest what it likes.

usage: power_cut_test.py METABUFFER LIBRARY [--cuts N] [--seed S]

A sweep runs once, and the library records what it does to its file of results. Each cut takes the record up to some
point. What came before a file's last sync has happened. Of what came after it, each write may have happened, or only
some of its sectors. In the file that this leaves, the program must find points that are right, and no fewer than had
been synced, or say that it holds none. The sweep must go on from there to the same results.
"""

import argparse
import os
import pathlib
import random
import shutil
import subprocess
import sys
import tempfile

import small_machine

DONE = 0
SECTOR_BYTES = 512
SWEEP = """scenario: scenario.yaml
axes:
  - {key: memory.page_miss_cycles, range: {from: 0, to: 39}}
  - {key: bus.width_bits, values: [64, 128]}
"""
COLUMNS = "memory.page_miss_cycles, bus.width_bits, status, core_cycles"


def records_in(log):
    """Operation, size, position, data and name of each record."""
    content, at, records = log.read_bytes(), 0, []
    while at < len(content):
        end = content.index(b"\n", at)
        operation, size, position, length, path = content[at:end].decode().split(" ", 4)
        data = content[end + 1:end + 1 + int(length)]
        records.append((operation, int(size), int(position), data, pathlib.Path(path).name))
        at = end + 1 + int(length)
    return records


class Disk:
    """The files that have reached the disk, by name."""

    def __init__(self):
        self.files = {}

    def apply(self, record, sectors=lambda: True):
        operation, size, position, data, name = record
        if operation == "create":
            self.files[name] = bytearray()
        elif operation == "unlink":
            self.files.pop(name, None)
        elif operation == "rename":
            self.files[pathlib.Path(data.decode()).name] = self.files.pop(name)
        elif operation == "truncate" and name in self.files:
            content = self.files[name]
            del content[size:]
            content.extend(bytes(size - len(content)))
        elif operation == "write" and name in self.files:
            content = self.files[name]
            content.extend(bytes(max(0, position + len(data) - len(content))))
            for begin in range(0, len(data), SECTOR_BYTES):
                if sectors():
                    part = data[begin:begin + SECTOR_BYTES]
                    content[position + begin:position + begin + len(part)] = part


def disk_after_cut(records, cut, arrives):
    """The disk if the power is cut after that many records. What was synced is there. For each other write, arrives()
    says whether it is there; what it returns says for each sector whether that is there."""
    last_sync = {}
    for number, (operation, *_, name) in enumerate(records[:cut]):
        if operation == "sync":
            last_sync[name] = number
    disk = Disk()
    for number, record in enumerate(records[:cut]):
        name, operation = record[-1], record[0]
        # Every file system with a journal keeps the order of changes to names.
        if number <= last_sync.get(name, -1) or operation in ("create", "unlink", "rename"):
            disk.apply(record)
        elif sectors := arrives():
            disk.apply(record, sectors)
    return disk


def as_it_likes(values):
    """What a disk may do with writes that were not synced."""
    share = values.choice((0.0, 0.2, 0.5, 0.9, 1.0))  # of the writes that arrive all the same
    torn = values.random() < 0.5

    def sectors():
        return values.random() < 0.7 or not torn

    return lambda: sectors if values.random() < share else None


def not_at_all():
    return None


class Bench:
    def __init__(self, program, library, place):
        self.program, self.library, self.place = program, library, place
        self.folder = place / "work"
        self.folder.mkdir()
        small_machine.fill(self.folder)
        (self.folder / "sweep.yaml").write_text(SWEEP)

    def run(self, *words, **environment):
        return subprocess.run([self.program, *words], cwd=self.folder, env=dict(os.environ, **environment),
                              stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                              timeout=120, check=False)

    def sweep(self, **environment):
        done = self.run("sweep", "sweep.yaml", "-o", "r.db", "--processes", "2", "--quiet", **environment)
        assert done.returncode == DONE, done.stderr

    def points(self):
        """The lines of the results; none if the program says that there are none."""
        done = self.run("export", "r.db", "--columns", COLUMNS)
        if done.returncode != DONE:
            assert done.returncode == 2 and ("holds no results" in done.stderr or "no such file" in done.stderr), done
            return set()
        return set(done.stdout.splitlines()[1:])

    def put(self, disk):
        for path in self.folder.glob("r.db*"):
            path.unlink()
        for name, content in disk.files.items():
            if not name.endswith(("-shm", ".lock")):  # shared memory, and the lock of an ended process
                (self.folder / name).write_bytes(content)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("library", type=pathlib.Path)
    parser.add_argument("--cuts", type=int, default=40, help="anywhere; half as many again are at syncs")
    parser.add_argument("--seed", type=int, default=random.randrange(1 << 32))
    options = parser.parse_args()
    print(f"--seed {options.seed}", flush=True)
    values = random.Random(options.seed)
    with tempfile.TemporaryDirectory() as scratch:
        bench = Bench(options.program.resolve(), options.library.resolve(), pathlib.Path(scratch))
        log = bench.place / "log"
        bench.sweep(LD_PRELOAD=str(bench.library), RECORDED_PREFIX="r.db", RECORDED_LOG=str(log))
        everything = bench.points()
        assert len(everything) == 80
        records = records_in(log)
        syncs = [number for number, record in enumerate(records) if record[0] == "sync"]
        assert syncs, "nothing was ever synced"
        shutil.copy(bench.folder / "r.db", bench.place / "whole.db")
        kept = []
        # Syncs are where most is at stake.
        cuts = {near + 1 for near in values.sample(syncs, min(options.cuts // 2, len(syncs)))}
        cuts |= set(values.sample(range(len(records) + 1), min(options.cuts, len(records) + 1)))
        for cut in sorted(cuts):
            bench.put(disk_after_cut(records, cut, as_it_likes(values)))
            found = bench.points()
            assert found <= everything, f"cut at {cut}: wrong points {found - everything}"
            # What a disk with just the synced writes holds is there after any other cut at that point, too.
            bench.put(disk_after_cut(records, cut, not_at_all))
            synced = bench.points()
            assert synced <= found, f"cut at {cut}: lost points that had been synced {synced - found}"
            kept.append((cut, len(synced), len(found)))
            bench.put(disk_after_cut(records, cut, as_it_likes(values)))
            bench.sweep()
            assert bench.points() == everything, f"cut at {cut}: the sweep went on to other results"
        print(f"{len(records)} records, {len(syncs)} syncs; cut after, points synced, points found: {kept}")


if __name__ == "__main__":
    sys.exit(main())
