"""Tests the Python module against the program: the same reports, pictures and tables, and the same errors.

usage: module_test.py [TEST...], with METABUFFER_SOURCE and METABUFFER_PROGRAM in the environment
"""

import json
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest

import metabuffer
import numpy
from PIL import Image

import small_machine
from small_machine import PROGRAM, SOURCE

SCENARIOS = SOURCE / "scenarios"
LEVELS = ("tlm", "rtl", "functional")


class Import(unittest.TestCase):
    def test_another_python_than_the_module_s_is_told_which_one_that_is_for(self):
        # The package alone, with a module of a Python that there is not.
        with tempfile.TemporaryDirectory() as folder:
            package = pathlib.Path(folder) / "metabuffer"
            package.mkdir()
            for source in pathlib.Path(metabuffer.__file__).parent.glob("*.py"):
                (package / source.name).write_bytes(source.read_bytes())
            (package / "_core.cpython-38-x86_64-linux-gnu.so").touch()
            done = subprocess.run([sys.executable, "-B", "-c", "import metabuffer"], cwd=folder, text=True,
                                  env={**os.environ, "PYTHONPATH": folder}, stderr=subprocess.PIPE, check=False)
            self.assertEqual(done.returncode, 1)
            self.assertIn("is for CPython 3.8, and this is CPython "
                          f"{sys.version_info.major}.{sys.version_info.minor} ({sys.executable})",
                          done.stderr.splitlines()[-1])


class Scratch(unittest.TestCase):
    """In a folder that has the small machine's image."""

    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.folder = pathlib.Path(scratch.name).resolve()
        small_machine.write_image(self.folder)
        self.addCleanup(os.chdir, os.getcwd())
        os.chdir(self.folder)

    def program(self, *words):
        """Runs the program, which must succeed."""
        return subprocess.run([PROGRAM, *map(str, words)], stdout=subprocess.PIPE, text=True, check=True).stdout

    def scenario_file(self, name="scenario.yaml", **keys):
        file = self.folder / name
        file.write_text(json.dumps(small_machine.scenario(**keys)))
        return file


class Runs(Scratch):
    def check_against_program(self, scenario, *, level, frames):
        out = self.folder / "out"
        self.program("run", scenario, "--level", level, "--frames", frames, "--quiet", "--out", out)
        result = metabuffer.run(scenario, level=level, frames=frames)
        self.assertEqual(result.report_json, (out / "report.json").read_text())
        self.assertEqual(result.report, json.loads(result.report_json))
        for number, display in enumerate(result.displays, 1):
            self.assertEqual(len(display), frames)
            for frame, picture in enumerate(display):
                file = out / (f"display_{number}.{frame:04}.png" if frames > 1 else f"display_{number}.png")
                with Image.open(file) as image:
                    numpy.testing.assert_array_equal(picture, numpy.asarray(image.convert("RGB")), str(file))
        with Image.open(out / f"display_{len(result.displays)}.png") as image:
            numpy.testing.assert_array_equal(result.displays[-1][-1], numpy.asarray(image.convert("RGB")))
        return result

    def test_every_level_gives_what_the_program_writes(self):
        for level in LEVELS:
            with self.subTest(level):
                self.check_against_program(SCENARIOS / "paper-figure-small.yaml", level=level, frames=2)
                self.check_against_program(SCENARIOS / "case-1.yaml", level=level, frames=1)

    def test_a_run_that_starves_has_the_wrong_pixels_of_the_program(self):
        result = self.check_against_program(SCENARIOS / "paper-figure-starved.yaml", level="tlm", frames=3)
        self.assertGreater(result.wrong_pixels, 0)
        self.assertEqual(result.wrong_pixels, result.report["totals"]["wrong_pixels"])
        self.assertEqual(result.frames_per_second, result.report["rates"]["frames_per_second"])
        self.assertEqual(len(result.frames), 3)

    def test_a_picture_is_the_image_that_fills_the_display(self):
        for level in LEVELS:
            result = metabuffer.run(small_machine.scenario(), level=level)
            self.assertEqual([display.shape for display in result.displays], [(1, 4, 12, 3)])
            self.assertEqual(result.displays[0].tobytes(), small_machine.pixels())

    def test_the_wall_is_the_displays_side_by_side(self):
        result = metabuffer.run(SCENARIOS / "paper-figure-small.yaml", frames=1)
        displays = [display[0] for display in result.displays]
        wall = numpy.vstack([numpy.hstack(displays[:2]), numpy.hstack(displays[2:])])
        numpy.testing.assert_array_equal(result.wall(), wall)

    def test_without_images_there_are_counters_alone(self):
        counted = metabuffer.run(small_machine.scenario(frames=3), images=False)
        self.assertEqual([len(display) for display in counted.displays], [0])
        shown = metabuffer.run(small_machine.scenario(frames=3))
        self.assertEqual(counted.report["renderers"], shown.report["renderers"])
        self.assertEqual(counted.core_cycles, shown.core_cycles)

    def test_a_check_is_in_the_report_and_runs_at_level_rtl(self):
        result = metabuffer.run(small_machine.scenario(), check=True)
        self.assertEqual(result.report["level"], "rtl")
        self.assertEqual(result.report["check"]["violations"], 0)
        self.assertGreater(result.report["check"]["rules"], 0)

    def test_the_effective_scenario_makes_the_same_run(self):
        result = metabuffer.run(small_machine.scenario(), set={"bus.width_bits": 128})
        pathlib.Path("again.yaml").write_text(result.effective_scenario)
        self.assertEqual(metabuffer.run("again.yaml").report_json, result.report_json)
        self.assertIn("width_bits: 128", result.effective_scenario)

    def test_an_analysis_is_the_program_s(self):
        scenario = SCENARIOS / "case-4.yaml"
        expected = self.program("analyze", scenario, "--json", "--frame-rate-hz", 60, "--set", "bus.width_bits=64")
        self.assertEqual(metabuffer.analyze(scenario, frame_rate_hz=60, set={"bus.width_bits": 64}), json.loads(expected))


