"""Tests `metabuffer live` with applications: in C (draw.c), in Python by the library's shared object, and ones that break
the protocol.

usage: live_test.py [TEST...], with METABUFFER_PROGRAM, METABUFFER_HOST_LIBRARY, METABUFFER_DRAW and
METABUFFER_GL in the environment
"""

import ctypes
import json
import os
import pathlib
import random
import signal
import socket
import stat
import struct
import subprocess
import tempfile
import time
import unittest

PROGRAM = os.environ["METABUFFER_PROGRAM"]
DRAW = os.environ["METABUFFER_DRAW"]
GL = os.environ["METABUFFER_GL"]
LIBRARY = ctypes.CDLL(os.environ["METABUFFER_HOST_LIBRARY"])
LEVELS = ("tlm", "rtl", "functional")
WIDTH, HEIGHT = 20, 9
MACHINE = {"name": "small", "displays": {"columns": 2, "rows": 1, "width": 24, "height": 12},
           "composer": {"ready_space_pixels": 4}, "bus": {"burst_pixels": 4},
           "renderers": [{"name": name, "live": {"width": WIDTH, "height": HEIGHT}} for name in ("left", "right")]}
PATIENCE_SECONDS = 60
# Of application/live_protocol.h.
MAGIC, VERSION, NAME_BYTES = 0x564C424D, 1, 128
REFUSED, ENDED = 11, 12
ANY_DEPTH, A8Z16, Z24 = -1, 0, 1


class Row(ctypes.Structure):
    _fields_ = [(name, ctypes.c_uint16) for name in ("dcomp", "sx", "sy", "sdx", "sdy")] + [
        ("dx", ctypes.c_int16), ("dy", ctypes.c_int16), ("dmultiple", ctypes.c_uint16)]


class Pair(ctypes.Structure):
    _fields_ = [("colour", ctypes.POINTER(ctypes.c_uint32)), ("depth", ctypes.POINTER(ctypes.c_uint32)),
                ("frame_number", ctypes.c_uint32), ("index", ctypes.c_uint32)]


LIBRARY.metabuffer_link_message.restype = ctypes.c_char_p
LIBRARY.metabuffer_link_message.argtypes = [ctypes.c_void_p]
LIBRARY.metabuffer_close_link.argtypes = [ctypes.c_void_p]
LIBRARY.metabuffer_submit_pair.argtypes = [ctypes.c_void_p, ctypes.POINTER(Pair)]
LIBRARY.metabuffer_begin_pair.argtypes = [ctypes.c_void_p, ctypes.c_int, ctypes.POINTER(Pair)]
LIBRARY.metabuffer_write_controls.argtypes = [ctypes.c_void_p, ctypes.POINTER(Pair), ctypes.POINTER(Row), ctypes.c_size_t]
LIBRARY.metabuffer_open_link.argtypes = [ctypes.c_char_p, ctypes.c_char_p, ctypes.c_int32, ctypes.c_int32, ctypes.c_int, ctypes.c_int,
                                         ctypes.POINTER(ctypes.c_void_p)]


class Refused(Exception):
    pass


class Link:
    """The library's link, from Python."""

    def __init__(self, path, name, width=0, height=0, depth_format=ANY_DEPTH):
        self.link = ctypes.c_void_p()
        status = LIBRARY.metabuffer_open_link(str(path).encode(), name.encode(), width, height, depth_format, 20_000,
                                              ctypes.byref(self.link))
        if status:
            message = (LIBRARY.metabuffer_link_message(self.link) or b"").decode()
            self.close()
            raise Refused(status, message)

    def begin(self):
        pair = Pair()
        status = LIBRARY.metabuffer_begin_pair(self.link, 20_000, ctypes.byref(pair))
        if status:
            raise Refused(status, "")
        return pair

    def write_controls(self, pair, rows=((1, 0, 0, WIDTH, HEIGHT, 1, 1, 1),)):
        array = (Row * len(rows))(*(Row(*row) for row in rows))
        if LIBRARY.metabuffer_write_controls(self.link, ctypes.byref(pair), array, len(rows)):
            raise ValueError("these rows cannot be written")

    def draw(self, pair, colour):
        for pixel in range(WIDTH, WIDTH * (HEIGHT + 1)):
            pair.colour[pixel] = colour
            pair.depth[pixel] = 0xFF0000 | pixel
        self.write_controls(pair)

    def submit(self, pair):
        return LIBRARY.metabuffer_submit_pair(self.link, ctypes.byref(pair))

    def close(self):
        LIBRARY.metabuffer_close_link(self.link)
        self.link = ctypes.c_void_p()


