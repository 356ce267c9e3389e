#!/usr/bin/env python3
"""The report page as a reader meets it: made by the program from its own results, shown by headless Chromium.

Needs Chromium, its driver and Selenium; --keep DIR leaves pages and screenshots there.
"""

import json
import shlex
import shutil
import sqlite3
import subprocess

from selenium.common.exceptions import TimeoutException
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.ui import Select, WebDriverWait

from page_browser import HOSTILE, HOSTILE_RENDERER, PageTest, main, options, run

WIDTHS, DEPTHS, POLICIES = (32, 64, 128), (64, 256), ("irsa", "edf")

GRID = f"""\
name: grid & <b>
scenario: SCENARIOS/paper-figure-small.yaml
pictures: true
set: {{bus.burst_pixels: 16, composer.ready_space_pixels: 16, frames: 3}}
axes:
  - {{key: bus.width_bits, values: [{", ".join(map(str, WIDTHS))}, 48]}}
  - {{key: composer.buffer_pixels, values: [{", ".join(map(str, DEPTHS))}]}}
  - {{key: bus.arbitration, values: [{", ".join(POLICIES)}]}}
  - {{key: renderers.0.name, values: [{json.dumps(HOSTILE_RENDERER)}]}}
"""  # no bus has 48 bits: these points fail
INVALID = len(DEPTHS) * len(POLICIES)
DONE = len(WIDTHS) * INVALID

SEARCH = """\
name: smallest
set: {frames: 3}
axes:
  - {key: scenario, values: [SCENARIOS/case-1.yaml, SCENARIOS/case-2.yaml]}
  - {key: bus.width_bits, values: [64, 128]}
minimize: {key: composer.buffer_pixels, from: 8, to: 20000, checks: 2}
"""
MANY = 10_000


def sweep(folder, name, text):
    (folder / f"{name}.yaml").write_text(text.replace("SCENARIOS", str(options.scenarios)), encoding="utf-8")
    run("sweep", folder / f"{name}.yaml", "--out", folder / f"{name}.db", "--quiet")
    return folder / f"{name}.db"


def page_of(folder, results, *arguments):
    page = folder / f"{results.stem}.html"
    run("report", results, "-o", page, *arguments)
    return page


def multiplied(results, target, count):
    """Copies a file's first run to `count` points, as a large sweep would leave them."""
    shutil.copy(results, target)
    with sqlite3.connect(target) as database:
        [(run_id,)] = database.execute("SELECT run FROM points WHERE status = 'done' ORDER BY id LIMIT 1")
        columns = [row[1] for row in database.execute("PRAGMA table_info(runs)") if row[1] not in ("id", "settings")]
        listed = ", ".join(f'"{column}"' for column in columns)
        for table in ("pictures", "point_settings", "points"):
            database.execute(f"DELETE FROM {table}")
        for n in range(1, count + 1):
            settings = {"bus.width_bits": str(n % 100), "composer.buffer_pixels": str(n), "bus.arbitration": "irsa"}
            database.execute(f"INSERT INTO runs (id, settings, {listed}) SELECT ?, ?, {listed} FROM runs WHERE id = ?",
                             (1_000_000 + n, json.dumps(settings), run_id))
            database.execute("INSERT INTO points (id, settings, status, reason, run, runs, note) "
                             "VALUES (?, ?, 'done', '', ?, 1, '')", (n, json.dumps(settings), 1_000_000 + n))
            database.executemany("INSERT INTO point_settings VALUES (?, ?, ?, ?)", [
                (n, place, key, int(value) if value.isdigit() else value)
                for place, (key, value) in enumerate(settings.items())])
    return target