class Inputs(Scratch):
    def complaint(self, call, error=metabuffer.InputError):
        with self.assertRaises(error) as caught:
            call()
        self.assertNotIn("\n", str(caught.exception))
        return str(caught.exception)

    def program_s_complaint(self, *words):
        done = subprocess.run([PROGRAM, *map(str, words)], stderr=subprocess.PIPE, text=True, check=False)
        self.assertEqual(done.returncode, metabuffer.InputError.status)
        return done.stderr.rstrip("\n")

    def test_a_bad_file_is_reported_as_by_the_program(self):
        self.scenario_file("key.yaml", buss={"width_bits": 64})
        self.scenario_file("image.yaml", image="none.png")
        pathlib.Path("yaml.yaml").write_text("name: [")
        for name in ("key.yaml", "image.yaml", "yaml.yaml", "none.yaml", "."):
            with self.subTest(name):
                for call in (metabuffer.run, metabuffer.analyze):
                    self.assertEqual(self.complaint(lambda call=call: call(name)), self.program_s_complaint("run", name))

    def test_a_bad_setting_is_reported_as_by_the_program(self):
        self.scenario_file()
        for key, value in (("bus.width_bits", 65), ("bus.width", 64), ("bus.width_bits", "wide"), ("renderers.7.name", "x")):
            message = self.complaint(lambda: metabuffer.run("scenario.yaml", set={key: value}))
            self.assertEqual(message, self.program_s_complaint("run", "scenario.yaml", "--set", f"{key}={value}"))

    def test_a_bad_dict_is_reported_by_its_keys(self):
        self.assertEqual(self.complaint(lambda: metabuffer.run(small_machine.scenario(buss=1))),
                         "scenario: buss: is not a known key; the nearest is bus")
        self.assertRegex(self.complaint(lambda: metabuffer.run(small_machine.scenario("none.png"))),
                         "^scenario: renderers.*none.png.*")
        self.assertRegex(self.complaint(lambda: metabuffer.run({})), "^scenario")
        for call in (lambda scenario: metabuffer.size(scenario, "composer.buffer_pixels"),
                     lambda scenario: metabuffer.sweep({"scenario": scenario, "axes": []})):
            message = self.complaint(lambda call=call: call(small_machine.scenario(buss=1)))
            self.assertNotIn(tempfile.gettempdir(), message)

    def test_options_that_do_not_go_together_are_reported(self):
        scenario = small_machine.scenario()
        self.assertIn("functional", self.complaint(lambda: metabuffer.run(scenario, level="functional", check=True)))
        self.assertIn("functional", self.complaint(lambda: metabuffer.run(scenario, level="functional", images=False)))
        self.assertIn("'fast'", self.complaint(lambda: metabuffer.run(scenario, level="fast")))
        self.scenario_file()
        axes = [{"key": "bus.width_bits", "values": [64]}]
        sweep = {"scenario": "scenario.yaml", "axes": axes}
        self.assertIn("'functional'", self.complaint(lambda: metabuffer.sweep(sweep, level="functional")))
        self.assertIn("processes: 0", self.complaint(lambda: metabuffer.sweep(sweep, processes=0)))
        self.assertIn("time_limit: nan", self.complaint(lambda: metabuffer.sweep(sweep, time_limit=float("nan"))))
        self.assertIn("checks: -1", self.complaint(lambda: metabuffer.size(scenario, "bus.burst_pixels", checks=-1)))
        self.assertIn("frame_rate_hz: 0", self.complaint(lambda: metabuffer.analyze(scenario, frame_rate_hz=0)))
        self.assertIn("out", self.complaint(lambda: metabuffer.size(scenario, "bus.burst_pixels", out="out.db")))
        self.assertFalse(pathlib.Path("out.db").exists())

    def test_wrong_types_are_type_errors(self):
        for call in (lambda: metabuffer.run(7), lambda: metabuffer.run(None), lambda: metabuffer.run([]),
                     lambda: metabuffer.run(small_machine.scenario(), set=["bus.width_bits=64"]),
                     lambda: metabuffer.run(small_machine.scenario(), set={7: 8}),
                     lambda: metabuffer.run(small_machine.scenario(name=object())),
                     lambda: metabuffer.run(small_machine.scenario(), level=7),
                     lambda: metabuffer.run(small_machine.scenario(), images="no"),
                     lambda: metabuffer.analyze(small_machine.scenario(), frame_rate_hz="60"),
                     lambda: metabuffer.size(small_machine.scenario(), ["bus.burst_pixels"]),
                     lambda: metabuffer.size(small_machine.scenario(), "bus.burst_pixels", over=[64]),
                     lambda: metabuffer.size(small_machine.scenario(), "bus.burst_pixels", processes=1.5),
                     lambda: metabuffer.results(7)):
            self.complaint(call, TypeError)

    def test_numbers_of_numpy_and_paths_are_values(self):
        scenario = small_machine.scenario(pathlib.Path("view.ppm"), frames=numpy.int64(2), depth_range=numpy.array([0, 9.5]))
        result = metabuffer.run(scenario, set={"bus.width_bits": numpy.int32(128), "composer.on_starvation": "stall"})
        self.assertEqual(len(result.displays[0]), 2)
        self.assertIn("width_bits: 128", result.effective_scenario)
        self.assertIn("stall", result.effective_scenario)

    def test_a_text_in_set_is_yaml_as_on_the_command_line(self):
        result = metabuffer.run(small_machine.scenario(), set={"bus.width_bits": "128",
                                                               "renderers.0.frames.0.viewport": "{x: 1, y: 0}"})
        self.assertEqual(result.displays[0][0, 0, 1:].tobytes(), small_machine.pixels()[:33])

    def test_the_name_of_a_file_may_be_any_bytes(self):
        name = b"sc\xe9n\xe0rio.yaml"
        self.scenario_file().rename(os.fsdecode(name))
        self.assertEqual(metabuffer.run(name).report["totals"], metabuffer.run(os.fsdecode(name)).report["totals"])
        self.complaint(lambda: metabuffer.run(b"n\xf6.yaml"))


