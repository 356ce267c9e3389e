"""How a configured build compiles its sources: CMake's compile_commands.json."""

import json
import pathlib
import shlex

# The options of a compile command that affect what the sources mean. CMake gives no relative paths.
MEANINGFUL = ("-I", "-D", "-U", "-std=", "-isystem", "-iquote", "-include")


def arguments_of(command: str) -> list[str]:
    words, kept = shlex.split(command), []
    for index, word in enumerate(words):
        if word.startswith(MEANINGFUL):
            kept.append(word)
        elif index and words[index - 1] in MEANINGFUL:
            kept.append(word)  # the DIR of -isystem DIR
    return kept


def arguments_by_source(build: pathlib.Path) -> dict[str, list[str]]:
    entries = json.loads((build / "compile_commands.json").read_text())
    return {entry["file"]: arguments_of(entry["command"]) for entry in entries}
