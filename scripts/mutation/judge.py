"""Runs the tests, with a mutant or without, and so judges the mutants."""

import collections
import json
import os
import pathlib
import re
import subprocess
import tempfile
import time
from typing import Callable, Optional

from lib.parallel import Children
from mutation.mutants import Mutant
from mutation.switches import LARGEST_NUMBER
from mutation.tree import Tree

MEMORY_BYTES = 6 * 2**30
FILE_BYTES = 2 * 2**30
TESTS_OF_A_BATCH = 4
STEADY = ("unit", "rtl", "tlm", "monitors", "system")  # kinds of tests that do not depend on a wall clock
QUICK_SECONDS = 1  # tests up to this long run on all mutants before any longer test
SURVEY_SECONDS = 1200


class Test:
    """One test of CTest's."""

    def __init__(self, entry: dict):
        self.name = entry["name"]
        self.command = entry["command"]
        properties = {one["name"]: one["value"] for one in entry.get("properties", [])}
        self.directory = properties.get("WORKING_DIRECTORY")
        self.slow = "slow" in properties.get("LABELS", [])
        self.environment = dict(one.split("=", 1) for one in properties.get("ENVIRONMENT", []))
        self.seconds = 0.0
        self.repetition = False
        self.reached: set[int] = set()

    @property
    def kind(self) -> str:
        """The word before the colon of the name: unit, rtl, tlm, system, program."""
        return self.name.split(":")[0] if ":" in self.name else "test"

    def quick(self) -> bool:
        return self.seconds <= QUICK_SECONDS and not self.repetition

    def distance(self, mutant: Mutant) -> int:
        """Smaller for tests that are likelier to notice the mutant."""
        file = pathlib.PurePosixPath(mutant.file)
        own = file.stem in self.name or file.stem.replace("_", " ") in self.name
        order = {"unit": 1, "rtl": 2, "tlm": 3, "system": 4}.get(self.kind, 5)
        if own and not self.slow:
            order = 0
        return order + (10 if self.slow or self.repetition else 0)


class Judge:
    """Runs the tests; one object for all threads."""

    def __init__(self, tree: Tree):
        self.tree, self.options = tree, tree.options
        self.build = tree.directory / "build"
        self.scratch = tree.directory / "scratch"
        self.scratch.mkdir(parents=True, exist_ok=True)
        self.children = Children()
        self.kills: collections.Counter = collections.Counter()  # by the mutant's file and the test
        self.seconds: collections.Counter = collections.Counter()  # by judge
        listed = subprocess.run(["ctest", "--show-only=json-v1"], cwd=self.build, stdout=subprocess.PIPE, check=True)
        self.tests = [Test(entry) for entry in json.loads(listed.stdout)["tests"]
                      if "command" in entry and "_NOT_BUILT" not in entry["name"]
                      and not (self.options.target and self.foreign(entry["command"]))]
        self.tests = [test for test in self.tests if self.options.slow or not test.slow]
        if self.options.judges:
            self.tests = [test for test in self.tests if any(find.search(test.name) for _, find in self.options.judges)]
        self.put_repetitions_last()

    def put_repetitions_last(self) -> None:
        """Finds tests that differ only in a number, such as a seed. All but the first of them come last."""
        seen: collections.Counter = collections.Counter()
        for test in self.tests:
            family = re.sub(r"\d+", "N", test.name)
            seen[family] += 1
            test.repetition = seen[family] > TESTS_OF_A_BATCH

    def foreign(self, command: list[str]) -> bool:
        """Whether the command is no program among the targets to build."""
        return pathlib.PurePath(command[0]).name not in self.options.target

    def run(self, test: Test, mutant: int, limit_seconds: float, reached: Optional[str] = None) -> str:
        """How the test ended: passed, failed or timeout."""
        with tempfile.TemporaryDirectory(dir=self.scratch, ignore_cleanup_errors=True) as temporary:
            os.chmod(temporary, 0o755)  # some tests read it as another user
            environment = dict(os.environ, **test.environment, TMPDIR=temporary, METABUFFER_MUTANT=str(mutant))
            environment.pop("METABUFFER_SEED", None)
            if reached:
                environment["METABUFFER_MUTANTS_REACHED"] = reached
            status, _, _ = self.children.run(
                ["prlimit", f"--as={MEMORY_BYTES}", f"--fsize={FILE_BYTES}", "--core=0", *test.command],
                limit_seconds, cwd=test.directory or self.build, env=environment, stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL)
            if status is None:
                return "timeout"
            return "passed" if status == 0 else "failed"

    def survey(self, test: Test) -> bool:
        """Runs a test without mutants; notes its time and the mutants that it reaches. Returns whether it passes."""
        with tempfile.NamedTemporaryFile(dir=self.scratch) as file:
            file.truncate(LARGEST_NUMBER + 1)
            started = time.monotonic()
            verdict = self.run(test, 0, SURVEY_SECONDS, file.name)
            test.seconds = time.monotonic() - started
            content = pathlib.Path(file.name).read_bytes()
            test.reached = {mutant.number for mutant in self.tree.mutants if content[mutant.number]}
        return verdict == "passed"

    def try_quick(self, mutant: Mutant) -> None:
        self.try_tests(mutant, lambda test: test.quick())
        mutant.met = "quick"

    def try_rest(self, mutant: Mutant) -> None:
        # Not those that take long: in a run that goes on, other tests may be the quick ones.
        ran = set(mutant.ran)
        self.try_tests(mutant, lambda test: test.name not in ran)
        mutant.met = "all"

    def try_judges(self, mutant: Mutant) -> None:
        """Lets each judge's tests run on the mutant until one of them fails. All judges have killed it, or it survives."""
        for name, find in self.options.judges:
            started = time.monotonic()
            before = len(mutant.tests)
            self.try_tests(mutant, lambda test, find=find: find.search(test.name))
            self.seconds[name] += time.monotonic() - started
            if len(mutant.tests) > before:
                mutant.killers[name] = mutant.tests[before]
        mutant.killed = len(mutant.killers) == len(self.options.judges)
        mutant.met = "judges"

    def try_tests(self, mutant: Mutant, wanted: Callable[[Test], bool]) -> None:
        """Runs the tests that reach the mutant until one fails: the nearest first, and of those as near as each other
        the ones that have killed most mutants of the same file in the least time."""
        tests = [test for test in self.tests if mutant.number in test.reached]
        mutant.reached_by = len(tests)

        def order(test: Test) -> tuple[int, float]:
            return test.distance(mutant), test.seconds / (1 + self.kills[mutant.file, test.name])

        for test in sorted(filter(wanted, tests), key=order):
            limit = self.options.timeout + 10 * test.seconds
            ended = self.run(test, mutant.number, limit)
            mutant.ran.append(test.name)
            # A test that depends on wall time may fail on a busy machine. It kills only if it fails twice.
            if ended == "passed" or (test.kind not in STEADY and self.run(test, mutant.number, limit) == "passed"):
                continue
            self.kills[mutant.file, test.name] += 1
            if not mutant.killed:
                mutant.killed, mutant.kind = True, test.kind
            mutant.tests.append(test.name + (" (hangs)" if ended == "timeout" else ""))
            if not self.options.all_tests:
                break
