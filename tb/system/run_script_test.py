"""Tests scripts/run with the built program, in a project of two small scenarios that needs no building, and what
scripts/test does with its steps.

usage: run_script_test.py SCRIPTS METABUFFER
"""

import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

SCRIPTS, METABUFFER = map(pathlib.Path, sys.argv[1:3])
DONE, BAD_INPUT = 0, 2

SCENARIO = """displays: {width: 12, height: 4}
composer: {ready_space_pixels: 2}
bus: {burst_pixels: 2}
renderers:
  - frames: [{image: view.ppm, z: 0, viewport: {x: 0, y: 0}}]
"""
# What to give each option that takes a value. One that is not here fails the test of all options.
VALUES = {"--set": "bus.width_bits=64", "--frames": "1", "--level": "rtl", "--out": "elsewhere", "--trace": "mine.vcd",
          "--pictures": "none", "--trace-window": "all", "--trace-before": "5", "--trace-after": "5", "--trace-modules": "composer_*"}


def options_of_run():
    """Those that the program's help lists, and whether each takes a value."""
    text = subprocess.run([METABUFFER, "run", "--help"], stdout=subprocess.PIPE, text=True, check=True).stdout
    return {match[1]: match[2] is not None
            for match in re.finditer(r"^  (?:-\w,)?(--[\w-]+)( [A-Z]+\b)?", text, re.MULTILINE)}


class Project(unittest.TestCase):
    """A project with stand-ins for what installs and builds."""

    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.project = pathlib.Path(scratch.name).resolve() / "project"
        for name in ("paper-figure", "foveated"):
            self.write(f"scenarios/{name}.yaml", SCENARIO)
        (self.project / "scenarios/view.ppm").write_bytes(b"P6\n12 4\n255\n" + bytes(144))
        self.write("waves/metabuffer.gtkw", '[dumpfile] "(null)"\n[timestart] 0\n')
        self.write("build/release/build.ninja", "")  # nothing is to be configured
        (self.project / "build/release/metabuffer").symlink_to(METABUFFER.resolve())
        for name in ("scripts/install-packages", "bin/cmake", "bin/git", "bin/clang-format-14"):
            self.stand_in(name, "exit 0")
        for name in ("run", "test", "common.bash"):
            shutil.copy(SCRIPTS / name, self.project / "scripts" / name)

    def write(self, name, text):
        path = self.project / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
        return path

    def stand_in(self, name, commands):
        self.write(name, f"#!/bin/sh\n{commands}\n").chmod(0o755)

    def run_script(self, *words, script="run", directory="."):
        environment = dict(os.environ, PATH=f"{self.project / 'bin'}:{os.environ['PATH']}")
        return subprocess.run([self.project / "scripts" / script, *words], cwd=self.project / directory, env=environment,
                              stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                              timeout=100, check=False)


