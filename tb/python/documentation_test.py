"""Runs the examples of docs/python.md and of the module's docstrings, in the project's folder."""

import doctest
import importlib
import os
import re
import sys

from small_machine import SOURCE

PAGE = SOURCE / "docs/python.md"
OPTIONS = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE


def page_examples():
    """The blocks marked ```pycon, as one session; other lines are left empty, so that line numbers are the page's."""
    inside = False
    lines = []
    for line in PAGE.read_text(encoding="utf-8").splitlines():
        if line.startswith("```"):
            inside = line == "```pycon"
            line = ""
        lines.append(line if inside else "")
    return doctest.DocTestParser().get_doctest("\n".join(lines) + "\n", {}, PAGE.name, str(PAGE), 0)


def main():
    os.chdir(SOURCE)
    runner = doctest.DocTestRunner(optionflags=OPTIONS)
    runner.run(page_examples())
    module = importlib.import_module("metabuffer")
    for test in doctest.DocTestFinder().find(module):
        runner.run(test)
    # A page whose examples are no longer found would pass.
    if runner.tries < 10:
        print(f"only {runner.tries} examples were found", file=sys.stderr)
        return 1
    undocumented = [name for name in module.__all__ if not re.match("__", name) and not getattr(module, name).__doc__]
    print(f"{runner.tries} examples, {runner.failures} fail; without a docstring: {undocumented}")
    return 1 if runner.failures or undocumented else 0


if __name__ == "__main__":
    sys.exit(main())
