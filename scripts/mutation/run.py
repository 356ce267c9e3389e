"""The run as a whole: which mutants take part, which tests run on them, and what is reported."""

import argparse
import collections
import json
import shutil
import time
from typing import Callable, Union

from lib.parallel import in_parallel
from lib.progress import Progress
from mutation import tables
from mutation.judge import Judge
from mutation.mutants import Key, Mutant
from mutation.stop import Stop
from mutation.tree import Tree


def list_mutants(tree: Tree) -> int:
    for mutant in tree.mutants:
        print(tree.describe(mutant) + (f"  (equivalent: {mutant.reason})" if mutant.reason else ""))
    for note in tree.notes:
        print(note)
    return 1 if tree.notes else 0


def only(tree: Tree, wanted: list[Union[int, str]]) -> list[Mutant]:
    """The mutants of these numbers, which are printed, and of files whose paths begin so."""
    numbers = {one for one in wanted if isinstance(one, int)}
    paths = tuple(one for one in wanted if isinstance(one, str))
    numbered = [mutant for mutant in tree.mutants if mutant.number in numbers]
    if len(numbered) < len(numbers) or any(not any(mutant.file.startswith(path) for mutant in tree.mutants)
                                           for path in paths):
        raise Stop("no such mutant among those chosen, see --list", 2)
    for mutant in numbered:
        print(tree.describe(mutant))
        print(tree.copies[mutant.file].difference(mutant))
    return [mutant for mutant in tree.mutants if mutant.number in numbers or mutant.file.startswith(paths)]


def last_run(tree: Tree) -> dict[Key, dict]:
    """What the last run, which may have been cut off, noted of each mutant."""
    path = tree.directory / "results.json"
    if not path.exists():
        raise Stop(f"no last run: {path} is not there", 2)
    return {Key(one["file"], one["original"], one["replacement"], one["occurrence"]): one
            for one in json.loads(path.read_text())["mutants"]}


def survivors(tree: Tree) -> set[Key]:
    return {key for key, noted in last_run(tree).items() if noted["verdict"] == "survived"}


def take_over_verdicts(tree: Tree) -> None:
    """Takes the verdicts of the last run, which was cut off."""
    last = last_run(tree)
    for mutant in tree.mutants:
        noted = last.get(mutant.key)
        if noted:
            mutant.killed = noted["verdict"] == "killed"
            mutant.kind, mutant.tests = noted["kind"], noted["tests"]
            mutant.met, mutant.reached_by = noted["met"], noted["reached_by_tests"]
            mutant.killers = noted.get("killers", {})  # results of an older script have neither
            mutant.ran = noted.get("ran", [])


def taking_part(tree: Tree) -> list[Mutant]:
    mutants = only(tree, tree.options.only) if tree.options.only else tree.mutants
    if tree.options.again:
        last = survivors(tree)
        mutants = [mutant for mutant in mutants if mutant.key in last]
    return mutants


def survey(judge: Judge, jobs: int) -> None:
    """Runs every test once without mutants. Those that fail take no part; too many of them end the run."""
    broken = []
    progress = Progress("tests without mutants", len(judge.tests))
    for test, passed in in_parallel(jobs, judge.survey, judge.tests, judge.children.stop):
        if not passed:
            broken.append(test)
            progress.say(f"fails without a mutant: {test.name}")
        progress.step()
    progress.finish()
    if broken and len(broken) > len(judge.tests) // 10:
        raise Stop(f"{len(broken)} tests fail without mutants")
    judge.tests = [test for test in judge.tests if test not in broken]


def save_results(tree: Tree, mutants: list[Mutant], seconds: float) -> None:
    """Writes a file that is whole at any moment, so that a run that is cut off can go on."""
    path = tree.directory / "results.json"
    part = path.with_suffix(".part")
    part.write_text(json.dumps(tables.results(tree, mutants, seconds), indent=1) + "\n")
    part.replace(path)


