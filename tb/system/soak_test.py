"""Tests scripts/soak: with a stand-in for soak_machines that misbehaves on request, and with the real one.

usage: soak_test.py SCRIPT SOAK_MACHINES FAULTY_SOAK_MACHINES METABUFFER
"""

import pathlib
import subprocess
import sys
import tempfile
import unittest

SCRIPT, SOAK_MACHINES, FAULTY, METABUFFER = sys.argv[1:5]

# Seeds do what their lists say; the rest is identical.
STAND_IN = r"""#!/usr/bin/env python3
import os, pathlib, sys, time
if sys.argv[1] == "--write":
    pathlib.Path(sys.argv[3]).mkdir(parents=True, exist_ok=True)
    (pathlib.Path(sys.argv[3]) / "scenario.yaml").write_text("seed " + sys.argv[2])
    sys.exit(0)
if sys.argv[1] == "--shrink":
    with open(HERE / "calls-to-shrink", "a") as calls:
        calls.write(" ".join(sys.argv[2:]) + "\n")
    pathlib.Path(sys.argv[3]).mkdir(parents=True)
    (pathlib.Path(sys.argv[3]) / "scenario.yaml").write_text("small " + sys.argv[2])
    print("before: huge\nafter:  tiny")
    sys.exit(5)
if sys.argv[1] in ("--plain", "--stalled"):
    with open(HERE / "machines", "a") as calls:
        calls.write(sys.argv[1])
    del sys.argv[1]
first, count = int(sys.argv[1]), int(sys.argv[2])
seeds = range(first, first + count)
with open(HERE / "calls", "a") as calls:
    calls.write(f"{first} {count}\n")
if any(seed in CRASHING for seed in seeds):
    os.abort()
if any(seed in HANGING for seed in seeds):
    time.sleep(60)
if any(seed in FAILING for seed in seeds):
    sys.exit("the model is at fault")
if count > 1 and any(seed in SIDE_BY_SIDE for seed in seeds):
    os.abort()
for seed in seeds:
    if seed in SILENT:
        continue
    print("seed", seed, "different" if seed in DIFFERENT else
          "violation bus/busready" if seed in VIOLATING else "identical")
    if seed in VIOLATING:
        print("  BUS_1, core clock 7")
    if seed in DIFFERENT:
        print("  core_cycles: rtl 1, tlm 2")
        print("  watchdog[0]: rtl none, tlm \"x\"")
sys.exit(5 if any(seed in DIFFERENT + VIOLATING for seed in seeds) else 0)
"""


