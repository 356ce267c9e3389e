"""Tests the built program in a hostile environment: input that is not a file, outputs that would replace inputs, full
disks, memory that ends, runs that are killed or meet in one folder, damaged results.

usage: hostile_test.py METABUFFER MODULES [CLASS...]

MODULES: the folder with the modules of images that wait or crash when they are loaded, and the libraries to be preloaded.
"""

import errno
import os
import pathlib
import pwd
import resource
import shutil
import signal
import sqlite3
import subprocess
import sys
import tempfile
import time
import unittest

from small_machine import IMAGE, SCENARIO

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
from lib.parallel import alive_in  # noqa: E402

METABUFFER, MODULES = (pathlib.Path(word).resolve() for word in sys.argv[1:3])
DONE, BAD_INPUT = 0, 2
LONGEST_LINE = 400

# Runs for a minute and more, so that there is time to kill it.
LONG_SCENARIO = """name: long
frames: 200000
displays: {width: 64, height: 48}
renderers:
  - frames: [{image: large.ppm, z: 0, viewport: {x: 0, y: 0}}]
"""


def limits(**kept):
    """For subprocess: sets resource limits, as `ulimit` does."""
    def set_them():
        for name, value in kept.items():
            resource.setrlimit(getattr(resource, name), (value, value))
    return set_them


def wait_until(holds, seconds=60):
    deadline = time.monotonic() + seconds
    while not holds():
        if time.monotonic() > deadline:
            return False
        time.sleep(0.02)
    return True


def mapping(group, library):
    """The processes of a group that have loaded the library."""
    found = []
    for process in alive_in(group):
        try:
            if library in pathlib.Path(f"/proc/{process}/maps").read_text(encoding="utf-8"):
                found.append(process)
        except OSError:  # it has just ended
            pass
    return found


class Hostile(unittest.TestCase):
    program = METABUFFER

    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.folder = pathlib.Path(scratch.name).resolve()
        self.write("scenario.yaml", SCENARIO)
        self.write("view.ppm", IMAGE)

    def write(self, name, content):
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return path

    def run_program(self, *words, **options):
        settings = {"cwd": self.folder, "stdin": subprocess.DEVNULL, "stdout": subprocess.PIPE,
                    "stderr": subprocess.PIPE, "timeout": 120, **options}
        return subprocess.run([self.program, *words], check=False, **settings)

    def start_program(self, *words, **options):
        """Starts the program in its own process group."""
        process = subprocess.Popen([self.program, *words], cwd=self.folder, stdin=subprocess.DEVNULL,
                                   stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, start_new_session=True, **options)
        self.addCleanup(process.stderr.close)
        self.addCleanup(self.kill_group, process)
        return process

    @staticmethod
    def kill_group(process):
        try:
            os.killpg(process.pid, signal.SIGKILL)
        except ProcessLookupError:
            pass
        process.wait()

    def check_line(self, done, *parts, status=BAD_INPUT):
        """The program has ended with one line, not too long, that holds these parts."""
        text = done.stderr.decode(errors="replace")
        self.assertEqual(done.returncode, status, text[:1000])
        self.assertEqual(text.count("\n"), 1, text[:1000])
        self.assertLessEqual(len(text), LONGEST_LINE + 1)
        self.assertFalse(any(ord(character) < 32 for character in text[:-1]), repr(text))
        for part in parts:
            self.assertIn(part, text)

    def snapshot(self, folder="."):
        return {str(path.relative_to(self.folder)): path.read_bytes()
                for path in sorted((self.folder / folder).rglob("*")) if path.is_file() and not path.is_symlink()}


