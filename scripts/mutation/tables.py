"""Reports of the verdicts: tables in Markdown and results in JSON."""

import collections
import pathlib
from typing import Any, Iterable

from mutation.mutants import Mutant, block_of
from mutation.stop import Stop
from mutation.tree import Tree

VERDICTS = ("killed", "equivalent", "survived")
BY_HAND = "written by hand"
KINDS = {"unit": "a unit test", "rtl": "a block's testbench at level `rtl`",
         "tlm": "a block's testbench at level `tlm`", "monitors": "a test of the monitors",
         "system": "a whole machine", "program": "the program, from outside", "other": "another test"}


def row(*cells: Any) -> str:
    return "| " + " | ".join(map(str, cells)) + " |"


def head(*cells: str, figures: int) -> list[str]:
    """A table's first two rows; its last columns are figures."""
    return [row(*cells), "| --- |" + " --- |" * (len(cells) - 1 - figures) + " ---: |" * figures]


def by_block(mutants: Iterable[Mutant]) -> str:
    """A table of verdicts by block."""
    blocks: dict[str, collections.Counter] = collections.defaultdict(collections.Counter)
    for mutant in mutants:
        if not mutant.discarded:
            blocks[block_of(mutant.file)][mutant.verdict] += 1
    lines = head("block", "mutants", *VERDICTS, figures=len(VERDICTS) + 1)
    total: collections.Counter = collections.Counter()
    for block, counts in sorted(blocks.items()):
        total.update(counts)
        lines.append(row(f"`{block}`", sum(counts.values()), *(counts[one] for one in VERDICTS)))
    lines.append(row("all", sum(total.values()), *(total[one] for one in VERDICTS)))
    return "\n".join(lines)


def by_judge(mutants: Iterable[Mutant], judges: list[str], seconds: collections.Counter) -> str:
    """A table of what each judge kills, by block."""
    blocks: dict[str, collections.Counter] = collections.defaultdict(collections.Counter)
    for mutant in mutants:
        for block in (f"`{block_of(mutant.file)}`", "all"):
            blocks[block].update(["mutants", *mutant.killers])
    lines = head("block", "mutants", *judges, figures=len(judges) + 1)
    lines += [row(block, counts["mutants"], *(counts[one] for one in judges))
              for block, counts in sorted(blocks.items(), key=lambda one: (one[0] == "all", one[0]))]
    lines.append(row("minutes of tests", "", *(f"{seconds[one] / 60:.1f}" for one in judges)))
    return "\n".join(lines)


def by_seed(tree: Tree, mutants: list[Mutant]) -> str:
    """A table of verdicts by seed. A mutant that several seeds chose is in each of their rows."""
    lines = head("seed", "mutants", *VERDICTS, figures=len(VERDICTS) + 1)
    for seed in tree.options.seeds:
        counts = collections.Counter(one.verdict for one in mutants if seed in one.seeds and not one.discarded)
        lines.append(row(seed, sum(counts.values()), *(counts[one] for one in VERDICTS)))
    return "\n".join(lines)


def by_test(mutants: Iterable[Mutant]) -> str:
    killed = [mutant for mutant in mutants if mutant.verdict == "killed"]
    counts = collections.Counter(mutant.kind if mutant.kind in KINDS else "other" for mutant in killed)
    lines = head("first killed by", "mutants", figures=1)
    lines += [row(text, counts[kind]) for kind, text in KINDS.items() if counts[kind]]
    return "\n".join(lines)


def by_operator(tree: Tree, mutants: Iterable[Mutant]) -> str:
    counts = collections.Counter(BY_HAND if mutant.by_hand else mutant.operator
                                 for mutant in mutants if not mutant.discarded)
    there_are = tree.choice + collections.Counter({BY_HAND: sum(one.by_hand for one in tree.mutants)})
    lines = head("operator", "mutants", "to choose from", figures=2)
    lines += [row(operator, counts[operator], there_are[operator]) for operator in sorted(there_are)]
    lines.append(row("all", sum(counts.values()), sum(there_are.values())))
    return "\n".join(lines)


def of_equivalents(mutants: Iterable[Mutant]) -> str:
    lines = head("file", "instead of", "stands", "reason", figures=0)

    def code(text: str) -> str:
        return "`" + text.replace("|", "\\|") + "`" if text != ";" else "nothing"
    lines += [row(f"`{block_of(mutant.file)}`", code(mutant.key.original), code(mutant.key.replacement), mutant.reason)
              for mutant in mutants if mutant.verdict == "equivalent"]
    return "\n".join(lines)


def write(path: pathlib.Path, tree: Tree, mutants: list[Mutant]) -> None:
    """Puts every table between its marks."""
    text = path.read_text()
    for name, content in {"mutants by block": by_block(mutants), "operators": by_operator(tree, mutants),
                          "tests": by_test(mutants), "equivalent mutants": of_equivalents(mutants)}.items():
        first, last = f"<!-- {name} -->", f"<!-- end of {name} -->"
        if first not in text or last not in text:
            raise Stop(f"{path} has no marks {first} and {last}", 2)
        before, after = text.split(first, 1)[0], text.split(last, 1)[1]
        text = f"{before}{first}\n{content}\n{last}{after}"
    path.write_text(text)


def results(tree: Tree, mutants: Iterable[Mutant], seconds: float) -> dict:
    return {"seconds": round(seconds), "seeds": tree.options.seeds, "to_choose_from": sum(tree.choice.values()),
            "mutants": [{
                "number": mutant.number, "file": mutant.file, "line": tree.copies[mutant.file].line_of(mutant),
                "operator": mutant.operator, "original": mutant.key.original, "replacement": mutant.key.replacement,
                "occurrence": mutant.key.occurrence, "seeds": mutant.seeds, "verdict": mutant.verdict,
                "tests": mutant.tests, "killers": mutant.killers, "met": mutant.met, "ran": mutant.ran,
                "kind": mutant.kind, "reached_by_tests": mutant.reached_by,
                "reason": mutant.reason or mutant.discarded} for mutant in mutants]}