class Tables(Scratch):
    AXES = [{"key": "bus.width_bits", "values": [64, 128]}, {"key": "bus.burst_pixels", "values": [2, 3]}]

    def check_against_export(self, table, file):
        rows = json.loads(self.program("export", file, "--format", "json", "--bookkeeping"))
        self.assertEqual(list(table.columns), list(rows[0]))
        mine = json.loads(table.to_json(orient="records", double_precision=15))
        for got, expected in zip(mine, rows, strict=True):
            for column in expected:
                if column not in ("wall_seconds", "point", "run"):
                    if isinstance(expected[column], float):
                        self.assertAlmostEqual(got[column], expected[column], 12, column)
                    else:
                        self.assertEqual(got[column], expected[column], column)

    def test_a_sweep_is_the_program_s(self):
        self.scenario_file()
        sweep = {"scenario": "scenario.yaml", "axes": self.AXES, "filter": "bus.burst_pixels < 3 or bus.width_bits < 128"}
        pathlib.Path("sweep.yaml").write_text(json.dumps(sweep))
        self.program("sweep", "sweep.yaml", "-o", "program.db", "--quiet")
        tables = [metabuffer.sweep("sweep.yaml"), metabuffer.sweep(sweep, out=self.folder / "module.db"),
                  metabuffer.sweep({**sweep, "scenario": small_machine.scenario()}, processes=1),
                  metabuffer.results("module.db"), metabuffer.results(self.folder / "program.db")]
        for table in tables:
            self.assertEqual(len(table), 3)
            self.check_against_export(table, "program.db")
        self.assertEqual(tables[1].attrs["keys"], ["bus.width_bits", "bus.burst_pixels"])

    def test_results_that_are_there_are_not_run_again(self):
        self.scenario_file()
        sweep = {"scenario": "scenario.yaml", "axes": self.AXES}
        first = metabuffer.sweep(sweep, out="kept.db")
        again = metabuffer.sweep(sweep, out="kept.db")
        self.assertEqual(list(first["wall_seconds"]), list(again["wall_seconds"]))
        with self.assertRaisesRegex(metabuffer.InputError, "kept.db"):
            metabuffer.sweep({**sweep, "set": {"frames": 2}}, out="kept.db")

    def test_a_point_that_fails_is_a_row_but_no_point_at_all_is_an_error(self):
        self.scenario_file()
        axis = {"key": "bus.width_bits", "values": [64, 65]}
        table = metabuffer.sweep({"scenario": "scenario.yaml", "axes": [axis]})
        self.assertEqual(list(table["status"]), ["done", "invalid"])
        self.assertIn("65", table["reason"][1])
        with self.assertRaisesRegex(metabuffer.InputError, "65"):
            metabuffer.sweep({"scenario": "scenario.yaml", "axes": [{**axis, "values": [65]}]})

    def test_a_search_is_the_program_s(self):
        scenario = SCENARIOS / "case-4.yaml"
        self.program("size", scenario, "--minimize", "composer.buffer_pixels", "--over", "bus.width_bits=64,128", "--quiet",
                     "-o", "program.db")
        table = metabuffer.size(scenario, "composer.buffer_pixels", over={"bus.width_bits": [64, 128]})
        self.check_against_export(table, "program.db")
        self.assertEqual(table.attrs["search_key"], "composer.buffer_pixels")
        ranged = metabuffer.size(scenario, "composer.buffer_pixels=16..512", over={"bus.width_bits": "128"}, checks=2)
        self.assertEqual(list(ranged["smallest"]), [table["smallest"][1]])

    def test_a_dict_is_searched_with_its_images(self):
        table = metabuffer.size(small_machine.scenario(), "composer.buffer_pixels=2..64", goal="starved_pixels = 0")
        self.assertEqual(list(table["status"]), ["done"])

    def test_units_are_those_of_the_program_s_help(self):
        self.scenario_file()
        table = metabuffer.sweep({"scenario": "scenario.yaml", "axes": self.AXES})
        text = self.program("export", "--help")
        units = dict(line.split(":")[0].strip().rstrip(")").split(" (") for line in text.splitlines()
                     if line.startswith("  ") and " (" in line.split(":")[0] and line.split(" (")[0].strip() in table.columns)
        self.assertGreater(len(units), 20)
        self.assertEqual(table.attrs["units"], {**units, "wall_seconds": "s"})

    def test_conditions_and_columns_are_expressions(self):
        self.scenario_file()
        metabuffer.sweep({"scenario": "scenario.yaml", "axes": self.AXES}, out="kept.db")
        table = metabuffer.results("kept.db", where="bus.width_bits = 64", columns=["bus.burst_pixels", "core_cycles"])
        self.assertEqual(list(table.columns), ["bus.burst_pixels", "core_cycles"])
        self.assertEqual(list(table["bus.burst_pixels"]), [2, 3])
        self.assertEqual(table.attrs["units"], {"core_cycles": "clocks"})
        empty = metabuffer.results("kept.db", where="bus.width_bits = 7")
        self.assertEqual(len(empty), 0)
        self.assertIn("core_cycles", empty.columns)
        with self.assertRaisesRegex(metabuffer.InputError, "core_cycle"):
            metabuffer.results("kept.db", where="core_cycle = 7")