def try_all(tree: Tree, judge: Judge, mutants: list[Mutant], save: Callable[[], None]) -> None:
    """Runs the quick tests on all mutants, and the others on those that survive."""
    options = tree.options
    fresh = [mutant for mutant in mutants if not mutant.met]
    progress = Progress("mutants", len(fresh))
    for _ in in_parallel(options.jobs, judge.try_judges if options.judges else judge.try_quick, fresh,
                         judge.children.stop):
        progress.step()
        save()
    progress.finish()
    if options.judges:
        return
    # On known equivalents the quick tests have run, which is enough for a daily run.
    left = [mutant for mutant in mutants if mutant.met != "all"
            and (options.all_tests or not mutant.killed and (options.slow or not mutant.reason))]
    for mutant in left:
        if mutant.verdict == "survived":
            print(f"not killed by quick tests: {tree.describe(mutant)}", flush=True)
    progress = Progress("mutants that quick tests do not kill", len(left))
    for mutant, _ in in_parallel(options.jobs, judge.try_rest, left, judge.children.stop):
        if mutant.verdict == "survived":
            progress.say(f"survived {mutant.reached_by} tests: {tree.describe(mutant)}")
        progress.step()
        save()
    progress.finish()


def note_killed_equivalents(tree: Tree, mutants: list[Mutant]) -> None:
    tree.notes += [f"equivalent.json: killed by {mutant.tests[0]}: {tree.describe(mutant)}"
                   for mutant in mutants if mutant.killed and mutant.reason]


def report_judges(tree: Tree, mutants: list[Mutant], seconds: collections.Counter) -> int:
    """Prints what each judge kills, and what the first one kills and another does not. Returns the exit status."""
    first, *others = (name for name, _ in tree.options.judges)
    print(tables.by_judge(mutants, [first, *others], seconds))
    missed = 0
    for mutant in mutants:
        missing = [name for name in others if first in mutant.killers and name not in mutant.killers]
        if missing:
            missed += 1
            print(f"killed by {first} ({mutant.killers[first]}), not by {', '.join(missing)}: {tree.describe(mutant)}"
                  + (f"  (equivalent: {mutant.reason})" if mutant.reason else ""))
    print(f"{missed} mutants that {first} kills are missed")
    return 1 if missed else 0


def print_results(tree: Tree, mutants: list[Mutant], seconds: float) -> int:
    """Prints tables, notes and the sum. Returns the exit status. The mutants are those that took part and compile."""
    print(tables.by_block(mutants))
    print(tables.by_test(mutants))
    print(tables.by_seed(tree, mutants))
    for note in tree.notes:
        print(note)
    counts = collections.Counter(mutant.verdict for mutant in mutants)
    discarded = sum(1 for mutant in tree.mutants if mutant.discarded)
    print(f"{counts['killed']} killed, {counts['equivalent']} equivalent, {counts['survived']} survived, "
          f"{discarded} discarded; {seconds:.0f} s")
    return 1 if counts["survived"] or tree.notes else 0


def run(options: argparse.Namespace) -> int:
    started = time.monotonic()
    tree = Tree(options)
    if options.list:
        return list_mutants(tree)
    asked = taking_part(tree)
    print(f"{len(tree.mutants)} mutants of {len({mutant.file for mutant in tree.mutants})} files, "
          f"made by operators from {sum(tree.choice.values())} and written by hand", flush=True)
    if tree.build_or_reuse():
        print(f"built in {time.monotonic() - started:.0f} s", flush=True)
    judge = Judge(tree)
    survey(judge, options.jobs)
    mutants = [mutant for mutant in asked if not mutant.discarded]
    if options.resume:
        take_over_verdicts(tree)

    def save() -> None:
        if options.judges or not options.only:
            save_results(tree, asked, time.monotonic() - started)
    try_all(tree, judge, mutants, save)
    if options.only and not options.judges:
        for mutant in mutants:
            print(f"{mutant.verdict}: {mutant.number}: {'; '.join(mutant.tests) or mutant.reason}")
    if not options.judges:
        note_killed_equivalents(tree, mutants)
    shutil.rmtree(judge.scratch, ignore_errors=True)
    seconds = time.monotonic() - started
    save()
    if options.write_table:
        tables.write(options.write_table, tree, mutants)
    return report_judges(tree, mutants, judge.seconds) if options.judges else print_results(tree, mutants, seconds)