class Soak(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.directory = pathlib.Path(scratch.name)
        self.program = self.directory / "stand-in"

    def soak(self, *arguments, program=None, **seeds):
        """Runs the script; seeds are lists by what their machines do."""
        lists = {"CRASHING": (), "HANGING": (), "FAILING": (), "SIDE_BY_SIDE": (), "SILENT": (), "DIFFERENT": (),
                 "VIOLATING": ()}
        lists.update({name.upper(): tuple(values) for name, values in seeds.items()})
        settings = "".join(f"{name} = {values!r}\n" for name, values in lists.items())
        head, body = STAND_IN.split("\n", 1)
        self.program.write_text(f"{head}\nimport pathlib\nHERE = pathlib.Path({str(self.directory)!r})\n"
                                f"{settings}{body}")
        self.program.chmod(0o755)
        return subprocess.run(
            [sys.executable, SCRIPT, *map(str, arguments), "--program", program or self.program],
            cwd=self.directory, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
            text=True, timeout=300, check=False)

    def kept(self, directory="soak-failures"):
        place = self.directory / directory
        return sorted(entry.name for entry in place.iterdir()) if place.exists() else []

    def failure(self, name, directory="soak-failures"):
        return (self.directory / directory / name / "failure.txt").read_text()

    def calls(self):
        return sorted(tuple(map(int, line.split())) for line in (self.directory / "calls").read_text().splitlines())

    def test_identical_machines_leave_nothing(self):
        done = self.soak(20, 100)
        self.assertEqual(done.returncode, 0, done.stdout)
        self.assertIn("seeds 100 to 119", done.stdout)
        self.assertIn("20 machines, 0 failed", done.stdout)
        self.assertEqual(self.kept(), [])
        self.assertEqual(self.calls(), [(100, 8), (108, 8), (116, 4)])

    def test_seed_is_random_and_printed_if_none_is_given(self):
        lines = {self.soak(1).stdout.splitlines()[0] for _ in range(2)}
        self.assertEqual(len(lines), 2)

    def test_difference_is_kept_with_its_scenario(self):
        done = self.soak(20, 1, different=[3, 17])
        self.assertEqual(done.returncode, 1, done.stdout)
        self.assertIn("20 machines, 2 failed, 2 different", done.stdout)
        self.assertIn("seed-17: different: core_cycles: rtl 1, tlm 2; kept in soak-failures/seed-17", done.stdout)
        self.assertEqual(self.kept(), ["seed-17", "seed-3"])
        self.assertEqual((self.directory / "soak-failures/seed-3/scenario.yaml").read_text(), "seed 3")
        self.assertIn("different\ncore_cycles: rtl 1, tlm 2\nwatchdog[0]: rtl none", self.failure("seed-3"))
        self.assertEqual(self.calls(), [(1, 8), (9, 8), (17, 4)])  # nothing again

    def test_violation_is_kept_by_its_rule(self):
        done = self.soak(4, 1, violating=[2])
        self.assertEqual(done.returncode, 1, done.stdout)
        self.assertIn("seed-2: violation bus/busready: BUS_1, core clock 7; kept", done.stdout)
        self.assertIn("4 machines, 1 failed, 1 violation bus/busready", done.stdout)
        self.assertTrue(self.failure("seed-2").startswith("violation bus/busready\nBUS_1"))

    def test_failures_are_shrunk_unless_that_is_not_wanted(self):
        done = self.soak(4, 1, "--shrink-runs", 50, different=[3])
        self.assertEqual(done.returncode, 1, done.stdout)
        self.assertEqual((self.directory / "soak-failures/seed-3/shrunk/scenario.yaml").read_text(), "small 3")
        self.assertIn("after:  tiny", self.failure("seed-3"))
        self.assertEqual((self.directory / "calls-to-shrink").read_text(),
                         "3 soak-failures/seed-3/shrunk 50 30\n")
        done = self.soak(4, 1, "--no-shrink", "--out", "plainly", different=[3])
        self.assertEqual(done.returncode, 1, done.stdout)
        self.assertFalse((self.directory / "plainly/seed-3/shrunk").exists())
        self.assertNotIn("tiny", self.failure("seed-3", "plainly"))

    def test_other_kinds_of_machines(self):
        for kind in ("--plain", "--stalled"):
            (self.directory / "machines").unlink(missing_ok=True)
            done = self.soak(4, 1, kind)
            self.assertEqual(done.returncode, 0, done.stdout)
            self.assertEqual((self.directory / "machines").read_text(), kind)

    def test_crash_hang_and_error_are_put_down_to_their_seeds(self):
        done = self.soak(16, 1, "--timeout", 4, "--batch", 4, "--out", "elsewhere", crashing=[2], hanging=[7],
                         failing=[12])
        self.assertEqual(done.returncode, 1, done.stdout)
        self.assertIn("16 machines, 3 failed, 1 crash, 1 error, 1 timeout", done.stdout)
        self.assertEqual(self.kept("elsewhere"), ["seed-12", "seed-2", "seed-7"])
        self.assertIn("SIGABRT", self.failure("seed-2", "elsewhere"))
        self.assertIn("Still running after 4 s", self.failure("seed-7", "elsewhere"))
        self.assertIn("the model is at fault", self.failure("seed-12", "elsewhere"))
        self.assertEqual((self.directory / "elsewhere/seed-7/scenario.yaml").read_text(), "seed 7")
        self.assertIn((13, 4), self.calls())
        self.assertNotIn((13, 1), self.calls())

    def test_batch_that_fails_only_together_is_kept_as_one(self):
        done = self.soak(4, 1, "--batch", 2, side_by_side=[3])
        self.assertEqual(done.returncode, 1, done.stdout)
        self.assertIn("4 machines, 2 failed, 1 crash", done.stdout)
        self.assertEqual(self.kept(), ["seeds-3-to-4"])
        self.assertIn("soak_machines 3 2", self.failure("seeds-3-to-4"))
        self.assertEqual((self.directory / "soak-failures/seeds-3-to-4/seed-4/scenario.yaml").read_text(), "seed 4")

    def test_seed_that_is_not_reported_has_failed(self):
        done = self.soak(4, 1, silent=[4])
        self.assertEqual(done.returncode, 1, done.stdout)
        self.assertEqual(self.kept(), ["seed-4"])
        self.assertIn("Not every seed", self.failure("seed-4"))

    def test_bad_arguments_are_refused(self):
        for arguments in [(), ("x",), (0,), (1, -1), (1, 1, "--jobs", 0), (1, 1, "--colour")]:
            done = self.soak(*arguments)
            self.assertEqual(done.returncode, 2, done.stdout)
        self.assertFalse((self.directory / "calls").exists())

    def test_real_machines(self):
        done = self.soak(6, 1, "--batch", 3, program=SOAK_MACHINES)
        self.assertEqual(done.returncode, 0, done.stdout)
        self.assertIn("6 machines, 0 failed", done.stdout)
        written = subprocess.run([SOAK_MACHINES, "--write", "5", self.directory / "five"], check=False)
        self.assertEqual(written.returncode, 0)
        self.assertTrue((self.directory / "five/scenario.yaml").is_file())
        for arguments in [(), ("1",), ("1", "x"), ("-1", "2"), ("--write", "1"), ("1", "2", "3"), ("--plain",), ("--stalled",),
                          ("--shrink", "1"), ("--shrink", "1", "there", "few"), ("--judge",)]:
            done = subprocess.run([SOAK_MACHINES, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                  text=True, check=False)
            self.assertEqual(done.returncode, 2)
            self.assertIn("usage", done.stderr)

    def test_machine_of_a_faulty_level_is_shrunk(self):
        done = self.soak(1, 1, program=FAULTY)
        self.assertEqual(done.returncode, 1, done.stdout)
        self.assertIn("seed-1: different", done.stdout)
        place = self.directory / "soak-failures/seed-1"
        small = place / "shrunk/scenario.yaml"
        # The fault shows in the second frame of any machine whose frames are read from the same page.
        self.assertIn("frames: 2\n", small.read_text())
        self.assertIn("columns: 1, rows: 1, width: 1, height: 1", small.read_text())
        story = (place / "shrunk/failure.txt").read_text()
        self.assertIn("seed 1 different, shrunk", story)
        self.assertIn("after:  1 renderers, 1 displays of 1x1, 2 frames, 1 table rows", story)
        self.assertIn("no smaller one fails", story)
        self.assertIn("The files fail in the same way", story)
        self.assertEqual(self.status(FAULTY, "--judge", small), 5)
        self.assertEqual(self.status(SOAK_MACHINES, "--judge", small), 0)  # the right level is at no fault
        self.assertEqual(self.status(METABUFFER, "compare", small), 0)
        self.assertEqual(self.status(FAULTY, "--shrink", 2, self.directory / "nothing"), 0)  # does not fail
        cut_short = self.directory / "cut-short"
        self.assertEqual(self.status(FAULTY, "--shrink", 1, cut_short, 3), 5)
        self.assertIn("smaller ones have not all been tried", (cut_short / "failure.txt").read_text())

    def status(self, *words):
        done = subprocess.run(list(map(str, words)), cwd=self.directory, stdin=subprocess.DEVNULL,
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, timeout=300, check=False)
        return done.returncode


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[5:])
