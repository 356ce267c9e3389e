#!/usr/bin/env python3
"""The page of one run as a reader meets it: made by the program, shown by headless Chromium.

What the page says of pixels, clocks and buses is compared with pictures, report.json and waveforms of level rtl. Needs
Chromium, its driver and Selenium; --keep DIR leaves pages and screenshots there.
"""

import concurrent.futures
import json
import random
import re
import shlex
import struct
import subprocess
import zlib

from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.actions.wheel_input import ScrollOrigin
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.ui import Select

from page_browser import HOSTILE, HOSTILE_RENDERER, PageTest, main, options, run

COMPOSITIONS = ("z", "z-alpha-key", "over")
# Composition, raster pixels per shown one and axis.
SCENES = (("z", 1), ("z-alpha-key", 1), ("over", 1), ("z", 2), ("over", 2))
COLUMNS, WIDTH, HEIGHT = 2, 40, 30  # of the machines below: displays side by side, shown pixels of each
FRAMES = 3
BACKGROUND = (9, 7, 8)  # its blue says renderer 0, which does not exist
HOSTILE_SCENARIO = "<script>window.hostile = 3<!--<script>\"'&<b>"  # which must not become a path
GAP = 6  # shown pixels that the page leaves between two displays
YELLOW = 0xFFD400

# The pixels of a display that the page believes to be shown, those of its picture, and the winners.
COLOURS = """
const [frame, display, done] = arguments, run = metabufferRun;
(async () => {
    const entry = run.data.frames.find(one => one.frame === frame);
    if (!await run.loadImages(entry)) return null;
    const {width, height, supersample} = run.machine, samples = supersample * supersample, computed = [];
    for (let n = 0; n < width * height; ++n) {
        // The mean of the shown pixel's raster pixels.
        const sums = [0, 0, 0], left = n % width * supersample, top = Math.floor(n / width) * supersample;
        for (let sample = 0; sample < samples; ++sample) {
            const x = left + sample % supersample, y = top + Math.floor(sample / supersample);
            const {colour} = run.rasterPixel(entry, display, x, y).pixel;
            sums.forEach((sum, channel) => { sums[channel] = sum + ((colour >>> (16 - 8 * channel)) & 255); });
        }
        const [red, green, blue] = sums.map(sum => Math.floor((sum + Math.floor(samples / 2)) / samples));
        computed.push(red * 65536 + green * 256 + blue);
    }
    return [computed, [...await run.shownPixelsOf(entry.pictures[display])], [...run.winners(entry, display)]];
})().then(done, error => done(String(error)));
"""
SHOWN = """
const [frame, display, done] = arguments, run = metabufferRun;
(async () => {
    const entry = run.data.frames.find(one => one.frame === frame), {width, height} = run.machine, computed = [];
    if (!await run.loadImages(entry)) return null;
    for (let n = 0; n < width * height; ++n) computed.push(run.shownPixel(entry, display, n % width, Math.floor(n / width)));
    return computed;
})().then(done, error => done(String(error)));
"""
STARVED = """
const done = arguments[0], run = metabufferRun;
(async () => {
    const frames = [];
    for (const entry of run.data.frames) {
        const starved = [], wrong = [];
        for (let display = 0; display < run.displays; ++display) {
            wrong.push((await run.starvedMap(entry, display)).filter(mark => mark === 2).length);
            let count = 0;
            for (let renderer = 0; renderer < run.renderers; ++renderer) {
                const runs = run.starved[run.composerOf(renderer, display)].get(entry.frame) || [];
                for (const [, first, last] of runs) count += last - first + 1;
            }
            starved.push(count);
        }
        frames.push({index: entry.frame, starved, wrong});
    }
    return frames;
})().then(done, error => done(String(error)));
"""
# What is drawn on a canvas, read from a copy: the browser would warn about reading the canvas itself.
SAMPLES = """
function samplesOf(id) {
    const canvas = document.getElementById(id), copy = document.createElement("canvas");
    copy.width = canvas.width;
    copy.height = canvas.height;
    const context = copy.getContext("2d", {willReadFrequently: true});
    context.drawImage(canvas, 0, 0);
    return context.getImageData(0, 0, copy.width, copy.height).data;
}
"""
# Clocks of each bus by use: the sum of all single spans, and what the painter reads, which falls back on bins.
BUSES = """
const done = arguments[0], run = metabufferRun;
(async () => {
    const buses = [];
    for (let n = 0; n < run.renderers; ++n) {
        const byCounter = clocks => Object.fromEntries(run.uses.map(({counter}, use) => [counter, clocks[use]]));
        const allBefore = track => byCounter(track.before(run.cycles, new Float64Array(run.uses.length)));
        const track = await run.buses[n].load(), spans = new Float64Array(run.uses.length);
        track.kinds.forEach((kind, place) => { spans[kind] += track.lengths[place]; });
        const painted = allBefore(track), known = track.known;
        track.known = -1;
        const coarse = track.binSums.length > 1 ? allBefore(track) : null;
        track.known = known;
        const overlaps = track.starts.filter((start, at) => at && start < track.starts[at - 1] + track.lengths[at - 1]);
        buses.push({spans: byCounter(spans), painted, coarse, whole: known === Infinity, overlaps: overlaps.length});
    }
    return buses;
})().then(done, error => done(String(error)));
"""


# ------------------------------------------------------------------------------------------------------------- machines

def write_png(path, width, height, samples):
    """Writes 8-bit samples, row by row; their number gives the channels of a pixel."""
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    row = len(samples) // height
    colour_type = {1: 0, 3: 2, 4: 6}[row // width]
    lines = b"".join(b"\0" + bytes(samples[y * row:(y + 1) * row]) for y in range(height))
    path.write_bytes(b"\x89PNG\r\n\x1a\n"
                     + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, colour_type, 0, 0, 0))
                     + chunk(b"IDAT", zlib.compress(lines)) + chunk(b"IEND", b""))