class Input(Hostile):
    """What an input path names is checked before it is read."""

    def test_a_pipe_or_a_device_is_not_a_scenario_or_an_image(self):
        os.mkfifo(self.folder / "pipe")
        for what in ("pipe", "/dev/zero"):
            with self.subTest(what):
                self.check_line(self.run_program("run", what), what, "is no regular file")
                self.check_line(self.run_program("sweep", what, "-o", "r.db"), what, "is no regular file")
                self.write("other.yaml", SCENARIO.replace("view.ppm", what))
                self.check_line(self.run_program("run", "other.yaml"), what, "is no regular file")
                self.check_line(self.run_program("run", "scenario.yaml", "--set",
                                                 f"displays.correction=[{{display: 1, lut: {what}}}]"),
                                what, "is no regular file")
                self.check_line(self.run_program("export", what), what, "is no file")

    def test_a_colour_table_that_is_not_one_is_bad_input(self):
        whole = "1,2,3\n" * 256
        for name, table, part in (
                ("short", "1,2,3\n" * 255, "has 255 rows"), ("long", "1,2,3\n" * 257, "has 257 rows"),
                ("bright", whole[:-6] + "1,2,300\n", ":256: '300'"), ("bytes", os.urandom(20_000), "table"),
                ("huge", b"\0" * (1 << 20), "is longer than 64 KiB"), ("wide", "1" * 60_000, "table"),
                ("commas", "," * 60_000, "has 60001 values"), ("lines", "\n" * 60_000 + "1,2,3", "has 1 value")):
            with self.subTest(name):
                self.write("table", table)
                self.check_line(self.run_program("run", "scenario.yaml", "--out", "out", "--set",
                                                 "displays.correction=[{display: 1, lut: table}]"),
                                "displays.correction[0].lut", part)
                self.assertFalse((self.folder / "out").exists())
        self.check_line(self.run_program("run", "scenario.yaml", "--set",
                                         "displays.correction=[{display: 1, lut: absent}]"), "absent", "No such file")

    def test_paths_that_the_system_refuses_are_bad_input(self):
        (self.folder / "loop").symlink_to("loop")
        for path in ("n" * 300, "loop", "loop/inside", "n" * 5000):
            with self.subTest(path[:10]):
                self.check_line(self.run_program("run", path))
                self.check_line(self.run_program("run", "scenario.yaml", "--out", path))
                self.check_line(self.run_program("run", "scenario.yaml", "--trace", path + "/x.vcd"))
                self.check_line(self.run_program("run", "scenario.yaml", "--trace", path + "/x.json"))
                self.check_line(self.run_program("export", path))
                self.check_line(self.run_program("plot", path, "--x", "a", "--y", "b", "-o", path + ".svg"))
                self.assertTrue((self.folder / "loop").is_symlink())

    def test_a_working_directory_that_is_gone_is_reported(self):
        gone = self.folder / "gone"
        gone.mkdir()
        script = 'cd "$1" && rmdir "$1" && exec "$2" run "$3"'
        done = subprocess.run(["sh", "-c", script, "sh", gone, METABUFFER, self.folder / "scenario.yaml"],
                              stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, timeout=60,
                              check=False)
        self.check_line(done)

    def test_a_text_that_aliases_multiply_is_refused(self):
        words = "a: &a " + "x" * 1_000_000 + "\n"
        aliases = "b: [" + ", ".join(["*a"] * 5000) + "]\n"
        self.write("aliases.yaml", words + aliases + SCENARIO)
        done = self.run_program("run", "aliases.yaml", preexec_fn=limits(RLIMIT_AS=2 << 30))
        self.check_line(done, "aliases.yaml:", "MiB of text")

    def test_many_keys_in_a_map_take_no_longer_each(self):
        keys = "".join(f"key{n}: 1\n" for n in range(100_000))
        self.write("keys.yaml", keys)
        # Quadratic, it took twenty seconds of the processor.
        done = self.run_program("run", "keys.yaml", preexec_fn=limits(RLIMIT_CPU=10))
        self.check_line(done, "keys.yaml:1: key0: is not a known key")

    def test_what_is_repeated_from_the_input_is_cut_and_stays_on_one_line(self):
        self.write("digits.yaml", SCENARIO + "frames: " + "9" * 1_000_000 + "\n")
        self.check_line(self.run_program("run", "digits.yaml"), "frames")
        self.check_line(self.run_program("run", "scenario.yaml", "--trace", "t.vcd", "--trace-window", "a\nb\x1b[1m"),
                        "--trace-window")
        for words in (["run"], ["compare"], ["analyze"], ["size", "--minimize", "composer.buffer_pixels=1..64"]):
            self.check_line(self.run_program(*words, "scenario.yaml", "--set", "bus.width_bits=" + "7" * 100_000))
        self.check_line(self.run_program("--" + "x" * 100_000))
        self.check_line(self.run_program("run", "scenario.yaml", "--frames", "9" * 10_000))

    def test_a_number_option_takes_no_nan(self):
        for words in (["sweep", "scenario.yaml", "-o", "r.db", "--time-limit"],
                      ["size", "scenario.yaml", "--minimize", "composer.buffer_pixels", "--time-limit"],
                      ["size", "scenario.yaml", "--minimize", "composer.buffer_pixels", "--frame-rate-hz"],
                      ["analyze", "scenario.yaml", "--frame-rate-hz"]):
            for number in ("nan", "-nan", "inf", "-1", "0", "1e999"):
                with self.subTest(" ".join([*words[-1:], number])):
                    self.check_line(self.run_program(*words[:-1], f"{words[-1]}={number}"), "out of range; use 0.001 to")

    def test_libraries_say_nothing_of_a_broken_image(self):
        picture = self.folder / "good"
        self.assertEqual(self.run_program("run", "scenario.yaml", "--out", picture).returncode, DONE)
        png = (picture / "display_1.png").read_bytes()
        pixels = png.index(b"IDAT") + 4
        self.write("broken.yaml", SCENARIO.replace("view.ppm", "broken.png"))
        for broken in (png[:pixels + 3], png[:pixels] + b"\xff" * 8 + png[pixels + 8:],
                       png[:16] + b"\xff" * 8 + png[24:]):
            self.write("broken.png", broken)
            self.check_line(self.run_program("run", "broken.yaml"), "broken.png", "is not a readable image")


