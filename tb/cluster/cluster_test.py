#!/usr/bin/env python3
"""Compares a sweep by the scheduler Slurm, started for the test on this machine, with the same sweep in one run.

usage: tb/cluster/cluster_test.py [--node-dies] [--points COUNT] PROGRAM

Submits a sweep as an array of shards to two nodes, kills one of its jobs, stops the command, starts it again, and
compares the export of the merged results, byte by byte, with that of an undisturbed sweep. With --node-dies one node's
daemon is killed, too. Its job lives on while Slurm starts it again elsewhere, so both write; that takes some minutes.
At the end nothing of Slurm is left running.
"""

import argparse
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
import time

sys.dont_write_bytecode = True
from slurm_machine import SlurmMachine  # noqa: E402

SHARDS = 4
# A point takes some milliseconds, so that a shard hands in several times before it ends, and can be interrupted.
WIDTH, HEIGHT = 320, 240
SCENARIO = f"""
displays: {{width: {WIDTH}, height: {HEIGHT}}}
composer: {{ready_space_pixels: 2}}
bus: {{burst_pixels: 2}}
renderers:
  - frames: [{{image: view.ppm, z: 0, viewport: {{x: 0, y: 0}}}}]
"""
# The last width is not legal: points without a valid scenario have their reasons.
SWEEP = """
scenario: scenario.yaml
axes:
  - {key: bus.width_bits, values: [16, 32, 64, 48]}
  - {key: composer.buffer_pixels, range: {from: 64, to: %d, step: 1}}
"""
TIMEOUT_SECONDS = 600


class Failure(Exception):
    pass


def expect(condition, what):
    if not condition:
        raise Failure(what)


class Cluster:
    def __init__(self, program, folder, slurm, points):
        self.program = program
        self.folder = folder
        self.slurm = slurm
        self.points = points

    def command(self, *arguments):
        return [str(self.program), *map(str, arguments)]

    def run(self, *arguments, status=0):
        """Runs a command of the program; returns what it prints."""
        done = subprocess.run(self.command(*arguments), cwd=self.folder, env=self.slurm.environment,
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, check=False,
                              timeout=TIMEOUT_SECONDS)
        expect(done.returncode == status,
               f"{' '.join(map(str, arguments))}: status {done.returncode} instead of {status}: {done.stdout}{done.stderr}")
        return done.stdout + done.stderr

    def start(self, *arguments):
        return subprocess.Popen(self.command(*arguments), cwd=self.folder, env=self.slurm.environment,
                                stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)

    def export(self, name):
        self.run("export", f"{name}.db", "-o", f"{name}.csv")
        return (self.folder / f"{name}.csv").read_bytes()

    def parts(self):
        return sorted((self.folder / "all.db.parts").glob("*.db"))

    def wait_until(self, condition, what, process=None):
        """Waits until the condition holds, and returns its value."""
        deadline = time.monotonic() + TIMEOUT_SECONDS
        while not (value := condition()):
            expect(time.monotonic() < deadline, f"{what}: not after {TIMEOUT_SECONDS} s")
            if process is not None and process.poll() is not None:
                raise Failure(f"{what}: the sweep has ended before: {process.stdout.read()}")
            time.sleep(0.1)
        return value

    def jobs(self, state="RUNNING"):
        """The jobs of the array in that state, and their nodes."""
        lines = self.slurm.run("squeue", "--me", "--noheader", "--array", "--name=metabuffer-sweep",
                               f"--states={state}", "--format=%i %N").splitlines()
        return [line.split() for line in lines]

    def sweep_arguments(self):
        return ["sweep", "sweep.yaml", "--slurm", SHARDS, "-o", "all.db", "--hand-in", 1]


def check_interrupted(cluster, node_dies):
    """Killed, stopped and started again."""
    process = cluster.start(*cluster.sweep_arguments())
    cluster.wait_until(lambda: len(cluster.parts()) >= 2, "the first parts", process)
    job = cluster.wait_until(cluster.jobs, "a job at work", process)[0][0]
    # As the system does when memory runs out, or an administrator.
    cluster.slurm.run("scancel", "--signal=KILL", "--full", job)
    if node_dies:
        node = cluster.wait_until(cluster.jobs, "a job at work", process)[-1][1]
        cluster.slurm.kill_node(node)
        cluster.wait_until(lambda: not cluster.jobs() or all(each[1] != node for each in cluster.jobs()),
                           "the job of the dead node is taken from it", process)
        cluster.slurm.start_node(node)
    else:
        before = len(cluster.parts())
        cluster.wait_until(lambda: len(cluster.parts()) > before, "another part", process)
    process.send_signal(signal.SIGINT)
    said = process.communicate(timeout=60)[0]
    expect(process.returncode == 130, f"stopped: status {process.returncode}: {said}")
    expect("goes on from here" in said, f"stopped: {said}")
    cluster.wait_until(lambda: not cluster.slurm.run("squeue", "--me", "--noheader").strip(), "no job is left")
    # The parts so far can be merged, and the merge says that points are missing.
    said = cluster.run("merge", "all.db.parts", "-o", "some.db", status=6)
    expect("missing: " in said, said)
    return int(re.search(r"(\d+) points?,", said).group(1))


