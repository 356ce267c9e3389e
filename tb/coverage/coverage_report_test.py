"""Tests the tool coverage_report from outside: exit status and what it leaves.

usage: coverage_report_test.py COVERAGE_REPORT
"""

import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

TOOL = sys.argv[1]
DONE, BAD_INPUT, BELOW = 0, 2, 3


class CoverageReport(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.directory = pathlib.Path(scratch.name)
        self.counts = self.directory / "counts"
        self.counts.mkdir()
        (self.counts / "1.coverage").write_text("test one\n2 bus/burst: whole\nend\n")

    def report(self, threshold, *options):
        (self.directory / "threshold").write_text(f"{threshold}\n")
        return subprocess.run([TOOL, self.counts, "--threshold", self.directory / "threshold", *options],
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, check=False)

    def test_threshold_decides(self):
        self.assertEqual(self.report(0.01).returncode, DONE)
        below = self.report(50)
        self.assertEqual(below.returncode, BELOW)
        self.assertIn("HOLE", below.stdout)
        self.assertIn("threshold 50.0 %", below.stdout)

    def test_every_goal_reached_is_a_hundred_percent(self):
        self.report(0, "--json", self.directory / "report.json")
        report = json.loads((self.directory / "report.json").read_text())
        lines = [f"1 {group['name']}: {goal['name']}" for group in report["groups"] for goal in group["bins"]]
        (self.counts / "2.coverage").write_text("\n".join(["test all", *lines, "end", ""]))
        done = self.report(100)
        self.assertEqual(done.returncode, DONE, done.stdout)
        self.assertNotIn("HOLE", done.stdout)
        lines.remove("1 bus/burst: of one beat")
        (self.counts / "2.coverage").write_text("\n".join(["test all", *lines, "end", ""]))
        done = self.report(100)
        self.assertEqual(done.returncode, BELOW)
        self.assertEqual(done.stdout.count("HOLE"), 1)
        self.assertIn("HOLE  of one beat", done.stdout)

    def test_files_are_left(self):
        self.report(0, "--text", self.directory / "report.txt", "--json", self.directory / "report.json")
        self.assertIn("whole: 2, first in one", (self.directory / "report.txt").read_text())

    def test_bad_input_is_reported_in_a_line(self):
        (self.counts / "2.coverage").write_text("test one\n2 bus/burst: whole\n")  # cut short
        done = self.report(0)
        self.assertEqual(done.returncode, BAD_INPUT)
        self.assertEqual(done.stderr.count("\n"), 1)
        self.assertIn("2.coverage:3", done.stderr)
        self.assertEqual(self.report("many").returncode, BAD_INPUT)
        self.assertEqual(self.report(0, "--colour").returncode, BAD_INPUT)
        self.assertEqual(subprocess.run([TOOL], capture_output=True, check=False).returncode, BAD_INPUT)
        self.assertEqual(subprocess.run([TOOL, "--help"], capture_output=True, check=False).returncode, DONE)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[2:])
