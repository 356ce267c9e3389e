"""Reads a tree's sources: which sites each file has.

To parse the model takes a minute or two. So the sites are kept in a file, and read from there until a source, a
CMakeLists.txt or the search itself changes.
"""

import hashlib
import json
import pathlib
import sys
import threading
from typing import Iterable

from lib.compile_commands import arguments_by_source
from lib.parallel import in_parallel
from mutation import sites as search
from mutation.building import configure
from mutation.sites import Change, Site
from mutation.stop import Stop

Sites = dict[str, list[Site]]


class Commands:
    """How a configured build compiles each source."""

    def __init__(self, build: pathlib.Path):
        self.by_path = arguments_by_source(build)

    def of(self, path: pathlib.Path) -> list[str]:
        """The arguments for a file. A header gets those of a source in its folder."""
        found = self.by_path.get(str(path))
        if found is None and path.suffix == ".h":
            found = next((arguments for other, arguments in sorted(self.by_path.items())
                          if pathlib.Path(other).parent == path.parent), None)
        if found is None:
            raise Stop(f"{path} is compiled nowhere")
        return found


class Parser:
    """Parses units and collects the sites of the wanted files; one object for all threads."""

    def __init__(self, source: pathlib.Path, commands: Commands, wanted: Iterable[str]):
        self.source, self.commands = source, commands
        self.left = {str(source / file): file for file in wanted}
        self.lock = threading.Lock()
        self.sites: Sites = {}

    def parse(self, file: str) -> None:
        """Reads the file, and each wanted header in it that no earlier unit had."""
        path = self.source / file
        arguments = self.commands.of(path)
        if path.suffix == ".h":
            arguments = ["-x", "c++", *arguments]
        try:
            unit = search.parse(str(path), arguments)
        except search.ParseError as error:
            raise Stop(str(error)) from error
        with self.lock:
            claimed = {path: self.left.pop(path) for path in search.files_of(unit) & set(self.left)}
        for path, name in claimed.items():
            self.sites[name] = search.sites_of(unit, path)

    def parse_all(self, jobs: int) -> Sites:
        sources = [file for file in self.left.values() if file.endswith(".cpp")]
        for _ in in_parallel(jobs, self.parse, sources):
            pass
        while self.left:  # headers that none of these sources includes
            self.parse(sorted(self.left.values())[0])
        return self.sites


def digest_of(source: pathlib.Path, files: list[str]) -> str:
    """A digest of all that decides which sites there are, except the system's own headers."""
    digest = hashlib.sha256(pathlib.Path(search.__file__).read_bytes())
    digest.update(str(source).encode())
    for file in files:
        if file.endswith((".cpp", ".h", ".cmake", "CMakeLists.txt")):
            digest.update(f"\0{file}\0".encode() + (source / file).read_bytes())
    return digest.hexdigest()


def sites_of_tree(source: pathlib.Path, files: list[str], wanted: list[str], directory: pathlib.Path,
                  jobs: int) -> Sites:
    kept = directory / "sites.json"
    digest = digest_of(source, [file for file in files if not file.startswith("tb/")] + wanted)
    if kept.exists():
        found = json.loads(kept.read_text())
        if found["digest"] == digest:
            return {file: [Site(*site[:3], tuple(Change(*change) for change in site[3])) for site in sites]
                    for file, sites in found["sites"].items()}
    if sys.stderr.isatty():
        print("reading the sources", file=sys.stderr)
    configure(source, directory / "commands")
    sites = Parser(source, Commands(directory / "commands"), wanted).parse_all(jobs)
    kept.write_text(json.dumps({"digest": digest, "sites": sites}))
    return sites