class ReportPage(PageTest):
    @classmethod
    def make_pages(cls):
        grid = sweep(cls.folder, "grid", GRID)
        search = sweep(cls.folder, "search", SEARCH)
        cls.points = {point["point"]: point for point in json.loads(run("export", grid, "--format", "json", "--bookkeeping"))}
        cls.searches = json.loads(run("export", search, "--format", "json"))
        cls.grid_page = page_of(cls.folder, grid, "--title", HOSTILE)
        cls.search_page = page_of(cls.folder, search)
        cls.many_page = page_of(cls.folder, multiplied(grid, cls.folder / "many.db", MANY))

    # ------------------------------------------------------------------------------------------------- helpers

    def wait_until_drawn(self):
        self.wait_for_charts()

    def wait_for_charts(self):
        self.wait(lambda: self.browser.execute_script(
            "const charts = [...document.querySelectorAll('.chart')];"
            "return charts.length > 0 && charts.every(chart => chart.dataset.drawn === 'yes');"), "charts are drawn")

    def marks(self, chart, name):
        """The elements of the mark that Vega's specification gives this name."""
        return self.all(f"#chart-{chart} g.role-mark.{name} path")

    def shows(self, chart):
        return [text.get_attribute("textContent") for text in self.all(f"#chart-{chart} svg text")]

    def point_of(self, mark):
        """What the program exports of the point that a mark stands for."""
        place = self.browser.execute_script("return arguments[0].__data__.datum.id", mark)
        row = self.all("#points tbody tr[data-point='%d'] td" % place)
        return self.points[int(row[0].get_attribute("textContent"))]

    def hover(self, mark):
        self.browser.execute_script("arguments[0].scrollIntoView({block: 'center'})", mark)
        ActionChains(self.browser).move_to_element(mark).perform()

    def hover_until(self, mark, condition, what):
        """Moves the mouse onto the mark, if need be off and onto it again: a chart that is still being drawn misses the
        mouse."""
        def try_once():
            self.hover(mark)
            try:
                return WebDriverWait(self.browser, 2, poll_frequency=0.05).until(lambda _: condition())
            except TimeoutException:
                self.hover(self.one("h1"))
                return False
        return self.wait(try_once, what)

    def choose(self, section, label, value):
        for box in self.all(f"{section} label"):
            if self.browser.execute_script("return arguments[0].firstChild.textContent", box) == label:
                chart = self.one(f"{section} .chart") if section.startswith("#section") else self.one(".chart")
                self.browser.execute_script("arguments[0].dataset.drawn = 'no'", chart)
                Select(box.find_element(By.TAG_NAME, "select")).select_by_visible_text(value)
                self.wait_for_charts()
                return
        self.fail(f"no choice {label} in {section}")

    def panel_is_open(self):
        return self.browser.execute_script("return document.getElementById('panel').open")

    # --------------------------------------------------------------------------------------------------- charts

    def test_charts_draw_a_mark_for_each_point(self):
        self.open(self.grid_page)
        self.assertEqual(len(WIDTHS) * len(DEPTHS) + len(DEPTHS), len(self.marks("map", "cells")))
        self.assertEqual(DONE, len(self.marks("pareto", "points")))
        self.assertEqual(1, len(self.marks("pareto", "front")))
        self.assertEqual(len(POLICIES), len(self.marks("policy-utilization", "bars")))
        self.assertEqual(DONE, len(self.marks("policy-recovered_slots", "points")))
        self.assertEqual(DONE, len(self.marks("lines", "points")))
        self.assertEqual(INVALID, len(self.marks("lines", "lost")))
        # A section that makes no sense here is left out, and the page says why.
        self.assertEqual([], self.all("#section-smallest"))
        self.assertIn("not of a search", self.one("#left-out").text)

    def test_charts_of_a_search(self):
        self.open(self.search_page)
        self.assertEqual(len(self.searches), len(self.marks("smallest", "points")))
        self.assertIn("smallest composer.buffer_pixels", self.shows("smallest"))
        self.assertIn("case-1", self.shows("smallest"))
        simulations = sum(point["runs"] for point in self.searches)
        self.assertEqual(simulations, len(self.marks("search", "points")))
        self.assertEqual(simulations, len(self.marks("pareto", "points")))
        # The mark of a simulation opens it, with the value that was tried.
        mark = self.marks("search", "points")[0]
        looked_at = self.browser.execute_script("return arguments[0].__data__.datum.x", mark)
        self.hover(mark)
        ActionChains(self.browser).click(mark).perform()
        self.wait(self.panel_is_open, "the panel opens")
        self.assertIn(f"composer.buffer_pixels={looked_at}", self.one("#command").text)

    def test_choosing_another_figure_redraws(self):
        self.open(self.grid_page)
        self.choose("#section-map", "figure", "page misses")
        self.assertIn("page misses", self.shows("map"))
        self.assertNotIn("starved pixels", self.shows("map"))
        rates = {}
        for point in self.points.values():
            if point["status"] == "done":
                rates.setdefault((point["bus.width_bits"], point["composer.buffer_pixels"]), []).append(
                    point["page_misses"])
        for cell in self.marks("map", "cells"):
            x, y, value = self.browser.execute_script(
                "const d = arguments[0].__data__.datum; return [d.x, d.y, d.v]", cell)
            if (x, y) in rates:
                mean = sum(rates[x, y]) / len(rates[x, y])
                self.assertAlmostEqual(mean, value, places=6)
            else:
                self.assertIsNone(value)
        self.choose("#section-map", "across", "bus.arbitration")
        self.assertIn("bus.arbitration", self.shows("map"))

    def test_choosing_points_redraws_all(self):
        self.open(self.grid_page)
        self.choose("#filters", "bus.arbitration", "edf")
        self.assertEqual(DONE // len(POLICIES), len(self.marks("pareto", "points")))
        self.assertEqual(1, len(self.marks("policy-utilization", "bars")))
        self.assertEqual((DONE + INVALID) // len(POLICIES), len(self.all("#points tbody tr")))
        self.choose("#filters", "bus.arbitration", "all")
        self.assertEqual(DONE, len(self.marks("pareto", "points")))

    # -------------------------------------------------------------------------------------------- hover and click

    def test_hover_shows_the_point(self):
        self.open(self.grid_page)
        mark = self.marks("lines", "points")[3]
        point = self.point_of(mark)
        self.assertFalse(self.one("#tooltip").is_displayed())
        self.hover_until(mark, lambda: self.one("#tooltip").is_displayed(), "the tooltip shows")
        words = self.one("#tooltip").text
        for value in (str(point["bus.width_bits"]), point["bus.arbitration"], str(point["composer.buffer_pixels"]),
                      f"{point['frames_per_second']:,.1f}", f"{point['starved_pixels']:,}"):
            self.assertIn(value, words)
        self.hover(self.one("h1"))
        self.wait(lambda: not self.one("#tooltip").is_displayed(), "the tooltip goes")

    def test_a_click_opens_the_point_with_report_and_pictures(self):
        self.open(self.grid_page)
        mark = self.marks("pareto", "points")[-1]
        point = self.point_of(mark)
        self.hover(mark)
        ActionChains(self.browser).click(mark).perform()
        self.wait(self.panel_is_open, "the panel opens")
        self.assertEqual(f"Point {point['point']}", self.one("#panel-title").text)
        command = self.one("#command").text
        self.assertIn(f"--set bus.width_bits={point['bus.width_bits']} ", command)
        self.assertIn(f"--set bus.arbitration={point['bus.arbitration']} ", command)
        # The command must give what the point shows: it is run, by the shell that a reader would paste it into.
        script = command.replace("metabuffer run", f"{shlex.quote(str(options.program))} run", 1)
        done = subprocess.run(["bash", "-c", script], cwd=self.folder, text=True, stdout=subprocess.DEVNULL,
                              stderr=subprocess.PIPE)
        self.assertEqual("", done.stderr)
        by_hand = json.loads((self.folder / f"out/point-{point['point']}/report.json").read_text(encoding="utf-8"))
        self.assertEqual(HOSTILE_RENDERER, by_hand["renderers"][0]["name"])
        self.assertEqual(point["core_cycles"], by_hand["core_cycles"])
        # Pictures of four displays, each of the right size, not broken.
        self.wait(lambda: self.browser.execute_script(
            "const images = [...document.querySelectorAll('#panel img')];"
            "return images.length === 4 && images.every(i => i.complete && i.naturalWidth === 128);"), "four pictures")
        details = self.wait(lambda: self.all("#panel-report details"), "the report is unpacked")[0]
        details.find_element(By.TAG_NAME, "summary").click()
        text = self.wait(lambda: self.one("#panel-report pre").get_attribute("textContent"), "the report's text")
        report = json.loads(text)
        self.assertEqual(point["core_cycles"], report["core_cycles"])
        self.assertEqual(point["starved_pixels"], report["totals"]["starved_pixels"])
        self.assertIn(HOSTILE_RENDERER, self.one("#panel-report").text)
        self.assertIn("tube", self.one("#panel-report").text)
        ActionChains(self.browser).send_keys(Keys.ESCAPE).perform()
        self.wait(lambda: not self.panel_is_open(), "Escape closes")

    # ---------------------------------------------------------------------------------------------------- table

    def test_table_by_keyboard(self):
        self.open(self.grid_page)
        row = self.all("#points tbody tr")[1]
        expected = "Point " + row.find_element(By.TAG_NAME, "td").text
        self.browser.execute_script("arguments[0].focus()", row)
        ActionChains(self.browser).send_keys(Keys.ENTER).perform()
        self.wait(self.panel_is_open, "Enter opens")
        self.assertEqual(expected, self.one("#panel-title").text)
        self.one("#panel-next").click()
        self.assertNotEqual(expected, self.one("#panel-title").text)
        ActionChains(self.browser).send_keys(Keys.ESCAPE).perform()
        self.wait(lambda: not self.panel_is_open(), "Escape closes")

    def test_table_sorts_and_shows_failures_with_reasons(self):
        self.open(self.grid_page)
        self.assertEqual(DONE + INVALID, len(self.all("#points tbody tr")))
        Select(self.one("#status-filter")).select_by_visible_text(f"invalid ({INVALID})")
        rows = self.all("#points tbody tr")
        self.assertEqual(INVALID, len(rows))
        for row in rows:
            self.assertIn("bus.width_bits", row.text)
            self.assertIn("48", row.text)
        rows[0].click()
        self.wait(self.panel_is_open, "the panel opens")
        self.assertIn("no report", self.one("#panel-content").text)
        self.one("#panel-close").click()
        Select(self.one("#status-filter")).select_by_visible_text("all")

        def column(title):
            titles = [head.text for head in self.all("#points thead th")]
            place = next(n for n, text in enumerate(titles) if text.startswith(title))
            cells = [row.find_elements(By.TAG_NAME, "td")[place].text for row in self.all("#points tbody tr")]
            return [float(cell.replace(",", "")) for cell in cells if cell], cells

        head = next(h for h in self.all("#points thead button") if h.text == "starved pixels")
        head.click()
        numbers, cells = column("starved pixels")
        self.assertEqual(sorted(numbers), numbers)
        self.assertEqual([""] * INVALID, cells[-INVALID:])  # what has no value comes last in both orders
        next(h for h in self.all("#points thead button") if h.text.startswith("starved pixels")).click()
        numbers, cells = column("starved pixels")
        self.assertEqual(sorted(numbers, reverse=True), numbers)
        self.assertEqual([""] * INVALID, cells[-INVALID:])
        self.assertGreater(numbers[0], numbers[-1])

    # ---------------------------------------------------------------------------------------------------- the page

    def test_names_are_not_markup(self):
        self.open(self.grid_page)
        self.assertEqual(HOSTILE, self.one("h1").text)
        self.assertEqual(HOSTILE, self.browser.title)
        for place in ("#axes", "#points"):
            self.assertIn(next(iter(self.points.values()))["renderers.0.name"], self.one(place).text)
        self.assertIsNone(self.browser.execute_script("return window.hostile || null"))

    def test_no_sideways_scroll_on_a_phone(self):
        self.resize(390, 844)
        for page in (self.grid_page, self.search_page):
            self.open(page)
            self.assertLessEqual(self.browser.execute_script("return document.documentElement.scrollWidth"), 390)
            for chart in self.all(".chart"):
                inner, outer = self.browser.execute_script(
                    "return [arguments[0].scrollWidth, arguments[0].clientWidth]", chart)
                self.assertLessEqual(inner, outer, chart.get_attribute("id"))
            self.all("#points tbody tr")[0].click()
            self.wait(self.panel_is_open, "the panel opens")
            self.assertLessEqual(self.browser.execute_script(
                "return document.getElementById('panel').scrollWidth"), 390)
            self.one("#panel-close").click()

    def test_dark_scheme(self):
        self.open(self.grid_page)

        def colours():
            return self.browser.execute_script(
                "return [getComputedStyle(document.documentElement).backgroundColor,"
                "        document.querySelector('#chart-pareto svg').style.backgroundColor]")
        page, chart = colours()
        self.assertEqual("rgb(255, 255, 255)", page)
        self.assertEqual("rgb(255, 255, 255)", chart)
        self.browser.execute_script("document.querySelector('#chart-pareto').dataset.drawn = 'no'")
        self.prefer("dark")
        self.wait_for_charts()
        page, chart = colours()
        self.assertEqual("rgb(23, 28, 34)", page)
        self.assertEqual("rgb(23, 28, 34)", chart)

    def test_ten_thousand_points(self):
        self.open(self.many_page)
        self.assertIn("10,000 points", self.one("#summary").text)
        # Canvases, and something is drawn on them.
        painted = self.browser.execute_script(
            "const c = document.querySelector('#chart-pareto canvas, #chart-lines canvas');"
            "const pixels = c.getContext('2d').getImageData(0, 0, c.width, c.height).data;"
            "const colours = new Set();"
            "for (let n = 0; n < pixels.length; n += 4) colours.add(pixels.slice(n, n + 3).join());"
            "return colours.size;")
        self.assertGreater(painted, 3)
        rows = len(self.all("#points tbody tr"))
        self.assertLess(rows, MANY)
        self.assertIn(f"first {rows}", self.one("#table-count").text)
        self.one("#more-rows").click()
        self.assertEqual(rows + 1000, len(self.all("#points tbody tr")))
        self.all("#points tbody tr")[-1].click()
        self.wait(self.panel_is_open, "the panel opens")


if __name__ == "__main__":
    main(ReportPage, __doc__)