class Run(Project):
    def check_ran(self, done, name, results):
        self.assertEqual(done.returncode, DONE, done.stderr)
        report = json.loads((self.project / results / "report.json").read_text())
        self.assertEqual(report["scenario"], name)

    def test_a_run_with_pictures_leaves_a_page_and_one_without_leaves_none(self):
        page = self.project / "out/foveated/run.html"
        done = self.run_script("scenarios/foveated.yaml")
        self.assertIn(b"</html>", page.read_bytes())
        self.assertIn("out/foveated/run.html, in a browser", done.stdout)
        self.run_script("scenarios/foveated.yaml", "--no-images")
        self.assertFalse(page.exists())

    def test_a_fault_inside_the_machine_makes_no_page_and_a_line_says_why(self):
        self.write("scenarios/foveated.yaml", SCENARIO + "faults: [{kind: reset, from_cycle: 100, cycles: 9}]\n")
        done = self.run_script("scenarios/foveated.yaml", "--level", "rtl")
        self.assertEqual((done.returncode, done.stderr), (DONE, ""))
        self.assertRegex(done.stdout, r"no out/foveated/run\.html: .*reset")
        self.assertFalse((self.project / "out/foveated/run.html").exists())

    def test_every_option_of_the_program_works_before_and_behind_the_scenario(self):
        options = options_of_run()
        self.assertGreaterEqual(set(options), {*VALUES, "--check", "--strict", "--quiet", "--no-images"})
        del options["--help"]
        every, joined = [], []
        for option, takes_value in options.items():
            words = [option, VALUES[option]] if takes_value else [option]
            every += words
            joined.append("=".join(words))
            results = VALUES["--out"] if option == "--out" else "out/foveated"
            with self.subTest(words=words):
                shutil.rmtree(self.project / results, ignore_errors=True)
                self.check_ran(self.run_script(*words, "scenarios/foveated.yaml"), "foveated", results)
                self.assertFalse((self.project / "out/paper-figure").exists())
        for line, name in ((["scenarios/foveated.yaml", *every], "foveated"), (every, "paper-figure"),
                           ([*joined, "scenarios/foveated.yaml"], "foveated")):
            shutil.rmtree(self.project / VALUES["--out"])
            self.check_ran(self.run_script(*line), name, VALUES["--out"])

    def test_results_waveform_and_its_view_are_named_after_the_scenario(self):
        done = self.run_script()
        self.check_ran(done, "paper-figure", "out/paper-figure")
        names = {path.name for path in (self.project / "out/paper-figure").iterdir()}
        self.assertGreaterEqual(names, {"display_1.png", "collage.png", "report.json", "trace.vcd", "trace.gtkw"})
        view = (self.project / "out/paper-figure/trace.gtkw").read_text()
        self.assertTrue(view.startswith(f'[dumpfile] "{self.project}/out/paper-figure/trace.vcd"\n'), view)
        self.assertIn("[timestart] 0\n", view)
        self.assertNotIn("(null)", view)
        self.assertIn("to see it:  gtkwave out/paper-figure/trace.vcd out/paper-figure/trace.gtkw", done.stdout)
        self.assertEqual(self.run_script("--quiet").stdout, "")

    def test_results_lie_in_the_project_wherever_the_script_is_called(self):
        self.check_ran(self.run_script(directory="scenarios"), "paper-figure", "out/paper-figure")
        self.check_ran(self.run_script("foveated.yaml", "--no-images", directory="scenarios"), "foveated",
                       "out/foveated")

    def test_only_a_waveform_that_is_not_asked_for_is_added(self):
        self.assertEqual(self.run_script("--trace", "mine.vcd").returncode, DONE)
        self.assertTrue((self.project / "mine.vcd").exists())
        self.assertFalse((self.project / "out/paper-figure/trace.vcd").exists())
        for level in ("tlm", "functional"):
            self.check_ran(self.run_script("--level", level), "paper-figure", "out/paper-figure")
            self.assertFalse((self.project / "out/paper-figure/trace.vcd").exists())
        self.check_ran(self.run_script("--level=rtl", "--out", "there"), "paper-figure", "there")
        self.assertTrue((self.project / "there/trace.gtkw").exists())

    def test_bad_arguments_are_refused_as_the_program_does(self):
        for words in (("--colour",), ("--out",), ("--level", "gate"), ("scenarios/none.yaml",),
                      ("scenarios/foveated.yaml", "scenarios/paper-figure.yaml"),
                      ("--check", "--level", "functional")):
            done = self.run_script(*words)
            self.assertEqual(done.returncode, BAD_INPUT, (words, done.stdout))
            self.assertEqual((done.stdout, done.stderr.count("\n")), ("", 1), done.stderr)
        self.assertFalse((self.project / "out").exists())

    def test_what_is_refused_leaves_the_results_of_an_earlier_run(self):
        self.check_ran(self.run_script(), "paper-figure", "out/paper-figure")
        folder = self.project / "out/paper-figure"
        before = {path.name: path.read_bytes() for path in folder.iterdir()}
        self.assertGreaterEqual(set(before), {"run.html", "trace.vcd", "trace.gtkw"})
        for words in (("--set", "frames=0"), ("--trace-window", "frame:99")):
            done = self.run_script(*words)
            self.assertEqual((done.returncode, done.stdout), (BAD_INPUT, ""), done.stderr)
            self.assertEqual({path.name: path.read_bytes() for path in folder.iterdir()}, before)

    def test_without_the_packages_for_a_build_what_is_built_runs(self):
        self.stand_in("scripts/install-packages", "echo 'missing packages' >&2; exit 1")
        self.stand_in("bin/cmake", "exit 1")
        done = self.run_script("--no-images")
        self.check_ran(done, "paper-figure", "out/paper-figure")
        self.assertRegex(done.stderr, r"\Amissing packages\nrun: using .*\n\Z")
        (self.project / "build/release/metabuffer").unlink()
        done = self.run_script("--no-images")
        self.assertEqual(done.returncode, 1)
        self.assertTrue(done.stderr.endswith("missing packages\n"), done.stderr)

    def test_help_is_the_scripts_own(self):
        for word in ("-h", "--help"):
            done = self.run_script("--check", word)
            self.assertEqual(done.returncode, DONE)
            self.assertIn("usage: scripts/run", done.stdout)


class Steps(Project):
    def test_a_package_that_cannot_be_had_fails_its_step_with_one_line_and_no_other(self):
        self.stand_in("scripts/install-packages", 'case "$*" in *shellcheck*) echo "no shellcheck" >&2; exit 1 ;; esac')
        self.stand_in("bin/clang-format-14", "touch formatted")
        done = self.run_script("scripts", "format", script="test")
        self.assertEqual(done.returncode, 1)
        self.assertRegex(done.stderr, r"\Ano shellcheck\nFAILED: scripts; \d+ s in all\n\Z")
        self.assertRegex(done.stdout, r"(?m)^-- scripts \d+ s, FAILED$")
        self.assertRegex(done.stdout, r"(?m)^-- format \d+ s$")
        self.assertTrue((self.project / "formatted").exists())

    def test_a_check_that_fails_stops_its_step_and_no_other(self):
        self.stand_in("bin/clang-format-14", "exit 1")
        self.stand_in("bin/shellcheck", "exit 1")
        done = self.run_script("scripts", "format", script="test")
        self.assertEqual(done.returncode, 1)
        self.assertRegex(done.stdout, r"(?m)^-- scripts \d+ s, FAILED$")
        self.assertRegex(done.stdout, r"(?m)^-- format \d+ s$")  # there are no files to format

    def test_the_help_lists_each_step_that_there_is_with_its_packages(self):
        text = self.run_script("--help", script="test").stdout
        script = (SCRIPTS / "test").read_text()
        steps = re.findall(r"^step_([\w-]+)\(\)", script, re.MULTILINE)
        self.assertGreater(len(steps), 15)
        for step in steps:
            self.assertRegex(text, rf"(?m)^{step}(, without an argument|, by this name only)?\n(    .*\n)+?    packages: \w")

    def test_wrong_words_are_one_line(self):
        for words in (("sanitise",), ("all", "lint"), ("lint", "all"), ("--fast",)):
            done = self.run_script(*words, script="test")
            self.assertEqual((done.returncode, done.stdout), (BAD_INPUT, ""))
            self.assertRegex(done.stderr, r"\Atest: .*\n\Z")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[3:])
