"""Tests how the module reports a model that fails, with a level tlm that does so when the scenario's name says so."""

import os
import pathlib
import tempfile
import threading
import unittest

import metabuffer

import small_machine

# Two frames on two displays, of which the faulty level alters pixels of the last.
LARGER = {"displays": {"columns": 2, "width": 20, "height": 8}, "frames": 2}


class Failures(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        small_machine.write_image(pathlib.Path(scratch.name))
        self.addCleanup(os.chdir, os.getcwd())
        os.chdir(scratch.name)

    def error_of(self, name, kind, **options):
        with self.assertRaises(kind) as caught:
            metabuffer.run(small_machine.scenario(name=name, **LARGER), **options)
        self.assertIs(type(caught.exception), kind)
        return caught.exception

    def test_each_failure_has_its_exception(self):
        for name, kind, words in (("crash", metabuffer.CrashError, "Aborted"), ("late crash", metabuffer.CrashError, "Aborted"),
                                  ("exit", metabuffer.CrashError, "without a reply"),
                                  ("error", metabuffer.ModelError, "told to fail"),
                                  ("exception", metabuffer.ModelError, "told to throw"),
                                  ("input", metabuffer.InputError, "told to refuse"),
                                  ("memory", metabuffer.InputError, "memory")):
            with self.subTest(name):
                error = self.error_of(name, kind)
                self.assertIn(words, str(error))
                self.assertEqual(error.status, kind.status)
                self.assertIsInstance(error, metabuffer.Error)

    def test_a_run_that_the_watchdog_ended_has_a_result(self):
        error = self.error_of("watchdog", metabuffer.WatchdogError)
        self.assertRegex(str(error), "^scenario: the watchdog ended the run.*\n  composer_1_1 waits for a pixel$")
        self.assertEqual(error.result.report["watchdog"], ["composer_1_1 waits for a pixel"])
        self.assertEqual([len(display) for display in error.result.displays], [2, 2])

    def test_a_checked_run_that_is_wrong_has_a_result(self):
        error = self.error_of("picture", metabuffer.CheckError, level="tlm", check=True)
        self.assertIn("display 2", str(error))
        self.assertGreater(error.result.report["check"]["violations"], 0)

    def test_a_crash_is_a_row_of_a_sweep(self):
        pathlib.Path("sweep.yaml").write_text("{scenario: scenario.yaml, axes: [{key: name, values: [crash, fine]}]}")
        pathlib.Path("scenario.yaml").write_text(metabuffer.run(small_machine.scenario(name="fine")).effective_scenario)
        table = metabuffer.sweep("sweep.yaml")
        self.assertEqual(dict(zip(table["name"], table["status"])), {"crash": "crashed", "fine": "done"})

    def test_a_crash_in_one_thread_does_not_affect_the_others(self):
        outcomes = []

        def work(name):
            for _ in range(4):
                try:
                    outcomes.append(metabuffer.run(small_machine.scenario(name=name)).report["scenario"])
                except metabuffer.CrashError:
                    outcomes.append("crashed")

        threads = [threading.Thread(target=work, args=(name,)) for name in ("crash", "fine", "crash", "fine")]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(sorted(outcomes), 8 * ["crashed"] + 8 * ["fine"])


if __name__ == "__main__":
    unittest.main()