class Wall(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.folder = pathlib.Path(scratch.name).resolve()
        self.socket = self.folder / "wall.sock"

    def start(self, *words, socket=True, environment=None, **keys):
        """Starts a wall; it listens when this returns. socket: whether its path is on the command line."""
        (self.folder / "scenario.yaml").write_text(json.dumps({**MACHINE, **keys}))
        said = (self.folder / "said.txt").open("w")  # not a pipe, which would fill up
        self.addCleanup(said.close)
        self.wall = subprocess.Popen(
            [PROGRAM, "live", "scenario.yaml", "--no-window", *(["--socket", self.socket] if socket else []), "--out", "out",
             *map(str, words)], cwd=self.folder, env=environment, stderr=said,
            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL))
        self.addCleanup(self.wall.wait)
        self.addCleanup(self.wall.kill)
        self.wait_until(lambda: "waiting for applications at" in (self.folder / "said.txt").read_text())

    def wait_until(self, condition):
        end = time.monotonic() + PATIENCE_SECONDS
        while not condition():
            self.assertLess(time.monotonic(), end)
            time.sleep(0.002)

    def draw(self, link, pairs, viewport="1,1,1", tint=0, milliseconds=0):
        drawing = subprocess.Popen([DRAW, self.socket, link, str(pairs), viewport, str(tint), str(milliseconds)],
                                   text=True, stderr=subprocess.PIPE)
        self.addCleanup(drawing.stderr.close)
        self.addCleanup(drawing.wait)
        self.addCleanup(drawing.kill)
        return drawing

    def finish(self, status=0):
        """Returns what the wall has said, line by line."""
        self.wall.wait(timeout=PATIENCE_SECONDS)
        text = (self.folder / "said.txt").read_text()
        self.assertEqual(self.wall.returncode, status, text)
        self.assertFalse(self.socket.exists())
        return text.splitlines()

    def report(self, folder="out"):
        return json.loads((self.folder / folder / "report.json").read_text())

    def pictures(self, folder):
        return {path.name: path.read_bytes() for path in (self.folder / folder).glob("*.png")}

    def run_recorded(self, level, *words):
        out = f"run_{level}"
        subprocess.run([PROGRAM, "run", "record/scenario.yaml", "--level", level, "--out", out, "--quiet", "--pictures", "last",
                        *words], cwd=self.folder, check=True)
        return self.report(out)

    def check_recorded(self, level):
        """The recorded scenario gives the same report and pictures at the same level."""
        self.assertEqual(self.run_recorded(level), self.report())
        self.assertEqual(self.pictures(f"run_{level}"), self.pictures("out"))


