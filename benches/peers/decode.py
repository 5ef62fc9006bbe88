"""Decodes .prt files and computes their errors and sizes anew, sharing no code with `prt`: written from docs/format.md alone.

    pip install -r benches/peers/requirements.txt        # NumPy, and zstandard unless Python is 3.14
    python benches/peers/decode.py T.prt -o T.npy         # rows x lights, or samples x responses x lights
    python benches/peers/decode.py T.prt --compare T.npz [--light sky=sky.npy]     # errors and sizes as one JSON object
    python benches/peers/decode.py --jobs 2 < jobs.json   # what `prt bench --verify` runs

Errors are those of the columns of results.csv: Σ(T-T̃)²/ΣT² plain and over the sphere, max |T-T̃|, and of output relit by lights of radiance, lights x
channels; all in f64, by blocks of rows. `resident_bytes` is what docs/format.md says relighting holds. A job is an object with `file`, and if it is to be
compared `matrix` and `relit`, paths of lights by name; for each an object is printed on a line of its own, with its number as `job`, and with `failure`, a
sentence, in place of figures where there are none.
"""

import argparse
import json
import os
import sys

if "--jobs" in sys.argv:
    # One process for each core, one thread for each process.
    for library in ("OMP", "OPENBLAS", "MKL"):
        os.environ.setdefault(f"{library}_NUM_THREADS", "1")

try:
    import numpy as np
except ImportError:
    sys.exit("decode.py needs NumPy: pip install numpy")

from concurrent.futures import ProcessPoolExecutor, as_completed
from functools import lru_cache

from prtfile.container import File, unzstd
from prtfile.figures import Reference, figures
from prtfile.codecs import rows_of
from prtfile.rows import read_matrix


@lru_cache(maxsize=1)
def reference(path):
    """Jobs of one matrix follow each other."""
    return Reference(read_matrix(path))


def read_lights(paths):
    lights = {name: np.load(path).astype(float) for name, path in paths.items()}
    return {name: light.reshape(len(light), -1) for name, light in lights.items()}


def decode(path, output):
    """Writes what a file stands for, in the shape in which it came."""
    file = File(path)
    rows = rows_of(file)
    shape = (file.samples, file.responses, file.lights) if file.layout == 2 else (file.rows, file.lights)
    out = np.lib.format.open_memmap(output, "w+", np.float32, shape).reshape(file.rows, file.lights)
    step = 256 * file.responses
    for begin in range(0, file.rows, step):
        end = min(begin + step, file.rows)
        out[begin:end] = rows.block(begin, end)


def job(number, work):
    """The figures of one job, or why there are none."""
    try:
        matrix = reference(work["matrix"]) if "matrix" in work else None
        return {"job": number, **figures(work["file"], matrix, read_lights(work.get("relit", {})))}
    except Exception as error:  # a broken file must not end the other jobs
        return {"job": number, "failure": f"{error}" if isinstance(error, ValueError) else f"{type(error).__name__}: {error}"}


def jobs(works, processes):
    """Prints a line for each job as it ends, those of one matrix after those of another."""
    order = sorted(range(len(works)), key=lambda i: works[i].get("matrix", ""))
    with ProcessPoolExecutor(processes) as pool:
        for done in as_completed([pool.submit(job, i, works[i]) for i in order]):
            print(json.dumps(done.result()), flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file", nargs="?", metavar="FILE.prt")
    parser.add_argument("-o", "--output", metavar="T.npy", help="write what the file stands for")
    parser.add_argument("--compare", metavar="T.npz", help="print errors against this matrix, .npz or .npy, and sizes")
    parser.add_argument("--light", metavar="NAME=LIGHT.npy", action="append", default=[], help="compare relit output too")
    cores = os.cpu_count()
    parser.add_argument("--jobs", metavar="N", type=int, nargs="?", const=cores, help="read a JSON array of jobs from standard input; do N at once")
    arguments = parser.parse_args()
    unzstd()
    if arguments.jobs:
        jobs(json.load(sys.stdin), arguments.jobs)
        return
    if not arguments.file:
        parser.error("a FILE.prt, or --jobs")
    try:
        if arguments.output:
            decode(arguments.file, arguments.output)
        if arguments.compare or not arguments.output:
            lights = read_lights(dict(light.split("=", 1) for light in arguments.light))
            print(json.dumps(figures(arguments.file, arguments.compare and reference(arguments.compare), lights), indent=1))
    except (OSError, ValueError) as error:
        sys.exit(f"decode.py: {arguments.file}: {error}")


if __name__ == "__main__":
    main()
