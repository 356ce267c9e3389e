"""Where the project is, and how its release build is brought up to date."""

import argparse
import pathlib
import subprocess
import sys
from typing import Optional

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
RELEASE = ROOT / "build/release"
PROGRAM = RELEASE / "metabuffer"
SCRIPT = pathlib.Path(sys.argv[0]).name  # what messages begin with


def build(*targets: str) -> None:
    """Builds targets as the bash scripts do, so that nothing is configured twice. Ends the script if that fails."""
    done = subprocess.run(["bash", "-c", 'set -euo pipefail; source scripts/common.bash; build_programs "$@"',
                           SCRIPT, *targets], cwd=ROOT, check=False)
    if done.returncode != 0:
        sys.exit(1)


def add_program_option(parser: argparse.ArgumentParser, name: str) -> None:
    parser.add_argument("--program", metavar="FILE", type=pathlib.Path,
                        help=f"a {name} that is built already (default: build/release is brought up to date)")


def program_of(given: Optional[pathlib.Path], path: pathlib.Path, *others: str) -> pathlib.Path:
    """The program that --program names. Without it, builds that of the release build, and other targets."""
    if given is not None:
        return given.resolve()
    build(path.name, *others)
    return path