class Output(Hostile):
    """What is written is whole, and replaces nothing that is read."""

    def test_a_waveform_that_cannot_be_written_to_its_end_is_reported(self):
        words = ("run", "scenario.yaml", "--trace", "t.vcd", "--trace-window", "all")
        done = self.run_program(*words, preexec_fn=limits(RLIMIT_FSIZE=20_000))
        self.check_line(done, "cannot write 't.vcd'", "File too large")
        (self.folder / "t.vcd").symlink_to("/dev/full")
        self.check_line(self.run_program(*words), "t.vcd", "is no regular file")
        self.assertTrue((self.folder / "t.vcd").is_symlink())

    def test_a_trace_through_a_symbolic_link_goes_to_where_the_link_leads(self):
        for name in ("t.vcd", "t.json"):
            with self.subTest(name):
                (self.folder / name).symlink_to("real-" + name)
                done = self.run_program("run", "scenario.yaml", "--trace", name)
                self.assertEqual(done.returncode, DONE, done.stderr)
                self.assertTrue((self.folder / name).is_symlink())
                self.assertGreater((self.folder / ("real-" + name)).stat().st_size, 1000)

    def test_a_full_standard_output_is_reported_by_every_command(self):
        self.assertEqual(self.run_program("size", "scenario.yaml", "--minimize", "composer.buffer_pixels=1..64",
                                          "--out", "r.db").returncode, DONE)
        for words in (["--help"], ["--version"], ["run", "--help"], ["run", "scenario.yaml"], ["keys"], ["counters"],
                      ["analyze", "scenario.yaml"], ["compare", "scenario.yaml"], ["export", "r.db"],
                      ["size", "scenario.yaml", "--minimize", "composer.buffer_pixels=1..64"],
                      ["size", "scenario.yaml", "--minimize", "composer.buffer_pixels=1..64", "--quiet"]):
            with self.subTest(" ".join(words)), open("/dev/full", "wb") as full:
                done = self.run_program(*words, stdout=full)
                self.assertEqual(done.returncode, BAD_INPUT)
                self.assertIn(b"standard output cannot be written\n", done.stderr)

    def test_no_output_replaces_an_input(self):
        self.write("display_1.png", b"")
        self.write("report.json", SCENARIO)
        self.write("display_7.0003.png", IMAGE)
        self.write("odd.yaml", SCENARIO.replace("view.ppm", "display_7.0003.png"))
        self.write("effective_scenario.yaml", SCENARIO)
        self.write("link.vcd", "").unlink()
        (self.folder / "link.vcd").symlink_to("scenario.yaml")
        os.link(self.folder / "view.ppm", self.folder / "hard.json")
        before = self.snapshot()
        for words in (["run", "report.json", "--out", "."], ["run", "effective_scenario.yaml", "--out", "."],
                      ["run", "odd.yaml", "--out", "."], ["run", "odd.yaml", "--out", ".", "--no-images"],
                      ["view", "scenario.yaml", "-o", "view.ppm"], ["view", ".", "-o", "report.json"],
                      ["view", "scenario.yaml", "-o", "link.vcd"],
                      ["run", "scenario.yaml", "--trace", "link.vcd"], ["run", "scenario.yaml", "--trace", "hard.json"]):
            with self.subTest(" ".join(words)):
                self.check_line(self.run_program(*words), "would replace")
                self.assertEqual(self.snapshot(), before)
        self.assertEqual(self.run_program("sweep", "scenario.yaml", "-o", "scenario.yaml").returncode, BAD_INPUT)
        self.assertEqual(self.snapshot(), before)

    def test_results_are_not_replaced_by_what_is_made_of_them(self):
        self.run_program("size", "scenario.yaml", "--minimize", "composer.buffer_pixels=1..64", "--out", "r.svg")
        before = (self.folder / "r.svg").read_bytes()
        for words in (["export", "r.svg", "-o", "r.svg"], ["report", "r.svg", "-o", "r.svg"],
                      ["plot", "r.svg", "--x", "smallest", "--y", "runs", "-o", "r.svg"]):
            with self.subTest(words[0]):
                self.check_line(self.run_program(*words), "would replace")
                self.assertEqual((self.folder / "r.svg").read_bytes(), before)

    def test_what_lies_in_the_results_folder_and_is_not_the_run_s_stays(self):
        self.write("out/display_99.png/inside", "kept")
        self.write("out/notes.txt", "kept")
        self.write("stranger", "kept")
        for name in ("report.json.part", ".metabuffer-1-0.part"):
            (self.folder / "out" / name).symlink_to(self.folder / "stranger")
        self.assertEqual(self.run_program("run", "scenario.yaml", "--out", "out").returncode, DONE)
        for name in ("out/display_99.png/inside", "out/notes.txt", "stranger"):
            self.assertEqual((self.folder / name).read_text(), "kept")

    def test_a_run_that_fails_leaves_the_earlier_results_whole(self):
        self.assertEqual(self.run_program("run", "scenario.yaml", "--out", "out").returncode, DONE)
        before = self.snapshot("out")
        larger = "name: other\nframes: 4\ndisplays: {width: 640, height: 480}\n" + SCENARIO.split("\n", 2)[2]
        self.write("other.yaml", larger)
        done = self.run_program("run", "other.yaml", "--out", "out", preexec_fn=limits(RLIMIT_FSIZE=3000))
        self.check_line(done, "cannot write", "File too large")
        self.assertEqual(self.snapshot("out"), before)
        self.assertEqual(self.run_program("run", "other.yaml", "--out", "out").returncode, DONE)
        self.assertNotEqual(self.snapshot("out"), before)

    def test_a_killed_run_leaves_the_earlier_results_whole_and_the_next_one_clears_up(self):
        self.write("large.ppm", b"P6\n64 48\n255\n" + bytes(64 * 48 * 3))
        self.write("long.yaml", LONG_SCENARIO)
        self.assertEqual(self.run_program("run", "scenario.yaml", "--out", "out").returncode, DONE)
        before = self.snapshot("out")
        process = self.start_program("run", "long.yaml", "--out", "out", "--quiet")
        aside = self.folder / "out/.metabuffer-unfinished"
        self.assertTrue(wait_until(lambda: aside.is_dir() and any(aside.iterdir())))
        self.kill_group(process)
        kept = {name: content for name, content in self.snapshot("out").items() if "/.metabuffer-" not in name}
        self.assertEqual(kept, before)
        self.assertEqual(self.run_program("run", "scenario.yaml", "--out", "out").returncode, DONE)
        self.assertEqual(self.snapshot("out").keys(), before.keys())

    def test_a_second_run_into_a_folder_is_refused_with_the_first_one_s_number(self):
        self.write("large.ppm", b"P6\n64 48\n255\n" + bytes(64 * 48 * 3))
        self.write("long.yaml", LONG_SCENARIO)
        process = self.start_program("run", "long.yaml", "--out", "out", "--quiet")
        self.assertTrue(wait_until((self.folder / "out/.metabuffer-unfinished").is_dir))
        self.check_line(self.run_program("run", "scenario.yaml", "--out", "out"), "out", f"({process.pid})")
        self.kill_group(process)
        self.assertEqual(self.run_program("run", "scenario.yaml", "--out", "out").returncode, DONE)


