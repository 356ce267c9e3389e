"""Mutants: what identifies one, which ones there are, and the choice among them."""

import collections
import hashlib
import math
import pathlib
import re
from typing import Any, Iterable, Iterator, NamedTuple, Union

from mutation.sites import Site

# Files whose paths begin so are mutated. The number is the weight of a block there in the choice of mutants.
WEIGHTS = {"model/rtl/": 4, "model/datapath/": 4, "model/formats/": 4, "model/functional/": 3, "model/tlm/": 2,
           "model/simulation/trace_window": 4,
           "model/report/report.cpp": 1, "model/report/report_json": 1, "model/report/report_difference": 1,
           "model/report/machine_report": 1,
           "model/scenario/scenario_rules": 2, "model/scenario/derived_timing": 2, "model/scenario/limits": 2,
           "model/scenario/scenario.h": 2, "model/scenario/colour_table_file": 1, "model/images/image_reader": 1}


class Key(NamedTuple):
    """What identifies a mutant as long as its own statement does not change.

    White space in the texts is squeezed. occurrence counts the sites of the same text in the file before this one; of a
    mutant written by hand it says what the mutant does.
    """

    file: str
    original: str
    replacement: str
    occurrence: Union[int, str]


class Edit(NamedTuple):
    start: int
    end: int
    form: str
    text: str


class Candidate(NamedTuple):
    """A mutant that an operator makes of a site."""

    key: Key
    operator: str
    edit: Edit


def squeezed(text: str) -> str:
    return re.sub(r"\s+", " ", text).strip()


def key_of(file: str, original: str, replacement: str, occurrence: Union[int, str]) -> Key:
    return Key(file, squeezed(original), squeezed(replacement), occurrence)


def digest(*words: Any) -> bytes:
    return hashlib.sha256("|".join(map(str, words)).encode()).digest()


def candidates_of(file: str, source: str, sites: Iterable[Site]) -> Iterator[Candidate]:
    """Every mutant that the operators make of a file."""
    seen: collections.Counter = collections.Counter()
    for site in sites:
        original = source[site.start:site.end]
        occurrence = seen[squeezed(original)]
        seen[squeezed(original)] += 1
        known = set()
        for change in site.changes:
            text = source[site.start:change.start] + change.text + source[change.end:site.end]
            if text not in known:
                known.add(text)
                yield Candidate(key_of(file, original, text, occurrence), change.operator,
                                Edit(site.start, site.end, site.form, text))


def block_of(file: str) -> str:
    parts = pathlib.PurePosixPath(file)
    return str(parts.relative_to("model").with_suffix("")) if parts.parts[0] == "model" else str(parts.with_suffix(""))


def weight_of(file: str) -> int:
    return max((weight for start, weight in WEIGHTS.items() if file.startswith(start)), default=0)


def choose(candidates: Iterable[Candidate], count: int, seed: int) -> list[Candidate]:
    """Chooses from all blocks: more from larger ones, but less than in proportion. In a block, operators take turns."""
    blocks: dict[str, dict[str, list]] = collections.defaultdict(lambda: collections.defaultdict(list))
    for candidate in sorted(candidates, key=lambda one: digest(seed, *one.key)):
        blocks[block_of(candidate.key.file)][candidate.operator].append(candidate)
    orders = {}
    for block, operators in blocks.items():
        queues = [list(queue) for _, queue in sorted(operators.items())]
        order: list[Candidate] = []
        while any(queues):
            order.extend(queue.pop(0) for queue in queues if queue)
        orders[block] = order
    weights = {block: weight_of(order[0].key.file) * math.sqrt(len(order)) for block, order in orders.items()}
    # A small block has few candidates; the others share what it leaves.
    quotas: collections.Counter = collections.Counter()
    left = count
    while left > 0 and any(quotas[block] < len(order) for block, order in orders.items()):
        open_blocks = sorted((block for block, order in orders.items() if quotas[block] < len(order)),
                             key=lambda block: ((quotas[block] + 1) / weights[block], block))
        quotas[open_blocks[0]] += 1
        left -= 1
    return [candidate for block in sorted(orders) for candidate in orders[block][:quotas[block]]]


class Mutant:
    """A fault, that is edits of one file which one number switches on, and what has been found out about it."""

    def __init__(self, key: Key, operator: str, edits: list[Edit]):
        self.key, self.operator, self.edits = key, operator, edits
        self.number = 0
        self.seeds: list[int] = []  # the seeds that chose it
        self.discarded = ""  # why it takes no part
        self.reason = ""  # why it is equivalent, if that has been shown
        self.killed = False
        self.kind = ""  # the kind of the test that killed it
        self.tests: list[str] = []
        self.ran: list[str] = []  # every test that has run on it
        self.killers: dict[str, str] = {}  # the test of each judge that killed it
        self.reached_by = 0
        self.met = ""  # the tests that have run on it: empty (none), quick, all or judges

    @property
    def file(self) -> str:
        return self.key.file

    def digest(self) -> bytes:
        return digest(*self.key)

    @property
    def by_hand(self) -> bool:
        return isinstance(self.key.occurrence, str)

    @property
    def verdict(self) -> str:
        if self.discarded:
            return "discarded"
        if self.killed:
            return "killed"
        return "equivalent" if self.reason else "survived"


def made_mutant(candidate: Candidate) -> Mutant:
    return Mutant(candidate.key, candidate.operator, [candidate.edit])


def written_mutant(entry: dict, source: str) -> Mutant:
    """A mutant written by hand: file, original, replacement; or a list of such edits."""
    edits = []
    for edit in entry.get("edits", [entry]):
        original = edit["original"]
        if source.count(original) != 1:
            raise ValueError(f"stands in the file {source.count(original)} times, not once: {original}")
        start = source.index(original)
        form = "statement" if original.rstrip().endswith((";", "}")) else "value"
        edits.append(Edit(start, start + len(original), form, edit["replacement"]))
    what = entry["what"]
    first = entry.get("edits", [entry])[0]
    return Mutant(key_of(entry["file"], first["original"], first["replacement"], what), what, edits)
