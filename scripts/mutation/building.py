"""Configures and builds trees with CMake."""

import pathlib
import shutil
import subprocess

from mutation.stop import Stop


def run_quietly(command: list) -> subprocess.CompletedProcess:
    return subprocess.run(list(map(str, command)), stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, text=True, errors="replace", check=False)


def configure(source: pathlib.Path, build: pathlib.Path) -> None:
    """An index beyond a container, and the value of an empty optional, end a test."""
    command = ["cmake", "-S", source, "-B", build, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Debug",
               "-DCMAKE_CXX_FLAGS_DEBUG=-O1", "-DCMAKE_CXX_FLAGS=-w -D_GLIBCXX_ASSERTIONS",
               "-DMETABUFFER_BROWSER_TESTS=OFF", "-DMETABUFFER_UNITY=OFF", "-DCMAKE_EXPORT_COMPILE_COMMANDS=ON"]
    if shutil.which("ccache"):
        command.append("-DCMAKE_CXX_COMPILER_LAUNCHER=ccache")
    done = run_quietly(command)
    if done.returncode != 0:
        raise Stop(f"cannot be configured:\n{done.stdout}")


def build(directory: pathlib.Path, jobs: int, targets: list[str]) -> tuple[bool, str]:
    """Whether all could be built, and the output. Goes on after errors, to find them all."""
    done = run_quietly(["cmake", "--build", directory, "--parallel", jobs, *(["--target", *targets] if targets else []),
                        "--", "-k", "0"])
    return done.returncode == 0, done.stdout