class Resources(Hostile):
    """When memory or processes run out, or a part of the program is killed, the program ends with one line."""

    def test_wherever_memory_ends_there_is_one_line(self):
        self.write("wide.yaml", "name: wide\ndisplays: {columns: 2, width: 640, height: 480}\n" +
                   SCENARIO.split("\n", 2)[2])
        reached = set()
        for words in (["--version"], ["run", "wide.yaml"], ["run", "wide.yaml", "--level", "functional"],
                      ["compare", "wide.yaml"], ["run", "wide.yaml", "--trace", "t.vcd"],
                      ["size", "wide.yaml", "--minimize", "composer.buffer_pixels=1..4096", "--processes", "1"]):
            for mebibytes in (24, 32, 40, 48, 64, 96, 160, 256, 384, 448, 512, 640, 896, 1280):
                with self.subTest(f"{' '.join(words)}, {mebibytes} MiB"):
                    done = self.run_program(*words, preexec_fn=limits(RLIMIT_AS=mebibytes << 20))
                    if done.returncode == 127 and b"shared librar" in done.stderr:
                        continue  # the system could not even load the program
                    reached.add(done.returncode)
                    if done.returncode != DONE:
                        self.check_line(done)
        self.assertEqual(reached, {DONE, BAD_INPUT})

    def test_a_parallel_blas_is_not_even_loaded(self):
        # Debian's libopenblas0-pthread is, if it is installed, the BLAS of a library that OpenImageIO brings along for videos.
        # When it was loaded it started a thread for each further processor, and where these found no memory it tried for
        # ever.
        folders = list(pathlib.Path("/usr/lib").glob("*/openblas-pthread"))
        self.assertTrue(folders, "apt install libopenblas0-pthread")
        environment = dict(os.environ, LD_LIBRARY_PATH=str(folders[0]), OPENBLAS_NUM_THREADS="8")
        for mebibytes in range(64, 704, 32):
            with self.subTest(f"{mebibytes} MiB"):
                done = self.run_program("run", "scenario.yaml", env=environment, timeout=60,
                                        preexec_fn=limits(RLIMIT_AS=mebibytes << 20))
                if done.returncode != DONE:
                    self.check_line(done)
        self.write("large.ppm", b"P6\n64 48\n255\n" + bytes(64 * 48 * 3))
        self.write("long.yaml", LONG_SCENARIO)
        process = self.start_program("run", "long.yaml", "--pictures", "none", env=environment)
        # The process that has loaded the libraries, and its child that reads the images.
        self.assertTrue(wait_until(lambda: len(mapping(process.pid, "libOpenImageIO.so")) == 2))
        for name in ("libblas", "libgdal", "libavcodec.so.59."):
            self.assertEqual(mapping(process.pid, name), [])

    def test_libraries_that_hang_or_crash_when_they_are_loaded_are_one_line(self):
        self.write("nothing/metabuffer_images.so", "")
        for folder, line in ((MODULES / "waiting", "are not loaded after 20 s"), (MODULES / "crashing", "ended by a signal: Abort"),
                             (self.folder / "nothing", "metabuffer_images.so: file too short")):
            with self.subTest(folder.name):
                environment = dict(os.environ, LD_LIBRARY_PATH=str(folder))
                done = self.run_program("run", "scenario.yaml", "--out", "out", env=environment, timeout=60)
                self.check_line(done, "scenario.yaml:", "images can be neither read nor written", line)
                self.assertFalse((self.folder / "out").exists())

    def test_wherever_processes_end_there_is_one_line(self):
        environment = dict(os.environ, HOME=str(self.folder))
        user = {}
        if os.getuid() == 0:
            # Root may have any number of them. Another user may not enter the build's folder if that is in root's home.
            self.program = shutil.copy(METABUFFER, self.folder)
            environment["LD_LIBRARY_PATH"] = shutil.copytree(METABUFFER.parent / "modules", self.folder / "modules")
            nobody = pwd.getpwnam("nobody")
            for path in (self.folder, *self.folder.iterdir()):
                os.chown(path, nobody.pw_uid, nobody.pw_gid)
            user = {"user": nobody.pw_uid, "group": nobody.pw_gid, "extra_groups": []}
            self.assertEqual(self.run_program("--version", **user).returncode, DONE)
        trace = ["--trace", "t.vcd", "--trace-window", "startframe:0"]
        commands = (["--version"], ["run", "scenario.yaml", "--quiet"], ["run", "scenario.yaml", *trace],
                    ["view", "scenario.yaml", "-o", "t.html"], ["compare", "scenario.yaml"])
        others = sum(1 for entry in pathlib.Path("/proc").iterdir()
                     if entry.name.isdigit() and entry.stat().st_uid == user.get("user", os.getuid()))
        for words in commands:
            # With few, OpenImageIO's libraries would wait for each other for ever.
            for processes in range(1, 12):
                with self.subTest(f"{' '.join(words)}, {processes} processes"):
                    done = self.run_program(*words, env=environment, **user,
                                            preexec_fn=limits(RLIMIT_NPROC=others + processes))
                    if done.returncode != DONE:
                        self.check_line(done)

    def test_a_high_column_takes_no_more_stack_than_a_low_one(self):
        self.write("view.ppm", b"P6\n12 2\n255\n" + bytes(72))
        self.write("high.yaml", SCENARIO.replace("  - frames:", "  - copies: 4096\n    frames:"))
        # When composers passed on PIPEREADY, STARTFRAME and pixels by nested calls, 4,096 of them took half a megabyte.
        done = self.run_program("run", "high.yaml", "--quiet", preexec_fn=limits(RLIMIT_STACK=256 << 10))
        self.assertEqual(done.returncode, DONE, done.stderr)

    def test_no_process_outlives_the_program(self):
        self.write("large.ppm", b"P6\n64 48\n255\n" + bytes(64 * 48 * 3))
        self.write("long.yaml", LONG_SCENARIO)
        for words in (["run", "long.yaml", "--trace", "t.vcd", "--trace-window", "first-starved-pixel"],
                      ["run", "long.yaml", "--trace", "t.vcd", "--trace-window", "cycles:0-1000000"],
                      ["compare", "long.yaml"],
                      ["size", "long.yaml", "--minimize", "composer.buffer_pixels=64..4096"]):
            with self.subTest(" ".join(words)):
                process = self.start_program(*words)
                self.assertTrue(wait_until(lambda: len(alive_in(process.pid)) > 1))
                process.kill()
                process.wait()
                self.assertTrue(wait_until(lambda: not alive_in(process.pid), 20))

    def test_a_killed_search_for_the_window_is_an_error(self):
        self.write("large.ppm", b"P6\n64 48\n255\n" + bytes(64 * 48 * 3))
        self.write("long.yaml", LONG_SCENARIO)
        process = self.start_program("run", "long.yaml", "--trace", "t.vcd", "--trace-window", "first-starved-pixel",
                                     "--pictures", "none")  # or there are processes that encode them
        # The program waits for the process that searches for the window, and there are the two that have read the image and
        # the one that waits to try what keeps pixels from starving; no process writes a waveform yet.
        self.assertTrue(wait_until(lambda: len(alive_in(process.pid)) == 5))
        for child in alive_in(process.pid):
            if child != process.pid:
                os.kill(child, signal.SIGKILL)
        _, text = process.communicate(timeout=60)
        self.assertEqual(process.returncode, BAD_INPUT, text)
        self.assertIn(b"--trace", text)
        self.assertFalse((self.folder / "t.vcd").exists())