class Recording(Wall):
    def test_what_was_recorded_runs_again(self):
        for level in LEVELS:
            with self.subTest(level):
                self.start("--level", level, "--record", "record")
                self.draw("left", 5, "3,1,1", 40)
                self.draw("right", 5, "10,2,2", 90)
                self.finish()
                self.assertEqual(self.report()["displays"][0]["frames_shown"], 5)
                self.check_recorded(level)
        # Both levels that have time were given the same pairs.
        self.assertEqual({**self.run_recorded("tlm"), "level": ""}, {**self.report("run_rtl"), "level": ""})

    def test_a_recorded_wall_keeps_every_rule(self):
        self.start("--record", "record")
        self.draw("left", 3)
        self.draw("right", 3, "20,4,1")
        self.finish()
        self.run_recorded("rtl", "--check")

    def test_free_running_links(self):
        for level in ("tlm", "rtl"):
            with self.subTest(level):
                self.start("--level", level, "--record", "record", pacing="free-running")
                self.draw("left", 12, milliseconds=1)
                self.draw("right", 9, "10,2,2", 90, 2)
                self.finish()
                self.check_recorded(level)
        self.run_recorded("rtl", "--check")

    def test_frames_end_the_wall(self):
        self.start("--frames", 4, "--record", "record")
        drawings = [self.draw("left", 1000), self.draw("right", 1000)]
        self.finish()
        self.assertEqual(self.report()["displays"][1]["frames_shown"], 4)
        self.check_recorded("tlm")
        for drawing in drawings:
            self.assertEqual(drawing.communicate(timeout=PATIENCE_SECONDS)[1], "draw: the wall has ended\n")

    def test_ctrl_c_ends_the_wall_with_a_whole_report(self):
        for level in LEVELS:
            with self.subTest(level):
                self.start("--level", level, "--record", "record")
                drawings = [self.draw(link, 100_000, milliseconds=20) for link in ("left", "right")]
                time.sleep(0.5)  # some frames
                self.assertEqual([drawing.poll() for drawing in drawings], [None, None])
                self.wall.send_signal(signal.SIGINT)
                self.finish()
                self.check_recorded(level)

    def test_ctrl_c_ends_free_running_links_that_show_nothing(self):
        self.start("--pictures", "none", pacing="free-running")
        drawings = [self.draw(link, 100_000, milliseconds=1) for link in ("left", "right")]
        time.sleep(0.5)  # some frames
        self.assertEqual([drawing.poll() for drawing in drawings], [None, None])
        self.wall.send_signal(signal.SIGINT)
        self.finish()
        report = self.report()
        self.assertEqual([display["frames_shown"] for display in report["displays"]], [len(report["frames"])] * 2)
        self.assertGreater(len(report["frames"]), 8)

    def test_the_wall_as_raw_video(self):
        self.start("--frames", 3, "--stream", "wall.rgb")
        self.draw("left", 3, "1,1,1", 77)
        self.draw("right", 3, "30,1,1")
        self.finish()
        video = (self.folder / "wall.rgb").read_bytes()
        width, height = 2 * 24, 12
        self.assertEqual(len(video), 3 * width * height * 3)
        for frame in range(3):
            pixel = ((frame * height + 1) * width + 1) * 3
            self.assertEqual(tuple(video[pixel:pixel + 3]), (29 * frame % 256, 29 * frame // 256, 77))

    def test_pictures_of_every_frame(self):
        self.start("--frames", 3, "--pictures", "all")
        for name in ("left", "right"):
            self.draw(name, 3)
        self.finish()
        self.assertEqual(sorted(self.pictures("out")), ["collage.png", *sorted(
            f"display_{display}{frame}.png" for display in (1, 2) for frame in ("", ".0000", ".0001", ".0002"))])

    def test_a_wall_that_shows_nothing(self):
        """It counts only, as run --pictures none does, and what it records has its pixels all the same."""
        self.start("--pictures", "none", "--record", "record")
        for name in ("left", "right"):
            self.draw(name, 3)
        self.finish()
        self.assertEqual(self.pictures("out"), {})
        subprocess.run([PROGRAM, "run", "record/scenario.yaml", "--out", "none", "--quiet", "--pictures", "none"], cwd=self.folder,
                       check=True)
        self.assertEqual(self.report("none"), self.report())
        self.run_recorded("tlm")
        self.assertIn("collage.png", self.pictures("run_tlm"))

    def test_real_time(self):
        """A free-running link begins pair k no sooner than k pair times after the start."""
        frames, pair_seconds = 3, 0.2
        begun = time.monotonic()
        self.start("--frames", frames, "--real-time", pacing="free-running", clocks={"dvi_in_refresh_hz": 2 / pair_seconds})
        drawing = self.draw("left", 1000, milliseconds=1)
        self.finish()
        self.assertGreaterEqual(time.monotonic() - begun, (frames - 1) * pair_seconds)
        drawing.wait()

    def test_memory_is_given_back(self):
        """A wall without --record that has shown many large pictures holds a few of them."""
        width, height, pairs, pixel_bytes = 400, 300, 200, 8
        self.start(displays={"width": 400, "height": 300}, renderers=[{"name": "left", "live": {"width": width, "height": height}}])
        steady = self.draw("left", pairs)
        peak = 0
        while steady.poll() is None:
            status = pathlib.Path(f"/proc/{self.wall.pid}/status").read_text()
            peak = max([peak, *(int(line.split()[1]) for line in status.splitlines() if line.startswith("VmRSS"))])
        self.finish()
        self.assertLess(peak * 1024, pairs / 2 * width * height * pixel_bytes)

    def test_metabuffer_gl_finds_the_wall(self):
        folder = dict(os.environ, XDG_RUNTIME_DIR=str(self.folder))
        self.socket = self.folder / "metabuffer-small.sock"
        self.start(socket=False, environment=folder)
        for words in ([], ["--wall", "small"], ["--socket", self.socket]):
            done = subprocess.run([GL, *words, "--link", "left", "--viewport", "-3,0,2", "--", "env"], env=folder, text=True,
                                  stdout=subprocess.PIPE, check=True)
            told = dict(line.split("=", 1) for line in done.stdout.splitlines() if line.startswith("METABUFFER_GL_"))
            self.assertEqual(told, {"METABUFFER_GL_SOCKET": str(self.socket), "METABUFFER_GL_LINK": "left",
                                    "METABUFFER_GL_VIEWPORT": "-3,0,2"})
        for words, line in (([], "--link is missing"), (["--link", "a"], "--viewport is missing"),
                            (["--link", "a", "--viewport", "1,2"], "--viewport '1,2' is not X,Y,MULTIPLE"),
                            (["--link", "a", "--viewport", "1,2,3"], "there is no program after --"),
                            (["--link"], "--link has no value"), (["ls"], "'ls' is not an option; put the program after --")):
            done = subprocess.run([GL, *words], env=folder, text=True, stderr=subprocess.PIPE, check=False)
            self.assertEqual((done.returncode, done.stderr), (2, f"metabuffer-gl: {line}; see metabuffer-gl --help\n"))

    def test_one_application_draws_more_than_the_other(self):
        for level in ("tlm", "functional"):
            with self.subTest(level):
                self.start("--level", level, "--record", "record")
                self.draw("left", 2)
                self.draw("right", 8)
                self.finish()
                report = self.report()
                self.assertEqual(report["displays"][0]["frames_shown"], 8)
                self.assertEqual([renderer["repeated_frames"] for renderer in report["renderers"]], [6, 0])
                self.check_recorded(level)

    def test_a_late_pair_is_missing(self):
        self.start("--record", "record", "--wait", "0.3")
        self.draw("right", 3)
        slow = Link(self.socket, "left")
        pair = slow.begin()
        time.sleep(1.0)  # its numbers are over
        slow.draw(pair, 0x112233)
        slow.submit(pair)
        slow.close()
        self.finish()
        self.assertGreater(self.report()["renderers"][0]["repeated_frames"], 0)
        self.check_recorded("tlm")

    def test_another_application_may_come(self):
        self.start("--record", "record")
        steady = Link(self.socket, "right")
        for colour in (0x10, 0x20):
            guest = self.next_guest("left")
            for link in (guest, steady):
                pair = link.begin()
                link.draw(pair, colour)
                link.submit(pair)
            guest.close()
            for _ in range(2):
                pair = steady.begin()
                steady.draw(pair, colour)
                steady.submit(pair)
        steady.close()
        lines = self.finish()
        self.assertEqual(sum("an application has come" in line for line in lines), 3)
        self.check_recorded("tlm")

    def next_guest(self, name):
        """Opens the link once the wall has seen that its application has gone."""
        end = time.monotonic() + PATIENCE_SECONDS
        while True:
            try:
                return Link(self.socket, name)
            except Refused as refused:
                self.assertIn("has an application already", refused.args[1])
                self.assertLess(time.monotonic(), end)


class Rules(Wall):
    """The machine's rules judge what an application writes."""

    def test_a_control_scanline_without_magic_is_rejected(self):
        self.start("--record", "record")
        good, bad = Link(self.socket, "left"), Link(self.socket, "right")
        for number in range(4):
            for link in (good, bad):
                pair = link.begin()
                link.draw(pair, 0x445566)
                if link is bad and number == 2:
                    pair.colour[0] ^= 0x010000
                link.submit(pair)
        good.close()
        bad.close()
        self.finish()
        self.assertEqual(self.report()["renderers"][1]["rejected_frames"]["magic"], 1)
        self.assertEqual(self.report()["renderers"][1]["repeated_frames"], 1)
        for level in ("tlm", "rtl", "functional"):
            self.run_recorded(level)
        self.check_recorded("tlm")

    def test_a_wrong_row_is_rejected(self):
        self.start("--record", "record")
        links = [Link(self.socket, name) for name in ("left", "right")]
        for link in links:
            pair = link.begin()
            link.draw(pair, 0x445566)
            link.write_controls(pair, [(1, 0, 0, WIDTH, HEIGHT, 1, 1, 1), (7, 0, 0, 1, 1, 0, 0, 1)])
            link.submit(pair)
        for link in links:
            link.close()
        self.finish()
        self.assertEqual(sum(self.report()["renderers"][0]["rejected_rows"].values()), 1)
        self.check_recorded("tlm")


class Protocol(Wall):
    """An application that does not keep to the protocol is cut off with one line, and the others go on."""

    def raw(self, data=b""):
        raw = socket.socket(socket.AF_UNIX)
        self.addCleanup(raw.close)
        raw.connect(str(self.socket))
        raw.sendall(data)
        return raw

    def hello(self, name="left", magic=MAGIC, version=VERSION):
        return struct.pack(f"<II{NAME_BYTES}siii", magic, version, name.encode(), 0, 0, ANY_DEPTH)

    def check_others(self, *expected):
        """The right link works; and left, whose application did something wrong before."""
        for name in ("left", "right"):
            self.draw(name, 3)
        lines = self.finish()
        for line in expected:
            self.assertEqual(sum(line in each for each in lines), 1, lines)

    def test_the_socket_is_this_users_alone(self):
        self.start()
        self.assertEqual(stat.S_IMODE(self.socket.stat().st_mode), 0o600)
        self.check_others()

    def test_who_is_refused(self):
        self.start()
        for name, width, height, depth_format, line in (
                ("middle", 0, 0, A8Z16, "'middle' is not a live renderer; use 'left' or 'right'"),
                ("left", WIDTH + 1, HEIGHT, A8Z16, f"'left' has images of {WIDTH}x{HEIGHT} pixels, not {WIDTH + 1}x{HEIGHT}; "
                                                   "use the size of its key live"),
                ("left", 0, 0, Z24, "'left' has depths of format a8z16; use that one"),
                ("left", 0, 0, 7, "'left' has depths of format a8z16; use that one")):
            with self.assertRaises(Refused) as refused:
                Link(self.socket, name, width, height, depth_format)
            self.assertEqual(refused.exception.args, (REFUSED, line))
        link = Link(self.socket, "left", WIDTH, HEIGHT, A8Z16)
        with self.assertRaises(Refused) as refused:
            Link(self.socket, "left")
        self.assertEqual(refused.exception.args, (REFUSED, "'left' has an application already; use another renderer"))
        link.close()
        self.wait_until(lambda: self.comes_through("left"))
        self.check_others("refused an application: 'middle' is not", "has an application already")

    def comes_through(self, name):
        try:
            Link(self.socket, name).close()
            return True
        except Refused:
            return False

    def test_another_version(self):
        self.start()
        self.raw(self.hello(version=VERSION + 1))
        self.raw(self.hello(magic=0x12345678))
        self.check_others("speaks version 2 of the protocol; use version 1", "does not speak the protocol")

    def test_garbage_before_and_after_the_hello(self):
        self.start("--wait", "1")
        generator = random.Random(7)
        for _ in range(20):
            self.raw(generator.randbytes(generator.randrange(1, 600)))
        liar = self.raw(self.hello())
        self.wait_until(lambda: liar.recv(4))
        liar.sendall(generator.randbytes(64))
        self.wait_until(lambda: self.is_closed(liar))
        self.check_others("'left': its application submits a pair that it was not granted, and is cut off")

    def is_closed(self, raw):
        raw.settimeout(0.1)
        try:
            return raw.recv(4096) == b""
        except TimeoutError:
            return False
        except ConnectionResetError:
            return True

    def test_a_number_that_is_another_pairs(self):
        self.start("--wait", "1")
        link = Link(self.socket, "left")
        pair = link.begin()
        link.draw(pair, 1)
        number = Pair(pair.colour, pair.depth, 77, pair.index)
        link.write_controls(number)
        link.submit(pair)
        with self.assertRaises(Refused) as ended:
            for _ in range(5):
                link.submit(link.begin())
        self.assertEqual(ended.exception.args[0], ENDED)
        link.close()
        self.check_others("'left': its application numbers a pair 77 instead of 0, and is cut off")

    def test_the_memory_is_sealed(self):
        self.start("--wait", "1")
        raw = self.raw(self.hello())
        self.wait_until(lambda: True)
        data, descriptors, _, _ = socket.recv_fds(raw, 4096, 1)
        self.assertEqual(len(descriptors), 1)
        for size in (0, 1 << 20):
            with self.assertRaises(PermissionError):
                os.ftruncate(descriptors[0], size)
        os.close(descriptors[0])
        raw.close()
        self.check_others()

    def test_an_application_that_does_not_read(self):
        self.start("--wait", "0.2", "--frames", "6")
        self.raw(self.hello("left"))
        self.draw("right", 6)
        self.finish()
        self.assertEqual(self.report()["renderers"][0]["repeated_frames"], 6)

    def test_nothing_ever_comes(self):
        self.start()
        time.sleep(0.3)
        self.wall.send_signal(signal.SIGINT)
        lines = self.finish(2)
        self.assertIn("no application has sent a pair", lines[-1])
        self.assertFalse((self.folder / "out").exists())

    def test_two_walls_at_one_socket(self):
        self.start()
        second = subprocess.run([PROGRAM, "live", "scenario.yaml", "--no-window", "--socket", self.socket, "--out", "other"],
                                cwd=self.folder, text=True, stderr=subprocess.PIPE, check=False)
        self.assertEqual(second.returncode, 2)
        self.assertEqual(second.stderr, f"{self.socket}: cannot be listened at: another wall listens there; use another "
                                        "--socket\n")
        self.check_others()

    def test_where_a_wall_cannot_listen(self):
        (self.folder / "scenario.yaml").write_text(json.dumps(MACHINE))
        (self.folder / "file").touch()
        for path, why in (("file", "a file of that name is there"), ("none/wall.sock", "No such file or directory"),
                          ("x" * 107, "its path is longer than 106 bytes")):
            done = subprocess.run([PROGRAM, "live", "scenario.yaml", "--no-window", "--socket", path], cwd=self.folder,
                                  text=True, stderr=subprocess.PIPE, check=False)
            self.assertEqual((done.returncode, done.stderr), (2, f"{path}: cannot be listened at: {why}; use another --socket\n"))
        self.assertEqual(sorted(path.name for path in self.folder.iterdir()), ["file", "scenario.yaml"])

    def test_a_socket_that_a_killed_wall_has_left(self):
        self.start()
        self.wall.kill()
        self.wall.wait()
        self.assertTrue(self.socket.exists())
        self.start()
        self.check_others()

    def test_other_commands_refuse_a_live_renderer(self):
        (self.folder / "scenario.yaml").write_text(json.dumps(MACHINE))
        for command in (["run"], ["size"], ["analyze"], ["compare"]):
            words = [*command, "scenario.yaml"] + (["--minimize", "bus.width_bits"] if command == ["size"] else [])
            done = subprocess.run([PROGRAM, *words], cwd=self.folder, text=True, capture_output=True, check=False)
            self.assertEqual((done.returncode, done.stdout), (2, ""))
            self.assertEqual(done.stderr, "scenario.yaml:1: renderers[0].live: gets its images from an application; use "
                                          "metabuffer live, or frames with images\n")


class Deaths(Wall):
    def test_applications_that_are_killed_at_any_moment(self):
        kills = int(os.environ.get("METABUFFER_KILLS", "1000"))
        seed = int(os.environ.get("METABUFFER_SEED", "1"))
        print(f"METABUFFER_SEED={seed}")
        generator = random.Random(seed)
        self.start("--wait", "0.05")
        right = self.draw("right", 10_000_000)
        self.wait_until(self.holdings)
        before = self.holdings()
        for _ in range(kills):
            left = self.draw("left", 10_000_000)
            time.sleep(generator.uniform(0.0, 0.03))
            left.kill()
            left.communicate()
            self.assertIsNone(self.wall.poll())
            self.assertIsNone(right.poll())
        self.wait_until(lambda: self.holdings() == before)
        self.wall.send_signal(signal.SIGINT)
        lines = self.finish()
        came = sum("'left': an application has come" in line for line in lines)
        self.assertGreater(came, kills // 4)
        self.assertEqual(came, sum("'left': its application has gone" in line for line in lines))

    def holdings(self):
        """Descriptors and shared memories of the wall, while the right application is there and nobody else."""
        process = pathlib.Path(f"/proc/{self.wall.pid}")
        rings = process.joinpath("maps").read_text().count("metabuffer-link")
        return (len(list(process.joinpath("fd").iterdir())), rings) if rings == 1 else None


if __name__ == "__main__":
    unittest.main()
