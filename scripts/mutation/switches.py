"""Puts mutants into a source file, each behind a switch, so that one build has them all."""

import difflib
from typing import NamedTuple

from mutation.mutants import Edit, Mutant
from mutation.sites import Site

HEADER = "mutation_switch.h"
LARGEST_NUMBER = 2**16 - 1  # of a mutant

HEADER_TEXT = """#pragma once
#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cstdlib>

namespace mutation {

inline int selected_mutant() {
    const char* text = std::getenv("METABUFFER_MUTANT");
    return text != nullptr ? std::atoi(text) : 0;
}

/// A byte for each mutant, in a file that outlives the process however it ends.
inline volatile char* reached_bytes() {
    const char* name = std::getenv("METABUFFER_MUTANTS_REACHED");
    if (name == nullptr) return nullptr;
    const int file = open(name, O_RDWR);
    if (file < 0) return nullptr;
    void* bytes = mmap(nullptr, MUTANT_BYTES, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
    close(file);
    return bytes == MAP_FAILED ? nullptr : static_cast<volatile char*>(bytes);
}

inline const int selected = selected_mutant();
inline volatile char* const reached = reached_bytes();

inline bool active_now(int mutant) {
    if (reached != nullptr) reached[mutant] = 1;
    return mutant == selected;
}

/// What the compiler computes is not mutated.
constexpr bool active(int mutant) { return __builtin_is_constant_evaluated() ? false : active_now(mutant); }

}  // namespace mutation
""".replace("MUTANT_BYTES", str(LARGEST_NUMBER + 1))


class Span(NamedTuple):
    """A piece of the source, and the mutants that replace it with their texts."""

    start: int
    end: int
    form: str
    chain: list[tuple[Mutant, str]]


class Copy:
    """A source file with mutants in it."""

    def __init__(self, file: str, source: str, sites: list[Site]):
        self.file, self.source, self.sites = file, source, sites
        self.mutants: list[Mutant] = []

    def span_of(self, edit: Edit) -> tuple[int, int, str]:
        """The piece to replace: the site around the edit, or the edit's own."""
        for site in self.sites:
            if site.start <= edit.start and edit.end <= site.end:
                return site.start, site.end, site.form
        return edit.start, edit.end, edit.form

    def spans(self) -> list[Span]:
        """Disjoint spans: one that contains others takes their mutants."""
        edits = [(edit, mutant) for mutant in self.mutants if not mutant.discarded for edit in mutant.edits]
        wholes = {(start, end): form for start, end, form in (self.span_of(edit) for edit, _ in edits)}
        spans = []
        for (start, end), form in sorted(wholes.items()):
            if any(other != (start, end) and other[0] <= start and end <= other[1] for other in wholes):
                continue
            chain = [(mutant, self.source[start:edit.start] + edit.text + self.source[edit.end:end])
                     for edit, mutant in edits if start <= edit.start and edit.end <= end]
            spans.append(Span(start, end, form, chain))
        return spans

    def render(self) -> tuple[str, dict[int, Mutant]]:
        """The text to compile, and which mutant each of its lines belongs to."""
        lines_of: dict[int, Mutant] = {}
        out, copied = f'#include "{HEADER}"\n', 0

        def put(mutant: Mutant, text: str) -> None:
            nonlocal out
            first = out.count("\n") + 1
            out += text
            for line in range(first, out.count("\n") + 1):
                lines_of[line] = mutant

        for start, end, form, chain in self.spans():
            out += self.source[copied:start]
            original = self.source[start:end]
            if form == "statement":
                out += "{\n"
                for mutant, text in chain:
                    put(mutant, f"if (::mutation::active({mutant.number})) {{ {text} }} else\n")
                out += f"{{ {original} }}}}"
            else:
                cast = "static_cast<bool>" if form == "condition" else ""
                out += "(\n"
                for mutant, text in chain:
                    put(mutant, f"::mutation::active({mutant.number}) ? {cast}({text}) :\n")
                out += f"{cast}({original}))"
            copied = end
        return out + self.source[copied:], lines_of

    def difference(self, mutant: Mutant) -> str:
        """A mutant as a patch of the file."""
        changed = self.source
        for edit in sorted(mutant.edits, reverse=True):
            changed = changed[:edit.start] + edit.text + changed[edit.end:]
        lines = difflib.unified_diff(self.source.splitlines(True), changed.splitlines(True), self.file, self.file)
        return "".join(lines)

    def line_of(self, mutant: Mutant) -> int:
        return self.source.count("\n", 0, min(edit.start for edit in mutant.edits)) + 1

    def describe(self, mutant: Mutant) -> str:
        return (f"{mutant.number}: {self.file}:{self.line_of(mutant)}: {mutant.operator}: {mutant.key.original}  ->  "
                f"{mutant.key.replacement}")


def number(mutants: list[Mutant]) -> None:
    """Numbers come from the mutants' texts, so that a change elsewhere changes neither them nor what is compiled."""
    taken = set()
    for mutant in mutants:
        wanted = int.from_bytes(mutant.digest()[:8], "big") % LARGEST_NUMBER + 1
        while wanted in taken:
            wanted = wanted % LARGEST_NUMBER + 1
        taken.add(wanted)
        mutant.number = wanted