class Results(Hostile):
    """A file of results is input, whatever somebody has done to it."""

    DAMAGE = ("UPDATE meta SET value = '[1]' WHERE key = 'fixed'", "UPDATE meta SET value = '{' WHERE key = 'fixed'",
              "UPDATE meta SET value = '{\"a\": 1}' WHERE key = 'fixed'", "DELETE FROM meta", "DROP TABLE pictures",
              "DROP VIEW results; CREATE VIEW results AS WITH RECURSIVE n(point) AS (SELECT 1 UNION ALL SELECT point + 1 "
              "FROM n) SELECT point, 1 AS status FROM n",
              "ALTER TABLE points RENAME COLUMN note TO notes",
              "CREATE TRIGGER t AFTER INSERT ON runs BEGIN DELETE FROM runs; END",
              "UPDATE runs SET report = zeroblob(300000000) WHERE id IN (SELECT run FROM points)",
              "UPDATE runs SET report = 'abc'",
              "UPDATE runs SET settings = '{' || id", "UPDATE runs SET settings = '[' || id || ']'",
              "UPDATE runs SET settings = '{\"composer.buffer_pixels\": ' || id || '}'",
              "UPDATE points SET note = zeroblob(300000000) WHERE rowid = (SELECT min(rowid) FROM points)",
              "UPDATE axes SET key = x'ff00'",
              "UPDATE points SET status = 7, run = 'x', smallest = 'y', runs = x'00'")

    def test_damaged_content_is_reported_by_whatever_reads_it(self):
        size = ["size", "scenario.yaml", "--minimize", "composer.buffer_pixels=1..64", "--over", "bus.width_bits=64,128",
                "--out", "r.db", "--quiet"]
        self.assertEqual(self.run_program(*size).returncode, DONE)
        shutil.copy(self.folder / "r.db", self.folder / "good.db")
        for damage in self.DAMAGE:
            shutil.copy(self.folder / "good.db", self.folder / "r.db")
            database = sqlite3.connect(self.folder / "r.db")
            database.executescript(damage)
            database.commit()
            database.close()
            reported = 0
            for words in (["export", "r.db"], ["report", "r.db", "-o", "r.html"], size,
                          ["plot", "r.db", "--x", "smallest", "--y", "runs", "-o", "r.svg"]):
                with self.subTest(f"{words[0]}: {damage}"):
                    done = self.run_program(*words, preexec_fn=limits(RLIMIT_CPU=30))
                    if done.returncode == DONE:
                        continue  # it does not read what is damaged
                    self.check_line(done, "r.db")
                    reported += 1
            with self.subTest(damage):
                self.assertGreater(reported, 0)

    def test_a_file_system_without_locks_is_read_and_written_to_by_merge_alone(self):
        self.write("sweep.yaml", "scenario: scenario.yaml\naxes: [{key: bus.width_bits, values: [64, 128]}]\n")
        for error in (errno.ENOLCK, errno.ENOSYS, errno.EOPNOTSUPP):
            system = {**os.environ, "LD_PRELOAD": str(MODULES / "libmissing_locks.so"), "MISSING_LOCKS": str(error)}
            shutil.rmtree(self.folder / "unlocked", ignore_errors=True)
            for words in ("sweep sweep.yaml --shard 1/1 --parts unlocked/parts --quiet", "merge unlocked/parts -o unlocked/r.db",
                          "export unlocked/r.db -o unlocked/r.csv", "export unlocked/parts", "report unlocked/r.db -o r.html"):
                with self.subTest(words, error=error):
                    done = self.run_program(*words.split(), env=system)
                    self.assertEqual((done.returncode, done.stderr), (DONE, b""))
            self.assertEqual(len((self.folder / "unlocked/r.csv").read_text().splitlines()), 3)
            with self.subTest("sweep -o", error=error):
                done = self.run_program("sweep", "sweep.yaml", "-o", "unlocked/new.db", "--quiet", env=system)
                self.check_line(done, "unlocked/new.db", "file system without locks", "--parts")
                self.assertFalse((self.folder / "unlocked/new.db").exists())
            # What only its journal has is not in the file, and cannot be read without locks.
            self.write("unlocked/r.db-wal", b"changes")
            with self.subTest("unfinished", error=error):
                done = self.run_program("export", "unlocked/r.db", env=system)
                self.check_line(done, "unlocked/r.db", "file system without locks", "local disk")

    def test_files_have_the_permissions_that_the_umask_leaves(self):
        self.write("sweep.yaml", "scenario: scenario.yaml\naxes: [{key: bus.width_bits, values: [64, 128]}]\n")
        before = set(self.folder.rglob("*"))
        for words in ("run scenario.yaml --out out/run --level rtl --trace t.vcd --quiet", "run scenario.yaml --trace t.json --quiet",
                      "view scenario.yaml -o v.html --quiet", "sweep sweep.yaml -o sweep/r.db --quiet",
                      "sweep sweep.yaml --shard 1/1 --parts parts --quiet", "merge parts -o m.db",
                      "size scenario.yaml --minimize composer.buffer_pixels=1..8 -o size.db --quiet",
                      "export m.db -o t.csv", "report m.db -o r.html"):
            self.assertEqual(self.run_program(*words.split(), umask=0).returncode, DONE, words)
        made = set(self.folder.rglob("*")) - before
        self.assertGreater(len(made), 12)
        for path in made:
            self.assertEqual(path.stat().st_mode & 0o777, 0o777 if path.is_dir() else 0o666, path)

    def test_no_spreadsheet_takes_a_text_for_a_formula(self):
        self.run_program("size", "scenario.yaml", "--minimize", "composer.buffer_pixels=1..64", "--out", "r.db")
        database = sqlite3.connect(self.folder / "r.db")
        for note in ("=1+1", "+1", "-1", "@a", "\t=1"):
            with self.subTest(note):
                database.execute("UPDATE points SET note = ?, smallest = -5", (note,))
                database.commit()
                done = self.run_program("export", "r.db", "--columns", "note, smallest")
                self.assertEqual(done.stdout.decode().splitlines()[1], f"'{note},-5")
        database.close()


