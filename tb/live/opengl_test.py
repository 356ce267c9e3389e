"""Tests metabuffer-gl with programs of Debian as they are, under Xvfb with Mesa's software renderer: what they draw is on
the wall, and the recorded wall runs again.

usage: opengl_test.py, with METABUFFER_PROGRAM, METABUFFER_GL, METABUFFER_SOURCE in the environment
"""

import json
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time
import unittest

PROGRAM, GL = os.environ["METABUFFER_PROGRAM"], os.environ["METABUFFER_GL"]
SCENARIO = pathlib.Path(os.environ["METABUFFER_SOURCE"]) / "scenarios/live/four-programs.yaml"
SDL_TESTS = "/usr/libexec/installed-tests/SDL2"
PATIENCE_SECONDS = 120
# By link: its viewport and the program. They find the functions of GLX and EGL by symbol, by eglGetProcAddress and by dlsym.
PROGRAMS = {"gears": ("10,20,1", ["glxgears", "-geometry", "300x300"]),
            "es gears": ("150,130,1", ["es2gears_x11"]),
            "horse": ("320,0,1", ["glmark2-es2", "-b", "build:duration=1000", "-s", "320x240"]),
            "cube": ("300,220,1", [f"{SDL_TESTS}/testgl2", "--geometry", "320x240"])}


class OpenGl(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.folder = pathlib.Path(scratch.name).resolve()
        read, write = os.pipe()
        self.start(["Xvfb", "-displayfd", str(write), "-screen", "0", "1280x1024x24"], pass_fds=[write], stderr=subprocess.DEVNULL)
        os.close(write)
        with os.fdopen(read) as number:
            display = ":" + number.readline().strip()
        self.environment = dict(os.environ, DISPLAY=display, LIBGL_ALWAYS_SOFTWARE="1")

    def start(self, words, **options):
        process = subprocess.Popen(words, text=True, start_new_session=True, **options)
        self.addCleanup(process.wait)
        self.addCleanup(self.end, process)
        return process

    def end(self, process):
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)

    def wall(self, *words, scenario=SCENARIO):
        wall = self.start([PROGRAM, "live", scenario, "--no-window", "--socket", "wall.sock", "--out", "out", *words],
                          cwd=self.folder, stderr=subprocess.PIPE)
        self.addCleanup(wall.stderr.close)
        end = time.monotonic() + PATIENCE_SECONDS
        while not (self.folder / "wall.sock").exists():
            self.assertLess(time.monotonic(), end)
            time.sleep(0.01)
        return wall

    def program(self, link, viewport, words):
        return self.start([GL, "--socket", "wall.sock", "--link", link, "--viewport", viewport, "--", *words], cwd=self.folder,
                          env=self.environment, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)

    def test_four_programs_on_one_wall(self):
        wall = self.wall("--frames", "8", "--record", "record", "--wait", str(PATIENCE_SECONDS))
        programs = [self.program(link, viewport, words) for link, (viewport, words) in PROGRAMS.items()]
        text = wall.communicate(timeout=PATIENCE_SECONDS)[1]
        self.assertEqual(wall.returncode, 0, text)
        for program in programs:
            self.end(program)
            program.communicate()
        report = json.loads((self.folder / "out/report.json").read_text())
        self.assertEqual([renderer["repeated_frames"] for renderer in report["renderers"]], [0] * len(PROGRAMS))
        subprocess.run([PROGRAM, "run", "record/scenario.yaml", "--out", "again", "--quiet", "--pictures", "last"],
                       cwd=self.folder, check=True)
        self.assertEqual(json.loads((self.folder / "again/report.json").read_text()), report)
        pictures = self.collage("out")
        self.assertEqual(self.collage("again"), pictures)
        # Each of them is to be seen: without its table the wall is another one.
        for index, link in enumerate(PROGRAMS):
            with self.subTest(link):
                subprocess.run([PROGRAM, "run", "record/scenario.yaml", "--out", "without", "--quiet", "--pictures", "last",
                                "--set", f"renderers[{index}].frames[7].table=[]"], cwd=self.folder, check=True)
                self.assertNotEqual(self.collage("without"), pictures)
        if kept := os.environ.get("METABUFFER_PICTURE"):
            pathlib.Path(kept).write_bytes(pictures)

    def collage(self, folder):
        return (self.folder / folder / "collage.png").read_bytes()

    def test_state_of_the_context_stays(self):
        (self.folder / "one.yaml").write_text(json.dumps({
            "displays": {"width": 64, "height": 48}, "renderers": [{"name": "state", "live": {"width": 64, "height": 48}}]}))
        wall = self.wall("--stream", "wall.rgb", scenario="one.yaml")
        program = self.program("state", "0,0,1", [sys.executable, pathlib.Path(__file__).with_name("opengl_state.py"), "64", "48"])
        self.assertEqual(program.communicate(timeout=PATIENCE_SECONDS)[1], "")
        self.assertEqual(program.returncode, 0)
        text = wall.communicate(timeout=PATIENCE_SECONDS)[1]
        self.assertEqual(wall.returncode, 0, text)
        # What the program drew to its window, and not what its framebuffer holds.
        self.assertEqual((self.folder / "wall.rgb").read_bytes(), bytes((51, 102, 204)) * (64 * 48 * 2))

    def test_a_window_of_another_size(self):
        self.wall()
        program = self.program("gears", "0,0,1", ["glxgears", "-geometry", "200x100"])
        self.assertEqual(program.stderr.readline(),
                         "metabuffer-gl: the window has 200x100 pixels and the link 300x300; no picture is taken until they "
                         "are the same\n")
        program.stderr.close()

    def test_an_unknown_link(self):
        self.wall()
        program = self.program("nobody", "0,0,1", ["glxgears"])
        self.assertIn("'nobody' is not a live renderer", program.stderr.readline())
        program.stderr.close()


if __name__ == "__main__":
    unittest.main()
