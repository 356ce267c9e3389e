"""What the tests of the pages share: the program that makes them and the browser that shows them.

A browser without a window still has a mouse, a keyboard and a network, which are all tested.
"""

import argparse
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

from selenium import webdriver
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.common.by import By
from selenium.webdriver.support.ui import WebDriverWait

SECONDS_TO_WAIT = 60  # for what takes less than one; a busy machine must not fail a test
HOSTILE = "</script><script>window.hostile = 1</script>\"'&<b>"
HOSTILE_RENDERER = "<img src=x onerror='window.hostile = 2'>"

options = argparse.Namespace()


def run(*arguments):
    done = subprocess.run([str(options.program), *map(str, arguments)], text=True, stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE)
    if done.returncode:
        raise AssertionError(f"metabuffer {arguments[0]} ended with {done.returncode}: {done.stderr}")
    return done.stdout


class PageTest(unittest.TestCase):
    """A browser for a class's tests, and a folder. A line on the console or a request to the network fails a test."""

    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="metabuffer-browser-"))
        cls.addClassCleanup(cls.leave)
        cls.make_pages()
        arguments = webdriver.ChromeOptions()
        for argument in ("--headless=new", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
                         "--disable-background-networking", "--disable-component-update", "--disable-sync",
                         "--disable-dev-shm-usage", f"--user-data-dir={cls.folder / 'profile'}",
                         "--window-size=1280,900"):
            arguments.add_argument(argument)
        arguments.binary_location = options.chromium
        arguments.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
        cls.browser = webdriver.Chrome(service=Service(options.driver), options=arguments)
        cls.addClassCleanup(cls.browser.quit)

    @classmethod
    def make_pages(cls):
        raise NotImplementedError

    @classmethod
    def leave(cls):
        if options.keep:
            shutil.copytree(cls.folder, options.keep, dirs_exist_ok=True,
                            ignore=shutil.ignore_patterns("profile"))
        shutil.rmtree(cls.folder, ignore_errors=True)

    def setUp(self):
        self.resize(1280, 900)
        self.browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": []})
        self.page = None
        self.browser.get("about:blank")
        self.browser.get_log("performance")  # the browser's own first page

    def tearDown(self):
        if options.keep and self.page:
            self.browser.save_screenshot(str(self.folder / (self.id().split(".")[-1] + ".png")))
        self.look_at_logs()

    def look_at_logs(self):
        """Checks that nothing is on the console and that only the page was requested. This empties the logs."""
        self.assertEqual([], [entry["message"] for entry in self.browser.get_log("browser")], "on the console")
        events = (json.loads(entry["message"])["message"] for entry in self.browser.get_log("performance"))
        asked_for = [event["params"]["request"]["url"] for event in events
                     if event["method"] == "Network.requestWillBeSent"]
        self.assertEqual([], [url for url in asked_for
                              if not url.startswith("data:") and self.page and url != self.page.as_uri()])
        if self.page:
            self.assertIn(self.page.as_uri(), asked_for)  # or the log would prove nothing

    # ------------------------------------------------------------------------------------------------- helpers

    def resize(self, width, height):
        self.browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {
            "width": width, "height": height, "deviceScaleFactor": 1, "mobile": False})

    def prefer(self, scheme):
        self.browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {
            "features": [{"name": "prefers-color-scheme", "value": scheme}]})

    def wait(self, condition, what):
        return WebDriverWait(self.browser, SECONDS_TO_WAIT, poll_frequency=0.05).until(lambda _: condition(), what)

    def open(self, page):
        if self.page:  # requests of the page before must not count for this one
            self.look_at_logs()
        self.page = page
        self.browser.get(page.as_uri())
        self.wait_until_drawn()

    def wait_until_drawn(self):
        raise NotImplementedError

    def all(self, selector):
        return self.browser.find_elements(By.CSS_SELECTOR, selector)

    def one(self, selector):
        return self.browser.find_element(By.CSS_SELECTOR, selector)


def main(test_class, description):
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", type=pathlib.Path, required=True, help="the metabuffer to test")
    parser.add_argument("--scenarios", type=pathlib.Path, required=True)
    parser.add_argument("--chromium", default="chromium")
    parser.add_argument("--driver", default="chromedriver")
    parser.add_argument("--keep", type=pathlib.Path, help="leave pages and screenshots in this folder")
    parser.add_argument("tests", nargs="*")
    parser.parse_args(namespace=options)
    options.program = options.program.resolve()
    options.scenarios = options.scenarios.resolve()
    # unittest looks up the class by name in the class's own module, which is the one that runs.
    unittest.main(argv=[sys.argv[0], *[f"{test_class.__name__}.{test}" for test in options.tests]], verbosity=2)