class Locale(Hostile):
    """Numbers are written and read in one way, whatever the user's language does."""

    def test_a_decimal_comma_changes_nothing(self):
        (self.folder / "locales").mkdir()
        built = subprocess.run(["localedef", "-f", "UTF-8", "-i", "de_DE", self.folder / "locales/de_DE.UTF-8"],
                               stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False)
        self.assertTrue((self.folder / "locales/de_DE.UTF-8").is_dir(), built.stdout)
        german = dict(os.environ, LOCPATH=str(self.folder / "locales"), LC_ALL="de_DE.UTF-8", LANG="de_DE.UTF-8")
        comma = subprocess.run(["printf", "%.1f", "1,5"], env=german, stdout=subprocess.PIPE, check=True).stdout
        self.assertEqual(comma, b"1,5")  # the locale is in force
        results = {}
        for name, environment in (("plain", dict(os.environ, LC_ALL="C")), ("german", german)):
            for words in (["run", "scenario.yaml", "--set", "clocks.core_mhz=99.5", "--out", "out", "--quiet"],
                          ["analyze", "scenario.yaml", "--frame-rate-hz", "59.94", "--json"],
                          ["size", "scenario.yaml", "--minimize", "composer.buffer_pixels=1..64", "--out", name + ".db",
                           "--time-limit", "12.5", "--quiet"],
                          ["export", name + ".db", "--columns", "frames_per_second, smallest"]):
                done = self.run_program(*words, env=environment)
                self.assertEqual(done.returncode, DONE, done.stderr)
                results.setdefault(name, []).append(done.stdout)
            results[name].append(self.snapshot("out"))
            shutil.rmtree(self.folder / "out")
        self.assertEqual(results["plain"], results["german"])


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
