#!/usr/bin/env python3
"""Has IceT judge level functional: every scenario that it can composite, and random walls.

usage: icet_test.py JUDGE [SEED]

Each scenario is a run of MPI with a process for each renderer. A line for each frame says how large the wall is, how many
pixels a renderer has won alone and how many tie, and how many milliseconds IceT, level functional and a bare loop over the
images take for it.
"""

import os
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
WALLS = 100  # of each number of renderers
RENDERERS = (1, 2, 3, 5, 8)
TIMEOUT_SECONDS = 600
# More processes than cores, as any user, and each gives its core away while it waits.
ENVIRONMENT = {**os.environ, "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
               "OMPI_MCA_rmaps_base_oversubscribe": "1", "OMPI_MCA_mpi_yield_when_idle": "1",
               "OMPI_MCA_hwloc_base_binding_policy": "none", "OMPI_MCA_btl_vader_single_copy_mechanism": "none"}


def judged(judge, ranks, *words):
    """Whether the judge has found everything equal."""
    done = subprocess.run(["mpiexec", "-n", str(ranks), judge, *map(str, words)], env=ENVIRONMENT, check=False,
                          timeout=TIMEOUT_SECONDS)
    if done.returncode != 0:
        print(f"failed (status {done.returncode}): mpiexec -n {ranks} {judge} {' '.join(map(str, words))}", file=sys.stderr)
    return done.returncode == 0


def main():
    judge = pathlib.Path(sys.argv[1]).resolve()
    seed = int(sys.argv[2]) if len(sys.argv) > 2 else 1
    results, left_out = [], []
    print("pixels of the wall, ms a frame".rjust(91), flush=True)
    print(f"{'scenario':28} {'raster':>14} {'r.':>2} {'won':>9} {'tied':>6} {'IceT':>9} {'functional':>11} {'bare loop':>10}",
          flush=True)
    for scenario in sorted((ROOT / "scenarios").glob("*.yaml")):
        ranks = int(subprocess.run([judge, "--ranks", scenario], check=True, stdout=subprocess.PIPE, text=True).stdout)
        if ranks:
            results.append(judged(judge, ranks, scenario))
        else:
            left_out.append(scenario.stem)
    scenarios = len(results)
    for renderers in RENDERERS:
        results.append(judged(judge, renderers, "--random", seed, WALLS))
    if left_out:
        print(f"left out, since IceT would need too many processes or another composition: {', '.join(left_out)}")
    print(f"{scenarios} scenarios and {len(RENDERERS) * WALLS} random walls, {results.count(False)} runs with differences")
    return 0 if scenarios and all(results) else 1


if __name__ == "__main__":
    sys.exit(main())