def children_of(process):
    return [int(child) for task in pathlib.Path(f"/proc/{process}/task").iterdir()
            for child in (task / "children").read_text().split()]


def is_alive(process):
    try:
        return pathlib.Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] not in "ZX"
    except OSError:
        return False


def wait_until(condition):
    """Ended by CTest's time limit if the condition never holds."""
    while not condition():
        time.sleep(0.01)


LONG_RUN = """
import metabuffer, small_machine
try:
    metabuffer.{call}
except KeyboardInterrupt:
    print("interrupted", flush=True)
print(metabuffer.run(small_machine.scenario()).starved_pixels, flush=True)
"""
CALLS = ('run(small_machine.scenario(frames=1000000), level="rtl")',
         'sweep({"scenario": small_machine.scenario(frames=1000000), "axes": [{"key": "bus.width_bits", '
         '"values": [64, 128]}]}, level="rtl", processes=2)')


class Processes(Scratch):
    def start(self, call):
        """Starts a Python process that makes the call; returns it and the call's processes."""
        environment = dict(os.environ, PYTHONPATH=os.pathsep.join((os.environ["PYTHONPATH"], str(pathlib.Path(__file__).parent))))
        # In a shell's background Ctrl-C is ignored, and children inherit that.
        python = subprocess.Popen([sys.executable, "-c", LONG_RUN.format(call=call)], env=environment, text=True,
                                  stdout=subprocess.PIPE,
                                  preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL))
        self.addCleanup(python.stdout.close)
        self.addCleanup(python.wait)
        self.addCleanup(python.kill)
        wait_until(lambda: children_of(python.pid))
        family = children_of(python.pid)
        if call.startswith("sweep"):
            # One process reads the images, two simulate.
            wait_until(lambda: len(children_of(family[0])) == 3)
            family += children_of(family[0])
        return python, family

    def test_ctrl_c_ends_the_call_and_python_goes_on(self):
        for call in CALLS:
            with self.subTest(call):
                python, family = self.start(call)
                python.send_signal(signal.SIGINT)
                self.assertEqual(python.communicate()[0].split(), ["interrupted", "0"])
                wait_until(lambda family=family: not any(map(is_alive, family)))

    def test_nothing_outlives_a_python_that_is_killed(self):
        for call in CALLS:
            with self.subTest(call):
                python, family = self.start(call)
                python.kill()
                wait_until(lambda family=family: not any(map(is_alive, family)))

    def test_threads_run_at_once(self):
        expected = metabuffer.run(small_machine.scenario(frames=5))
        results, errors = [], []

        def work():
            try:
                for _ in range(3):
                    results.append(metabuffer.run(small_machine.scenario(frames=5)))
                    self.assertRaises(metabuffer.InputError, metabuffer.run, "none.yaml")
            except Exception as error:  # or nobody outside of the thread would see it
                errors.append(error)

        threads = [threading.Thread(target=work) for _ in range(6)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(errors, [])
        self.assertEqual({result.report_json for result in results}, {expected.report_json})
        for result in results:
            numpy.testing.assert_array_equal(result.displays[0], expected.displays[0])
        self.assertEqual(len(results), 18)

    def test_the_lock_is_free_while_a_call_waits(self):
        python_has_gone_on = threading.Event()
        threading.Timer(0.01, python_has_gone_on.set).start()
        wait_until(lambda: metabuffer.run(small_machine.scenario(frames=200)) and python_has_gone_on.is_set())

    def test_nothing_stays_open(self):
        metabuffer.run(small_machine.scenario())
        before = sorted(os.listdir("/proc/self/fd"))
        for _ in range(5):
            metabuffer.run(small_machine.scenario())
            self.assertRaises(metabuffer.InputError, metabuffer.run, "none.yaml")
        self.assertEqual(sorted(os.listdir("/proc/self/fd")), before)
        self.assertEqual(children_of(os.getpid()), [])

    def test_the_run_is_not_part_of_this_process(self):
        # In a shell's background Ctrl-C is ignored.
        before = signal.getsignal(signal.SIGINT)
        metabuffer.run(small_machine.scenario())
        maps = pathlib.Path("/proc/self/maps").read_text()
        self.assertNotIn("libOpenImageIO", maps)
        self.assertIs(signal.getsignal(signal.SIGINT), before)


if __name__ == "__main__":
    unittest.main()