def read_png(path):
    """The pixels of an 8-bit RGB file as 0xRRGGBB."""
    data, at, packed = path.read_bytes(), 8, b""
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at:at + 8])
        if kind == b"IHDR":
            width, height, depth, colour_type, _, _, interlace = struct.unpack(">IIBBBBB", data[at + 8:at + 21])
            assert (depth, colour_type, interlace) == (8, 2, 0), path
        elif kind == b"IDAT":
            packed += data[at + 8:at + 8 + length]
        at += 12 + length
    raw, size = zlib.decompress(packed), 3 * width
    above, pixels = bytearray(size), []
    for y in range(height):
        kind, row = raw[y * (size + 1)], bytearray(raw[y * (size + 1) + 1:(y + 1) * (size + 1)])
        for x in range(size if kind else 0):
            a, b, c = row[x - 3] if x >= 3 else 0, above[x], above[x - 3] if x >= 3 else 0
            p = a + b - c
            paeth = min((abs(p - a), 0, a), (abs(p - b), 1, b), (abs(p - c), 2, c))[2]
            row[x] = (row[x] + (0, a, b, (a + b) // 2, paeth)[kind]) & 255
        pixels += [row[x] << 16 | row[x + 1] << 8 | row[x + 2] for x in range(0, size, 3)]
        above = row
    return pixels


def scenario_file(path, composition, supersample, renderers, **keys):
    """`renderers`: of each, its name and its frames."""
    scenario = {"composition": composition, "depth_range": [0, 1],
                "displays": {"columns": COLUMNS, "rows": 1, "width": WIDTH, "height": HEIGHT,
                             "supersample": supersample, "background": list(BACKGROUND)},
                "renderers": [{"name": title, "frames": frames} for title, frames in renderers], **keys}
    path.write_text(json.dumps(scenario), encoding="utf-8")  # which is YAML, too
    return path


def noise(folder, composition, supersample, frames=FRAMES):
    """Images whose pixels each have their own colour, depth and alpha; blue's low bits name the renderer. The bus is
    too narrow."""
    rng = random.Random(f"{composition} {supersample}")
    width, height = 48 * supersample, 36 * supersample
    alphas = {"z": [255], "z-alpha-key": [0, 255], "over": [0, 100, 200, 255, 255, 255]}[composition]
    renderers = []
    for n, places in enumerate([[(5, 4, 1), (9, 2, 1)], [(0, 0, 2), (3, 0, 3)], [(25, 8, 1), (21, 6, 1)]], 1):
        image, depth = (f"{composition}-{supersample}-{n}{part}.png" for part in ("", "-depth"))
        colours = [sample for _ in range(width * height) for sample in (
            rng.randrange(256), rng.randrange(256), 4 * rng.randrange(64) + n, rng.choice(alphas))]
        write_png(folder / image, width, height, colours)
        write_png(folder / depth, width, height, rng.choices(range(255), k=width * height))
        renderers.append((f"noise {n}", [
            {"image": image, "depth": depth,
             "viewport": {"x": x * supersample, "y": y * supersample, "multiple": multiple}}
            for x, y, multiple in (places * frames)[:max(frames - 1, len(places))]]))
    path = folder / f"noise-{composition}-{supersample}-{frames}.yaml"
    return scenario_file(path, composition, supersample, renderers,
                         bus={"width_bits": 32 if supersample == 1 else 16, "burst_pixels": 8},  # some starve, some not
                         composer={"buffer_pixels": 64}, frames=frames)


# Flat images, each all of one depth: (left, top, width, height, multiple) in raster pixels, Z, alpha.
FLAT = [((4, 4, 50, 40, 1), 0.5, 255), ((20, 10, 30, 12, 3), 0.25, 0), ((60, 0, 20, 30, 2), 0.75, 255),
        ((30, 30, 60, 20, 1), 0.5, 128)]


def flat(folder, composition, names, **keys):
    renderers = []
    for n, ((x, y, width, height, multiple), z, alpha) in enumerate(FLAT):
        write_png(folder / f"flat-{n}.png", width, height, [60 * n + 40, 200 - 60 * n, 90, alpha] * (width * height))
        renderers.append((names[n], [{"image": f"flat-{n}.png", "z": z,
                                      "viewport": {"x": x, "y": y, "multiple": multiple}}]))
    return scenario_file(folder / f"flat-{composition}.yaml", composition, 2, renderers, **keys)


def flat_winner(composition, display, x, y):
    """Who is nearest at a raster pixel of a display: of equally near ones, the first."""
    covering = [(z, n) for n, ((left, top, width, height, multiple), z, alpha) in enumerate(FLAT)
                if left <= x + 2 * WIDTH * display < left + width * multiple and top <= y < top + height * multiple
                and not (composition == "z-alpha-key" and alpha == 0)]
    return min(covering)[1] if covering else -1


def page_of(scenario, page, *arguments):
    run("view", scenario, "-o", page, "--quiet", *arguments)
    return page


def results_of(scenario, out, *arguments):
    run("run", scenario, "--out", out, "--quiet", *arguments)
    return out


def report_of(results):
    return json.loads((results / "report.json").read_text(encoding="utf-8"))


def clocks_in_use(renderer):
    """The clocks of a renderer's bus, by counter."""
    return {counter: clocks for counter, clocks in renderer["bus"].items()
            if counter.endswith("_cycles") and counter != "idle_cycles"}


def first_starved_pixels_clock(scenario):
    """The clock that level rtl finds: its waveform begins 200 clocks earlier."""
    out = scenario.with_name(scenario.stem + "-trace")
    text = run("run", scenario, "--level", "rtl", "--out", out, "--no-images", "--trace", out / "trace.vcd",
               "--trace-window", "first-starved-pixel", "--trace-modules", "swap_lock")
    return int(re.search(r"core clocks (\d+) to \d+", text)[1]) + 200


class RunPage(PageTest):
    @classmethod
    def make_pages(cls):
        cls.scenarios = {scene: noise(cls.folder, *scene) for scene in SCENES}
        cls.results = {scene: scenario.with_suffix("") for scene, scenario in cls.scenarios.items()}
        cls.pages = {scene: scenario.with_suffix(".html") for scene, scenario in cls.scenarios.items()}
        with concurrent.futures.ThreadPoolExecutor(2) as both:
            # The pages' own runs are those of level tlm.
            done = []
            for scene, scenario in cls.scenarios.items():
                done += [both.submit(results_of, scenario, cls.results[scene], "--level", "rtl"),
                         both.submit(page_of, scenario, cls.pages[scene])]
            for one in done:
                one.result()
        cls.reports = {scene: report_of(results) for scene, results in cls.results.items()}
        cls.scenario, cls.report = cls.scenarios["z", 1], cls.reports["z", 1]
        cls.starving_page = cls.pages["z", 1]

    # ------------------------------------------------------------------------------------------------- helpers

    def wait_until_drawn(self):
        self.wait(lambda: self.browser.execute_script("return document.documentElement.dataset.ready === 'yes'"),
                  "the page is ready")

    def asked(self, script, *arguments):
        """The result of an asynchronous script."""
        self.browser.set_script_timeout(60)
        answer = self.browser.execute_async_script(script, *arguments)
        self.assertNotIsInstance(answer, str)
        return answer

    def script(self, text, *arguments):
        return self.browser.execute_script(text, *arguments)

    def text_of(self, selector):
        return self.script("return document.querySelector(arguments[0])?.textContent ?? ''", selector)

    def pixel_facts(self):
        """What the panel beside the displays says: (display, x, y) from 1, 0, 0, and the text."""
        text = self.script("return document.getElementById('pixel').innerText")
        found = re.search(r"display\s+(\d+)\s+(?:raster )?pixel\s+(\d+), (\d+)", text)
        return (tuple(map(int, found.groups())) if found else None), text

    def chosen_clock(self):
        found = re.search(r"Clock ([\d,]+)", self.text_of("#clock"))
        return int(found[1].replace(",", "")) if found else None

    def frame_shown(self):
        return int(re.search(r"Frame (\d+):", self.text_of("#wall-note"))[1])

    def wall_point(self, display, x, y):
        """Where in the canvas the middle of a shown pixel is, while the whole wall is seen."""
        width, height = self.script("const c = document.getElementById('wall'); return [c.clientWidth, c.clientHeight]")
        whole = COLUMNS * (WIDTH + GAP) - GAP
        scale = min(width / whole, height / HEIGHT)
        return ((width - whole * scale) / 2 + (display * (WIDTH + GAP) + x + 0.5) * scale,
                (height - HEIGHT * scale) / 2 + (y + 0.5) * scale)

    def to_point(self, canvas, point, actions=None):
        """An action that moves the mouse to a point of a canvas, from its top left corner."""
        element = self.one(canvas)
        width, height = element.size["width"], element.size["height"]
        return (actions or ActionChains(self.browser, duration=0)).move_to_element_with_offset(
            element, round(point[0] - width / 2), round(point[1] - height / 2))

    def scroll_to(self, selector):
        self.script("document.querySelector(arguments[0]).scrollIntoView({block: 'center'})", selector)

    def wait_for_facts(self, *words):
        """The facts come a little later: images are unpacked when their frame is first shown."""
        self.wait(lambda: all(word in self.pixel_facts()[1] for word in words), f"the pixel's facts have {words}")

    def hover_pixel(self, display, x, y, *words):
        self.to_point("#wall", self.wall_point(display, x, y)).perform()
        self.wait(lambda: self.pixel_facts()[0] == (display + 1, x, y), f"pixel {x}, {y} of display {display + 1}")
        self.wait_for_facts(*words)

    def wheel(self, canvas, point, by):
        self.to_point(canvas, point).perform()
        element = self.one(canvas)
        origin = ScrollOrigin.from_element(element, round(point[0] - element.size["width"] / 2),
                                           round(point[1] - element.size["height"] / 2))
        ActionChains(self.browser).scroll_from_origin(origin, 0, by).perform()

    def clock_under_mouse(self, point):
        """The clock in the time line's tooltip, once that is about this point."""
        self.to_point("#time", (point[0] + 2, point[1])).perform()
        self.to_point("#time", point).perform()
        text = self.wait(lambda: self.one("#tooltip").is_displayed() and self.one("#tooltip").text, "the tooltip shows")
        return int(re.search(r"clock ([\d,]+)", text)[1].replace(",", ""))

    def yellow_marks(self):
        """Where the time line has marks of starved pixels: (x, y) of the first screen pixel of each."""
        return self.script(SAMPLES + """
            const canvas = document.getElementById("time"), colour = arguments[0], data = samplesOf("time"), found = [];
            let was = false;
            for (let n = 0; n < data.length / 4; ++n) {
                const is = data[4 * n] * 65536 + data[4 * n + 1] * 256 + data[4 * n + 2] === colour;
                if (is && !was) found.push([n % canvas.width, Math.floor(n / canvas.width)]);
                was = is;
            }
            return found;""", YELLOW)

    def starved_runs(self, report):
        """(frame, display, renderer, y, first x, last x), from 0, of report.json, which has them all."""
        runs = []
        for composer in report["composers"]:
            self.assertEqual(0, composer["starved_runs_left_out"])
            for text in composer["starved_runs"]:
                frame, y, first, last = re.fullmatch(r"frame (\d+), y (\d+), x (\d+)(?:\.\.(\d+))?", text).groups()
                runs.append((int(frame), composer["display"] - 1, composer["renderer"] - 1, int(y), int(first),
                             int(last or first)))
        return runs

    def starts(self):
        """The clock in which a display's top composer begins a frame, from the program's trace of level tlm."""
        trace = self.folder / "schedule.json"
        run("run", self.scenario, "--out", self.folder / "schedule", "--no-images", "--quiet", "--trace", trace)
        events = json.loads(trace.read_text(encoding="utf-8"))["traceEvents"]
        tracks = {(event["pid"], event["tid"]): event["args"]["name"] for event in events
                  if event.get("name") == "thread_name"}
        return {(event["args"]["frame"], int(re.search(r"\d+", tracks[event["pid"], event["tid"]])[0]) - 1):
                event["args"]["first_cycle"] for event in events if event["name"].startswith("composite frame")}

    def press(self, *keys):
        ActionChains(self.browser).send_keys(*keys).perform()

    def focused(self):
        return self.script("return document.activeElement.id")

    # --------------------------------------------------------------------------------------------- pixels are exact

    def test_each_colour_and_winner_is_that_of_level_rtl(self):
        for (composition, supersample), page in self.pages.items():
            self.open(page)
            report = self.reports[composition, supersample]
            starved, wrong = report["totals"]["starved_pixels"], report["totals"]["wrong_pixels"]
            self.assertTrue(0 < wrong < FRAMES * COLUMNS * WIDTH * HEIGHT)  # or the scene would test little
            self.assertGreater(starved, 0)
            for frame in range(FRAMES):
                for display in range(COLUMNS):
                    with self.subTest(composition=composition, supersample=supersample, frame=frame, display=display):
                        picture = read_png(self.results[composition, supersample]
                                           / f"display_{display + 1}.{frame:04}.png")
                        computed, embedded, winners = self.asked(COLOURS, frame, display)
                        self.assertEqual(picture, embedded)
                        self.assertEqual(picture, computed)
                        if composition != "over" and supersample == 1:  # the picture itself says who won
                            self.assertEqual([(colour & 3) - 1 for colour in picture], winners)

    def test_corrected_colours(self):
        rng = random.Random(17)
        table = self.folder / "table.csv"
        table.write_text("".join(f"{rng.randrange(256)},{rng.randrange(256)},{rng.randrange(256)}\n" for _ in range(256)),
                         encoding="utf-8")
        correction = f"displays.correction=[{{display: 2, lut: {table.name}}}]"
        scenario, plain = self.scenarios["over", 2], self.results["over", 2]
        results = results_of(scenario, scenario.with_suffix(".corrected"), "--level", "rtl", "--set", correction)
        page = page_of(scenario, scenario.with_suffix(".corrected.html"), "--set", correction)
        self.open(page)
        self.assertIn("the colours of display 2.", self.text_of("#remarks"))
        report = report_of(results)
        shown = self.asked(STARVED)
        self.assertEqual([frame["wrong_pixels"] for frame in report["frames"]], [frame["wrong"] for frame in shown])
        self.assertTrue(0 < report["totals"]["wrong_pixels"])
        for display in range(COLUMNS):
            name = f"display_{display + 1}.0000.png"
            picture = read_png(results / name)
            self.assertEqual(picture == read_png(plain / name), display == 0)
            self.assertEqual(picture, self.asked(SHOWN, 0, display))
        # Beside the displays: what leaves the pipeline, and what becomes of it.
        self.to_point("#wall", self.wall_point(1, 20, 9)).perform()
        self.wait_for_facts("leaves the pipeline", "corrected by its table")
        self.assertIn(f"#{read_png(results / 'display_2.0000.png')[9 * WIDTH + 20]:06x}", self.text_of("#corrected"))
        self.to_point("#wall", self.wall_point(0, 20, 9)).perform()
        self.wait(lambda: self.pixel_facts()[0] and self.pixel_facts()[0][0] == 1, "display 1 is described")
        self.assertNotIn("corrected", self.pixel_facts()[1])

    def test_smoothed_colours(self):
        for (composition, supersample), scenario in self.scenarios.items():
            settings = ("--set", "composer.smoothing=bilinear", "--set", f"composer.buffer_pixels={160 * supersample}")
            results = results_of(scenario, scenario.with_suffix(".smoothed"), "--level", "rtl", *settings)
            self.open(page_of(scenario, scenario.with_suffix(".smoothed.html"), *settings))
            report = report_of(results)
            self.assertEqual({}, {renderer["name"]: renderer["rejected_rows"] for renderer in report["renderers"]
                                  if any(renderer["rejected_rows"].values())})
            shown = self.asked(STARVED)
            self.assertEqual([frame["wrong_pixels"] for frame in report["frames"]], [frame["wrong"] for frame in shown])
            for frame in range(FRAMES):
                for display in range(COLUMNS):
                    with self.subTest(composition=composition, supersample=supersample, frame=frame, display=display):
                        name = f"display_{display + 1}.{frame:04}.png"
                        picture = read_png(results / name)
                        computed, _, winners = self.asked(COLOURS, frame, display)
                        self.assertEqual(picture, computed)
                        if 1 in winners:  # whose image is magnified
                            self.assertNotEqual(picture, read_png(self.results[composition, supersample] / name))
        self.to_point("#wall", self.wall_point(0, 2, 2)).perform()
        self.wait_for_facts("mixed with those around it")

    def test_winners_of_flat_images(self):
        for composition in COMPOSITIONS:
            names = [f"renderer {n}" for n in range(len(FLAT))]
            scenario = flat(self.folder, composition, names, frames=1, bus={"width_bits": 512})
            self.open(page_of(scenario, scenario.with_suffix(".html")))
            self.assertIn("nothing", self.text_of("#answers"))
            for display in range(COLUMNS):
                expected = [flat_winner(composition, display, 2 * x, 2 * y)
                            for y in range(HEIGHT) for x in range(WIDTH)]
                self.assertGreater(len(set(expected)), 2)
                self.assertEqual(expected, self.asked(COLOURS, 0, display)[2], composition)
            # What the page says with the mouse on a pixel.
            for display, x, y in ((0, 30, 12), (0, 12, 3), (0, 20, 17), (1, 0, 2), (1, 4, 20), (1, 39, 29)):
                self.to_point("#wall", self.wall_point(display, x, y)).perform()
                self.wait(lambda: self.pixel_facts()[0] and [at // 2 for at in self.pixel_facts()[0][1:]] == [x, y],
                          "the pixel is described")
                place, _ = self.pixel_facts()
                self.assertEqual(display + 1, place[0])
                winner = flat_winner(composition, display, place[1], place[2])
                self.assertEqual("The background is shown." if winner < 0 else f"{names[winner]} wins.",
                                 self.text_of("#winner"))

    def test_starved_and_wrong_pixels_are_the_reports(self):
        small, settings = options.scenarios / "paper-figure-small.yaml", ("--set", "bus.width_bits=32", "--frames", 2)
        paper = (page_of(small, self.folder / "paper.html", *settings),
                 report_of(results_of(small, self.folder / "paper", *settings)))
        for page, report in [paper, *((self.pages[key], self.reports[key])
                                      for key in SCENES[1:])]:
            self.open(page)
            self.assertGreater(report["totals"]["wrong_pixels"], 0)
            self.assertEqual([{"index": frame["index"], "starved": frame["starved_pixels"],
                               "wrong": frame["wrong_pixels"]} for frame in report["frames"]], self.asked(STARVED))
            self.assertIn(f"{report['totals']['starved_pixels']:,} raster pixels", self.text_of("#answers"))
            first = report["frames"][0]
            self.assertIn(f"{sum(first['starved_pixels']):,} raster pixels starved, "
                          f"{sum(first['wrong_pixels']):,} shown pixels wrong", self.text_of("#wall-note"))

    # ------------------------------------------------------------------------------------------------------ clocks

    def test_the_first_starved_pixel_has_level_rtls_clock(self):
        for key in (("z", 1), ("over", 2)):
            self.open(self.pages[key])
            clock = first_starved_pixels_clock(self.scenarios[key])
            self.one("#next-glitch").click()
            self.assertEqual(clock, self.chosen_clock())
            self.wait_for_facts(", starved", f"{clock:,}")
            (display, x, y), _ = self.pixel_facts()
            self.assertIn((0, display - 1, y, x), [(frame, at, row, first) for frame, at, _, row, first, _
                                                   in self.starved_runs(self.reports[key])])

    def test_clocks_of_columns_that_stall(self):
        settings = ("--set", "composer.on_starvation=stall")
        out = self.folder / "stall"
        report = report_of(results_of(self.scenario, out, "--level", "rtl", "--no-images", *settings))
        self.assertGreater(report["totals"]["stalled_cycles"], 0)
        self.assertEqual(0, report["totals"]["starved_pixels"])
        self.open(page_of(self.scenario, self.folder / "stall.html", *settings))
        bottom, last = len(report["renderers"]) - 1, (WIDTH - 1, HEIGHT - 1)
        for frame in report["frames"]:
            starts, ends = ([self.script("return metabufferRun.clockOf(...arguments)", frame["index"], display, *place)
                             for display in range(COLUMNS)] for place in ((0, 0, 0), (bottom, *last)))
            self.assertEqual(frame["start_cycle"], min(starts))
            self.assertEqual(frame["end_cycle"], max(ends))
            # And back: the pixel that the top composers work at in that clock.
            display = starts.index(min(starts))
            beam = self.script("return metabufferRun.beamAt(...arguments)", min(starts), display)
            self.assertEqual({"frame": frame["index"], "x": 0, "y": 0}, beam)

    def test_each_bus_adds_up_to_its_counters(self):
        for key in (("z", 1), ("over", 2)):
            self.open(self.pages[key])
            for bus, renderer in zip(self.asked(BUSES), self.reports[key]["renderers"], strict=True):
                counted = clocks_in_use(renderer)
                self.assertTrue(bus["whole"])
                self.assertEqual(0, bus["overlaps"])
                self.assertEqual(counted, bus["spans"])
                self.assertEqual(counted, bus["painted"])

    def test_a_run_of_millions_of_bursts_adds_up_beyond_those_that_are_in_the_page(self):
        settings = ["frames=40", "bus.burst_pixels=1", "memory.page_words=16", "memory.page_miss_cycles=1",
                    "composer.ready_space_pixels=8"]
        words = [word for setting in settings for word in ("--set", setting)]
        scenario = options.scenarios / "paper-figure-small.yaml"
        report = report_of(results_of(scenario, self.folder / "bursts", *words, "--no-images"))
        self.open(page_of(scenario, self.folder / "bursts.html", *words, "--embed-mib", "1"))
        self.assertIn("bursts, waits and other spans of buses", self.one("#remarks").text)
        for bus, renderer in zip(self.asked(BUSES), report["renderers"], strict=True):
            counted = clocks_in_use(renderer)
            self.assertFalse(bus["whole"])
            self.assertLess(bus["spans"]["busy_cycles"], counted["busy_cycles"])
            self.assertEqual(counted, bus["painted"])
            self.assertEqual(counted, bus["coarse"])

    # ------------------------------------------------------------------------------------------------------- mouse

    def test_frames_by_slider_and_buttons(self):
        self.open(self.starving_page)
        self.assertEqual(0, self.frame_shown())
        self.one("#next-frame").click()
        self.assertEqual(1, self.frame_shown())
        self.one("#next-frame").click()
        self.one("#next-frame").click()  # there is none after the last
        self.assertEqual(FRAMES - 1, self.frame_shown())
        self.one("#previous-frame").click()
        self.assertEqual(1, self.frame_shown())
        slider = self.one("#frame")
        slider.send_keys(Keys.HOME)
        self.assertEqual(0, self.frame_shown())
        slider.send_keys(Keys.ARROW_RIGHT)
        self.assertEqual(1, self.frame_shown())
        ActionChains(self.browser).move_to_element(slider).click().perform()  # the middle one of three
        self.assertEqual(1, self.frame_shown())
        self.assertEqual("Play", self.one("#play").text)
        slider.send_keys(Keys.HOME)
        self.one("#play").click()
        self.assertEqual("Stop", self.one("#play").text)
        self.wait(lambda: self.frame_shown() == FRAMES - 1 and self.one("#play").text == "Play", "it plays to the end")

    def test_a_pixel_by_mouse(self):
        self.open(self.starving_page)
        self.scroll_to("#wall")
        for frame in (0, 1):
            if frame:
                self.one("#next-frame").click()
                self.wait(lambda: self.frame_shown() == 1, "the next frame")
            pictures = [read_png(self.results["z", 1] / f"display_{display + 1}.{frame:04}.png")
                        for display in range(COLUMNS)]
            for display, x, y in ((0, 0, 0), (0, 17, 12), (1, 3, 29), (1, 39, 7), (0, 39, 20)):
                colour = pictures[display][y * WIDTH + x]
                winner = colour & 3
                self.hover_pixel(display, x, y, f"pipeline: #{colour:06x}",
                                 f"noise {winner} wins." if winner else "The background is shown.")
                self.assertIsNone(self.chosen_clock())  # the mouse alone chooses none
        # A click pins the pixel, and shows its clock.
        pixel = (1, 20, 15)
        self.hover_pixel(*pixel)
        self.to_point("#wall", self.wall_point(*pixel)).click().perform()
        clock = self.chosen_clock()
        top = self.starts()[1, pixel[0]] + pixel[2] * WIDTH + pixel[1]  # nothing stalls here
        starved = [renderer for at, display, renderer, y, first, last in self.starved_runs(self.report)
                   if (at, display, y) == (1, pixel[0], pixel[2]) and first <= pixel[1] <= last]
        self.assertEqual(top + (starved[0] if starved else 0), clock)
        self.to_point("#wall", self.wall_point(0, 3, 3)).perform()
        self.wait(lambda: self.pixel_facts()[0] == (1, 3, 3), "another pixel under the mouse")
        ActionChains(self.browser).move_to_element(self.one("#wall-title")).perform()
        self.wait(lambda: self.pixel_facts()[0] == (2, 20, 15), "the pinned pixel, without the mouse")
        self.assertEqual(clock, self.chosen_clock())

    def test_wheel_and_drag_on_the_displays(self):
        self.open(self.starving_page)
        self.scroll_to("#wall")
        point, beside = self.wall_point(0, 20, 15), self.wall_point(0, 26, 15)
        self.hover_pixel(0, 20, 15)
        self.wheel("#wall", point, -400)

        def shown(at):
            self.to_point("#wall", (at[0] + 2, at[1])).perform()
            self.to_point("#wall", at).perform()
            return self.pixel_facts()[0]
        self.wait(lambda: shown(beside)[1] < 26, "the wheel zooms in")
        self.assertEqual((1, 20, 15), shown(point))  # what is under the mouse stays there
        pressed = shown(beside)
        self.to_point("#wall", beside).click_and_hold().perform()
        self.to_point("#wall", (beside[0] - 90, beside[1] + 40)).release().perform()
        self.assertEqual(pressed, shown((beside[0] - 90, beside[1] + 40)))
        self.assertIsNone(self.chosen_clock())  # a drag is not a click
        self.one("#whole-wall").click()
        self.hover_pixel(0, 26, 15)
        # A wheel that cannot zoom out any further scrolls the page.
        before = self.script("return window.scrollY")
        self.wheel("#wall", point, 300)
        self.wait(lambda: self.script("return window.scrollY") > before, "the page scrolls")

    def test_wheel_and_drag_on_the_time_line(self):
        self.open(self.starving_page)
        self.scroll_to("#time")
        left, right, y = (400, 60), (700, 60), 60

        def width():
            return self.clock_under_mouse(right) - self.clock_under_mouse(left)
        whole, middle = width(), self.clock_under_mouse((550, y))
        self.wheel("#time", (550, y), -600)
        self.wait(lambda: width() < whole / 2, "the wheel zooms in")
        # A screen pixel of the whole run is this many clocks; the mouse is as exact.
        per_pixel = whole / 300
        self.assertAlmostEqual(middle, self.clock_under_mouse((550, y)), delta=per_pixel)
        pressed = self.clock_under_mouse((500, y))
        self.to_point("#time", (500, y)).click_and_hold().perform()
        self.to_point("#time", (620, y)).release().perform()
        self.assertAlmostEqual(pressed, self.clock_under_mouse((620, y)), delta=per_pixel)
        self.assertIsNone(self.chosen_clock())
        self.one("#whole-run").click()
        self.wait(lambda: width() == whole, "the whole run again")
        self.to_point("#time", (550, y)).click().perform()
        self.assertEqual(middle, self.chosen_clock())

    def test_a_yellow_mark_leads_to_its_pixel(self):
        self.open(self.starving_page)
        self.scroll_to("#time")
        self.wait(self.yellow_marks, "yellow marks are drawn")
        marks = self.yellow_marks()
        runs = self.starved_runs(self.report)
        chosen = set()
        for x, y in (marks[0], marks[len(marks) // 2], marks[-1]):
            self.one("#whole-run").click()
            self.wait(self.yellow_marks, "they are drawn again")
            self.to_point("#time", (x + 1, y + 1)).click().perform()
            self.wait_for_facts(", starved", f"{self.chosen_clock():,}")
            (display, column, row), _ = self.pixel_facts()
            place = (self.frame_shown(), display - 1, row, column)
            self.assertIn(place, [(frame, at, line, first) for frame, at, _, line, first, _ in runs])
            chosen.add(place)
        self.assertGreater(len(chosen), 1)

    def test_glitches_in_the_order_of_time(self):
        self.open(self.starving_page)
        starts = self.starts()
        runs = [(clock, frame, display, y, x) for clock, display, _, frame, y, x in sorted(
            (starts[frame, display] + y * WIDTH + first + renderer, display, renderer, frame, y, first)
            for frame, display, renderer, y, first, _ in self.starved_runs(self.report))]
        self.assertLess(len({clock for clock, *_ in runs}), len(runs))  # some have the same clock

        def stepped(button, times):
            return [tuple(place) for place in self.script("""
                const [button, times] = arguments, places = [];
                const numbers = (id, words) => words.exec(document.getElementById(id).innerText).slice(1)
                    .map(number => Number(number.replaceAll(",", "")));
                for (let n = 0; n < times; ++n) {
                    document.getElementById(button).click();
                    const [clock] = numbers("clock", /Clock ([\\d,]+)/), [frame] = numbers("wall-note", /Frame (\\d+)/);
                    const [display, x, y] = numbers("pixel", /display\\s+(\\d+)\\s+pixel\\s+(\\d+), (\\d+)/);
                    places.push([clock, frame, display - 1, y, x]);
                }
                return places;""", button, times)]
        self.assertEqual(runs, stepped("next-glitch", len(runs)))
        self.assertEqual(runs[:-1][::-1], stepped("previous-glitch", len(runs) - 1))
        # From a clock between two frames the next one is in the later frame.
        self.one("#whole-run").click()
        Select(self.one("#group")).select_by_visible_text("of display 2")
        self.scroll_to("#time")
        between = (starts[1, 0] + self.report["frames"][0]["end_cycle"]) // 2
        width = self.one("#time").size["width"] - 138
        self.to_point("#time", (138 + between / self.report["core_cycles"] * width, 60)).click().perform()
        self.assertAlmostEqual(between, self.chosen_clock(), delta=2 * self.report["core_cycles"] / width)
        self.one("#next-glitch").click()
        self.assertEqual(next(clock for clock, frame, *_ in runs if frame == 1), self.chosen_clock())
        self.assertEqual(1, self.frame_shown())

    def test_the_command_makes_the_waveform_of_the_clock(self):
        folder = self.folder / "waveform"
        folder.mkdir()
        # The same for a page made from results. These stay as they are, although a run would write to their folder.
        results = results_of(self.scenario, folder / "out" / self.scenario.stem)
        before = {path.name: path.read_bytes() for path in results.iterdir()}
        for page, scenario in ((self.starving_page, self.scenario),
                               (page_of(results, folder / "results.html"), results / "effective_scenario.yaml")):
            self.open(page)
            self.one("#next-glitch").click()
            clock = self.chosen_clock()
            command = self.text_of("#command")
            self.assertEqual(["metabuffer", "run", str(scenario)], shlex.split(command)[:3])
            script = command.replace("metabuffer run", f"{shlex.quote(str(options.program))} run", 1)
            done = subprocess.run(["bash", "-c", script], cwd=folder, text=True, stdout=subprocess.PIPE,
                                  stderr=subprocess.PIPE)
            self.assertEqual(0, done.returncode, done.stderr)
            first, last = map(int, re.search(r"core clocks (\d+) to (\d+)", done.stdout).groups())
            self.assertTrue(first <= clock <= last, (first, clock, last))
            self.assertGreater((folder / "out" / "waveform" / "trace.vcd").stat().st_size, 1000)
        self.assertEqual(before, {path.name: path.read_bytes() for path in results.iterdir()})
        # If the clock is out of sight, or the whole run in sight, the command's window lies around the clock.
        for look_away in (lambda: self.one("#time").send_keys(Keys.END), self.one("#whole-run").click):
            look_away()
            window = re.search(r"cycles:(\d+)-(\d+)", self.text_of("#command"))
            self.assertTrue(int(window[1]) <= clock <= int(window[2]), window[0])
            self.assertLess(int(window[2]) - int(window[1]), self.report["core_cycles"] / 2)

    def test_copy(self):
        self.open(self.starving_page)
        self.one("#next-glitch").click()
        command = self.text_of("#command")
        self.browser.execute_cdp_cmd("Browser.grantPermissions", {
            "permissions": ["clipboardReadWrite", "clipboardSanitizedWrite"]})
        copy = next(button for button in self.all("#clock button") if button.text == "Copy")
        self.scroll_to("#command")
        copy.click()
        self.wait(lambda: copy.text == "Copied", "it says so")
        copied = self.asked("const done = arguments[0];"
                            "navigator.clipboard.readText().then(text => done([text]), error => done(String(error)));")
        self.assertEqual([command], copied)

    # ---------------------------------------------------------------------------------------------------- keyboard

    def test_by_keyboard_alone(self):
        self.open(self.starving_page)
        self.one("#next-glitch").send_keys(Keys.ENTER)
        (display, x, y), _ = self.pixel_facts()
        glitch = self.chosen_clock()
        # Every element that can be used is reached, and is seen to be.
        usable = set(self.script("""
            return [...document.querySelectorAll("button, input, select, summary, canvas, a")]
                .filter(one => one.offsetParent).map((one, n) => one.dataset.place = String(n));"""))
        self.one("h1").click()  # Tab goes on from there
        reached, without_focus = set(), []
        for _ in range(2 * len(usable)):
            self.press(Keys.TAB)
            place, outline, what = self.script(
                "const one = document.activeElement, style = getComputedStyle(one);"
                "return [one.dataset.place, style.outlineStyle === 'none' ? 0 : parseFloat(style.outlineWidth),"
                "        one.outerHTML.slice(0, 80)]")
            if place is None or place in reached:
                break
            reached.add(place)
            if outline < 1:
                without_focus.append(what)
        self.assertEqual(usable, reached)
        self.assertEqual([], without_focus)
        # Arrow keys: from the chosen pixel, one by one.
        self.script("document.getElementById('wall').focus()")
        for key, step in ((Keys.ARROW_RIGHT, (1, 0)), (Keys.ARROW_DOWN, (0, 1)), (Keys.ARROW_LEFT, (-1, 0)),
                          (Keys.ARROW_UP, (0, -1))):
            place = self.pixel_facts()[0]
            self.press(key)
            x, y = (min(size - 1, max(0, at + by)) for size, at, by in zip((WIDTH, HEIGHT), place[1:], step))
            self.assertEqual((place[0], x, y), self.pixel_facts()[0])
        self.wait_for_facts(f"{self.chosen_clock():,}")
        self.press(Keys.ENTER)
        self.assertEqual("time", self.focused())
        clock = self.chosen_clock()
        self.press(".")
        self.assertEqual(clock + 1, self.chosen_clock())
        self.press(",", ",")
        self.assertEqual(clock - 1, self.chosen_clock())
        # Frames and glitches, too.
        self.one("#previous-glitch").send_keys(Keys.SPACE)
        self.assertLess(self.chosen_clock(), max(glitch, clock) + 1)
        self.one("#frame").send_keys(Keys.END)
        self.assertEqual(FRAMES - 1, self.frame_shown())
        summary = self.one("#clock-details summary")
        summary.send_keys(Keys.ENTER)
        self.wait(lambda: self.script("return document.getElementById('clock-details').open"), "details open")
        self.assertIn("bus noise 1", self.one("#clock-details").text)

    # ---------------------------------------------------------------------------------------------------- the page

    def test_names_are_not_markup(self):
        names = [HOSTILE_RENDERER, HOSTILE, "quote \" ' ` $(touch hostile)", "-- & <b>"]
        scenario = flat(self.folder, "z", names, name=HOSTILE_SCENARIO)
        settings = ("--set", f"renderers.3.name={json.dumps(names[3])}")
        page = page_of(scenario, self.folder / "hostile.html", *settings)
        for title in (HOSTILE_SCENARIO, HOSTILE):
            if title == HOSTILE:
                page_of(scenario, page, *settings, "--title", title)
            self.open(page)
            self.assertEqual(title, self.one("h1").text)
            self.assertEqual(title, self.browser.title)
        self.assertIn(HOSTILE_SCENARIO, self.text_of("#counters"))
        for place in ("#wall-key", "#buses-section", "#group"):
            for name in names:
                self.assertIn(name, self.one(place).get_attribute("textContent"), place)
        self.scroll_to("#wall")
        self.to_point("#wall", self.wall_point(0, 5, 5)).perform()
        self.wait(lambda: self.pixel_facts()[0], "a pixel is described")
        self.to_point("#wall", self.wall_point(0, 5, 5)).click().perform()
        self.one("#clock-details summary").click()
        for name in names:
            self.assertIn(name, self.text_of("#clock-details"))
        self.wait_for_facts(names[0])
        words = shlex.split(self.text_of("#command"))
        self.assertIn(f"renderers.3.name={json.dumps(names[3])}", words)
        self.scroll_to("#time")
        self.to_point("#time", (500, 34)).perform()
        self.wait(lambda: names[0] in self.one("#tooltip").text, "the tooltip shows the name")
        self.assertEqual([], self.all("img, b b, body > b"))
        self.assertIsNone(self.script("return window.hostile || null"))

    def test_dark_scheme(self):
        self.open(self.starving_page)

        def colours():
            return self.script(SAMPLES + """
                const surface = 4 * (27 * document.getElementById("time").width + 139);
                const counts = ["time", "wall"].map(id => {
                    const data = samplesOf(id), seen = new Set();
                    for (let n = 0; n < data.length; n += 4) seen.add(data[n] + "," + data[n + 1] + "," + data[n + 2]);
                    return seen.size;
                });
                return [getComputedStyle(document.documentElement).backgroundColor,
                        [...samplesOf("time").slice(surface, surface + 4)], ...counts];""")
        self.wait(lambda: colours()[1] == [245, 247, 249, 255], "a light time line")
        self.assertEqual("rgb(255, 255, 255)", colours()[0])
        self.prefer("dark")
        self.wait(lambda: colours()[1] == [31, 38, 46, 255], "a dark time line")
        background, _, time_colours, wall_colours = colours()
        self.assertEqual("rgb(23, 28, 34)", background)
        self.assertGreater(time_colours, 8)
        self.assertGreater(wall_colours, 100)

    def test_no_sideways_scroll(self):
        for width, height in ((390, 844), (1280, 800)):
            self.resize(width, height)
            self.open(self.starving_page)
            self.one("#next-glitch").click()
            self.script("document.querySelectorAll('details').forEach(one => { one.open = true; })")
            self.assertLessEqual(self.script("return document.documentElement.scrollWidth"), width)

    # -------------------------------------------------------------------------------------------- what is not in it

    def test_a_page_without_pictures_of_renderers(self):
        self.open(page_of(self.scenario, self.folder / "no-room.html", "--embed-mib", 0))
        remarks = self.text_of("#remarks")
        self.assertIn("Pictures of every", remarks)
        self.assertRegex(remarks, r"\d+ images? of renderers (is|are) not in the page")
        self.scroll_to("#wall")
        self.hover_pixel(0, 20, 15, "Who won is not known.", "not in the page")
        Select(self.one("#view")).select_by_value("winner")
        self.one("#next-glitch").click()
        self.assertEqual(first_starved_pixels_clock(self.scenario), self.chosen_clock())
        self.wait_for_facts(", starved")
        self.one("#whole-run").click()
        self.wait(self.yellow_marks, "yellow marks are drawn")

    def test_a_long_run_is_thinned(self):
        frames, settings = 520, ("--set", "bus.burst_pixels=1")
        scenario = noise(self.folder, "z", 1, frames)
        report = report_of(results_of(scenario, self.folder / "long", "--no-images", *settings))
        self.open(page_of(scenario, self.folder / "long.html", "--embed-mib", 1, *settings))
        remarks = self.text_of("#remarks")
        stride = int(re.search(r"Pictures of every (\d+)th frame", remarks)[1])
        self.assertIn("and other spans of buses", remarks)
        self.one("#next-frame").click()
        self.assertEqual(stride, self.frame_shown())
        self.one("#frame").send_keys(Keys.END)
        self.assertEqual((frames - 1) // stride * stride, self.frame_shown())
        buses = self.asked(BUSES)
        self.assertFalse(all(bus["whole"] for bus in buses))
        for bus, renderer in zip(buses, report["renderers"], strict=True):
            counted = clocks_in_use(renderer)
            self.assertEqual(counted, bus["painted"])
            self.assertEqual(counted, bus["coarse"])
            if not bus["whole"]:
                self.assertLess(sum(bus["spans"].values()), sum(counted.values()))
        self.scroll_to("#time")
        self.to_point("#time", (1100, 90)).perform()
        self.wait(lambda: "beyond the spans" in self.one("#tooltip").text, "it says that spans are not there")

    def test_a_folder_of_results_is_its_scenario(self):
        folder = results_of(self.scenario, self.folder / "results")
        out = page_of(folder, self.folder / "of-folder.html")

        def parts(page):
            text = page.read_text(encoding="utf-8")
            data = json.loads(re.search(r'<script type="application/json" id="data">(.*?)</script>', text, re.S)[1])
            pictures = re.findall(r'<script type="application/base64" id="picture-\d+">(.*?)</script>', text)
            return {key: value for key, value in data.items() if key not in ("command", "remarks", "advice")}, pictures, data
        shown, pictures, data = parts(out)
        expected, expected_pictures, _ = parts(self.starving_page)
        self.assertEqual(expected, shown)
        self.assertEqual(expected_pictures, pictures)
        self.assertEqual([], data["remarks"])
        # How many changes are tried depends on the time that they take.
        self.assertTrue(data["advice"])
        self.open(out)
        self.assertIn(f"as runs have shown: {data['advice'][0]}", self.text_of("#remarks"))
        # The page says so if the report is that of another run.
        other = json.loads((folder / "report.json").read_text(encoding="utf-8"))
        other["core_cycles"] += 1
        (folder / "report.json").write_text(json.dumps(other), encoding="utf-8")
        page_of(folder, out)
        self.open(out)
        self.assertIn("report.json differs from this run in 1 value", self.text_of("#remarks"))
        (folder / "report.json").write_text("{", encoding="utf-8")
        page_of(folder, out)
        self.open(out)
        self.assertIn("cannot be read as a report", self.text_of("#remarks"))


if __name__ == "__main__":
    main(RunPage, __doc__)