def check_goes_on(cluster, ended, expected):
    """Started again: nothing that has ended is run again."""
    # Submitted by one command, waited for by another.
    said = cluster.run(*cluster.sweep_arguments(), "--no-wait")
    expect("submitted " in said, said)
    said = cluster.run(*cluster.sweep_arguments())
    expect("are at work already" in said, said)
    ran = 0
    for log in (cluster.folder / "all.db.parts").glob("shard-*.log"):
        # The last run of each shard.
        counts = re.findall(r"(\d+) simulations(?:; (\d+) points were there already)?", log.read_text())
        expect(counts, f"{log.name} has no line of what was run")
        ran += int(counts[-1][0])
    expect(ran <= cluster.points, f"{ran} simulations for {cluster.points} points")
    expect(ended + ran >= cluster.points, f"{ended} points were there and {ran} were run of {cluster.points}")
    expect(cluster.export("all") == expected, "the merged results are not those of the undisturbed sweep")
    # Merging and sweeping again change nothing.
    said = cluster.run("merge", "all.db.parts", "all.db", "-o", "all.db")
    expect(f"{cluster.points} points, 0 of them new" in said, said)
    expect(cluster.export("all") == expected, "merging again changes the results")
    said = cluster.run(*cluster.sweep_arguments())
    # Points without a valid scenario are tried again, as in any sweep; there is nothing else to do.
    expect(f"{cluster.points} points, 0 of them new" in said, said)
    for log in (cluster.folder / "all.db.parts").glob("shard-*.log"):
        again = int(re.findall(r"(\d+) simulations", log.read_text())[-1])
        expect(again == cluster.points // 4 // SHARDS, f"{log.name}: {again} simulations more")


def check_site_options(cluster):
    """An option that Slurm refuses is reported in one line."""
    said = cluster.run("sweep", "sweep.yaml", "--slurm", 2, "-o", "other.db", "--sbatch=--partition=nowhere", status=2)
    expect("partition" in said and len(said.splitlines()) == 1, said)


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter,
                                     usage="tb/cluster/cluster_test.py [--node-dies] [--points COUNT] PROGRAM")
    parser.add_argument("program", type=lambda text: pathlib.Path(text).resolve())
    parser.add_argument("--points", type=int, default=2000)
    parser.add_argument("--node-dies", action="store_true")
    return parser.parse_args()


def main():
    arguments = parse_arguments()
    with tempfile.TemporaryDirectory(prefix="metabuffer-cluster-") as name:
        folder = pathlib.Path(name)
        work = folder / "work"
        work.mkdir()
        (work / "scenario.yaml").write_text(SCENARIO)
        (work / "view.ppm").write_bytes(b"P6\n%d %d\n255\n" % (WIDTH, HEIGHT) + bytes(3 * WIDTH * HEIGHT))
        (work / "sweep.yaml").write_text(SWEEP % (64 + arguments.points // 4 - 1))
        (folder / "slurm").mkdir()
        slurm = SlurmMachine(folder / "slurm")
        try:
            with slurm:
                cluster = Cluster(arguments.program, work, slurm, arguments.points)
                cluster.run("sweep", "sweep.yaml", "-o", "whole.db", "--quiet")
                expected = cluster.export("whole")
                check_site_options(cluster)
                ended = check_interrupted(cluster, arguments.node_dies)
                print(f"{ended} of {arguments.points} points when it was stopped")
                check_goes_on(cluster, ended, expected)
            deadline = time.monotonic() + 10
            while slurm.leftovers() and time.monotonic() < deadline:
                time.sleep(0.1)
            expect(not slurm.leftovers(), f"processes are left: {slurm.leftovers()}")
        except (Failure, RuntimeError) as failure:
            print(f"cluster_test: {failure}", file=sys.stderr)
            for log in sorted((work / "all.db.parts").glob("*.log")) + sorted(slurm.folder.glob("*.log")):
                print(f"-- {log.name}\n{log.read_text()[-2000:]}", file=sys.stderr)
            return 1
    print("the sweep by Slurm is that of one go")
    return 0


if __name__ == "__main__":
    sys.exit(main())
