"""The tree's copy with the mutants in it, and its build."""

import argparse
import collections
import json
import os
import pathlib
import re
import subprocess

from mutation import building, switches
from mutation.mutants import (Candidate, Key, Mutant, candidates_of, choose, key_of, made_mutant, weight_of,
                              written_mutant)
from mutation.reading import sites_of_tree
from mutation.sites import bytes_of, source_of
from mutation.stop import Stop
from mutation.switches import Copy

ROUNDS_OF_BUILDING = 6
UNCOMPILED = "does not compile"


def write_if_new(path: pathlib.Path, content: bytes) -> None:
    """Does not touch a file that has the content already, so that it is not compiled again."""
    if path.is_file() and path.read_bytes() == content:
        return
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(content)


def tree_files(source: pathlib.Path) -> list[str]:
    """Git's files and those not yet added; without git, every file outside build folders."""
    done = subprocess.run(["git", "-C", source, "ls-files", "--cached", "--others", "--exclude-standard", "-z", "."],
                          stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, check=False)
    if done.returncode == 0 and done.stdout:
        names = done.stdout.split("\0")
    else:
        names = [str(path.relative_to(source)) for path in source.rglob("*")
                 if path.relative_to(source).parts[0] not in ("build", ".git")]
    return sorted(name for name in set(names) if name and (source / name).is_file())


def kept(path: pathlib.Path) -> list[dict]:
    return json.loads(path.read_text()) if path.exists() else []


class Tree:
    def __init__(self, options: argparse.Namespace):
        self.options = options
        self.source, self.directory = options.source, options.directory
        self.directory.mkdir(parents=True, exist_ok=True)
        self.notes: list[str] = []  # what is wrong with the kept lists
        self.files = tree_files(self.source)
        self.copies = self.read_copies()
        candidates = [one for file, copy in self.copies.items()
                      for one in candidates_of(file, copy.source, copy.sites)]
        self.known: set[Key] = {one.key for one in candidates}  # all that can be made or is written
        self.choice = collections.Counter(one.operator for one in candidates)  # how many there are, by operator
        self.mutants = sorted([*self.written(), *self.chosen(candidates)],
                              key=lambda one: (one.file, one.edits[0].start, one.key.replacement))
        switches.number(self.mutants)
        for mutant in self.mutants:
            self.copies[mutant.file].mutants.append(mutant)
        self.mark_equivalent()

    def read_copies(self) -> dict[str, Copy]:
        wanted = [file for file in self.files if file.endswith((".cpp", ".h")) and weight_of(file)]
        sites = sites_of_tree(self.source, self.files, wanted, self.directory, self.options.jobs)
        return {file: Copy(file, source_of(self.source / file), sites[file]) for file in wanted}

    def asked_for(self, file: str) -> bool:
        return not self.options.path or file.startswith(tuple(self.options.path))

    def written(self) -> list[Mutant]:
        mutants = []
        for entry in kept(self.source / "tb/mutation/written.json"):
            try:
                mutants.append(written_mutant(entry, self.copies[entry["file"]].source))
            except (KeyError, ValueError) as error:
                self.notes.append(f"written.json: {entry.get('file')}: {error}")
        self.known.update(mutant.key for mutant in mutants)
        return [mutant for mutant in mutants if self.asked_for(mutant.file)]

    def chosen(self, candidates: list[Candidate]) -> list[Mutant]:
        asked_for = [one for one in candidates if self.asked_for(one.key.file)]
        mutants: dict[Key, Mutant] = {}
        for seed in self.options.seeds:
            for one in choose(asked_for, self.options.count, seed):
                mutants.setdefault(one.key, made_mutant(one)).seeds.append(seed)
        return list(mutants.values())

    def mark_equivalent(self) -> None:
        by_key = {mutant.key: mutant for mutant in self.mutants}
        for entry in kept(self.source / "tb/mutation/equivalent.json"):
            key = key_of(entry["file"], entry["original"], entry["replacement"], entry.get("occurrence", 0))
            if key in by_key:
                by_key[key].reason = entry["reason"]
            elif key not in self.known:
                self.notes.append(f"equivalent.json: no such mutant any more: {entry['file']}: {entry['original']}")

    def describe(self, mutant: Mutant) -> str:
        return self.copies[mutant.file].describe(mutant)

    def write(self) -> dict[str, dict[int, Mutant]]:
        """Writes the copy, with the mutants that are not discarded; returns the mutants by file and line."""
        target = self.directory / "source"
        keep = set(self.files) | {f"model/{switches.HEADER}"}
        if target.exists():
            for path in target.rglob("*"):
                if path.is_file() and str(path.relative_to(target)) not in keep:
                    path.unlink()
        lines = {}
        for file in self.files:
            content = (self.source / file).read_bytes()
            if file in self.copies and self.copies[file].mutants:
                text, lines[str(target / file)] = self.copies[file].render()
                content = bytes_of(text)
            write_if_new(target / file, content)
            if os.access(self.source / file, os.X_OK):
                (target / file).chmod(0o755)
        write_if_new(target / "model" / switches.HEADER, switches.HEADER_TEXT.encode())
        return lines

    def build(self) -> None:
        """Builds the copy. Mutants that do not compile are discarded, those of the last run before they are tried."""
        directory = self.directory / "build"
        self.discard_those_of_last_build()
        for mutant in self.mutants:
            if mutant.by_hand:  # it can be mended, so each run reports it
                mutant.discarded = ""
        for turn in range(ROUNDS_OF_BUILDING):
            lines = self.write()
            if turn == 0:  # even if there is a build: its flags may be those of an older script
                building.configure(self.directory / "source", directory)
            done, output = building.build(directory, self.options.jobs, self.options.target)
            (self.directory / "build.log").write_text(output)
            if done:
                return
            refused = self.refused(output, lines)
            if not refused:
                break
            for mutant in refused:
                mutant.discarded = UNCOMPILED
                if mutant.by_hand:
                    self.notes.append(f"written.json: does not compile: {mutant.file}: {mutant.operator}")
            print(f"{len(refused)} mutants do not compile", flush=True)
        raise Stop(f"cannot be built, see {self.directory / 'build.log'}")

    def refused(self, output: str, lines: dict[str, dict[int, Mutant]]) -> set[Mutant]:
        """The mutants that the compiler's errors belong to; if an error is in a template, those that ask for it."""
        refused, elsewhere = set(), set()
        for name, line in re.findall(r"^([^\s:]+):(\d+):\d+: +(?:(?:fatal )?error: |required from here)", output,
                                     re.MULTILINE):
            file = os.path.realpath(self.directory / "build" / name)
            mutant = lines.get(file, {}).get(int(line))
            if mutant is not None:
                refused.add(mutant)
            else:
                elsewhere.add(file)
        if not refused:  # an open bracket is noticed only after the mutant
            refused = {mutant for file in elsewhere for mutant in lines.get(file, {}).values() if mutant.by_hand}
        return refused

    def discard_those_of_last_build(self) -> None:
        refused = {Key(*one) for one in kept(self.directory / "discarded.json")}
        for mutant in self.mutants:
            mutant.discarded = UNCOMPILED if mutant.key in refused else ""

    def build_or_reuse(self) -> bool:
        """Builds, unless --no-build says that the last run's build will do. Returns whether it has built."""
        discarded = self.directory / "discarded.json"
        if self.options.no_build and discarded.exists():
            self.discard_those_of_last_build()
            return False
        self.build()
        discarded.write_text(json.dumps([mutant.key for mutant in self.mutants if mutant.discarded]))
        return True
