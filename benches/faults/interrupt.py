#!/usr/bin/env python3
"""How long `prt` takes to end after Ctrl-C, in each of its long commands.

    benches/faults/interrupt.py target/release/prt [--times 6] [--only NAME]

Each command is started, left alone for a random part of what it takes, and sent SIGINT: it must end with 130, say so in one
line, and leave neither its output nor a temporary file. Needs Python 3.9 and nothing else."""

import argparse
import pathlib
import random
import signal
import subprocess
import sys
import tempfile
import time

# Inputs: name, arguments of `prt precompute`.
INPUTS = [
    ("diffuse.npy", "teapot --signal diffuse --vertices 20000"),
    ("biscale.npz", "teapot --signal biscale --vertices 6000"),
    ("terms.npz", "teapot --signal terms --vertices 600 --terms 8"),
    ("glossy.npz", "teapot --signal glossy --vertices 20000"),
]
ON_DIFFUSE = "encode {} diffuse.npy --basis cubemap:32 -o out.prt"
ON_FIELD = "encode {} field/sphere.npy --responses radiance:128x128 --basis latlong:64x32 -o out.prt"
COMMANDS = {
    "csr": ON_DIFFUSE.format("csr"),
    "compact": "encode compact biscale.npz -o out.prt",
    "runs": "encode runs biscale.npz -o out.prt",
    "visibility": "encode visibility biscale.npz -o out.prt",
    "bicluster": "encode bicluster biscale.npz -o out.prt",
    "bicluster levels=1": "encode bicluster:levels=1 biscale.npz -o out.prt",
    "haar+truncate": ON_DIFFUSE.format("haar+truncate:energy=0.99"),
    "sh": ON_DIFFUSE.format("sh:order=16+dense"),
    "srbf": ON_DIFFUSE.format("srbf+f16"),
    "vq": ON_DIFFUSE.format("vq"),
    "pca": ON_DIFFUSE.format("pca:components=64"),
    "cpca": ON_DIFFUSE.format("cpca:clusters=64"),
    "cpca iterative": "encode cpca:mode=iterative glossy.npz -o out.prt",
    "cpca max_error": ON_DIFFUSE.format("cpca:clusters=64:max_error=1e-3"),
    "tucker": "encode tucker terms.npz -o out.prt",
    "tucker hooi": "encode tucker:mode=hooi terms.npz -o out.prt",
    "tucker coded": "encode tucker:numbers=coded terms.npz -o out.prt",
    "tucker max_error": "encode tucker:max_error=1e-2 terms.npz -o out.prt",
    "cta": "encode cta terms.npz -o out.prt",
    "srbf+cta": "encode srbf+cta terms.npz -o out.prt",
    "slf": "encode slf glossy.npz -o out.prt",
    "diffuse": "precompute teapot --signal diffuse --vertices 30000 -o out.npy",
    "bounces": "precompute cornell-box --signal diffuse --bounces 3 --vertices 3000 -o out.npz",
    "glossy": "precompute teapot --signal glossy --vertices 20000 -o out.npz",
    "terms": "precompute teapot --signal terms --vertices 3000 -o out.npy",
    "light field": "slf cornell-spheres -o out",
    "path-traced": "render cornell-spheres --reference -o out.png",
    "fit-light": "fit-light room --lobes 162 -o out.json",
    "decode": "decode model.prt -o out.npy",
    "select": "select glossy.npz --max-error 1e-3 --out out",
    "bench": "bench --out out",
    "stability": "stability biclustering --out out",
    "tables": "tables biclustering --out out",
    "figures": "figures clustered-pca --out out",
}
# A command that ends sooner leaves no moment to interrupt it.
SHORTEST = 0.1
# Of a command that would take longer only the beginning is interrupted.
LONGEST = 20.0


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("prt", type=pathlib.Path)
    parser.add_argument("--times", type=int, default=6)
    parser.add_argument("--only", action="append")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    prt, random_of = options.prt.resolve(), random.Random(options.seed)
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        for name, arguments in INPUTS:
            subprocess.run([prt, "precompute", *arguments.split(), "-o", name], cwd=folder, check=True, stdout=subprocess.DEVNULL)
        model = ON_DIFFUSE.format("f16").replace("out.prt", "model.prt")
        subprocess.run([prt, *model.split()], cwd=folder, check=True, stdout=subprocess.DEVNULL)
        print(f"{'command':20} {'whole s':>8} {'median s':>9} {'worst s':>8}  after")
        wrong = [name for name, command in COMMANDS.items() if not options.only or name in options.only
                 if not interrupted(prt, name, command.split(), folder, options.times, random_of)]
    sys.exit(f"not as promised: {', '.join(wrong)}" if wrong else 0)


def interrupted(prt, name, arguments, folder, times, random_of):
    """Interrupts one command so often, and prints a line; whether it kept its promises."""
    began = time.monotonic()
    child = start(prt, arguments, folder)
    try:
        child.wait(LONGEST)
    except subprocess.TimeoutExpired:
        child.kill()
        child.wait()
    whole = time.monotonic() - began
    clear(folder)
    latencies, kept = [], True
    for _ in range(times):
        wait = random_of.uniform(min(SHORTEST, whole / 2), 0.95 * whole)
        child = start(prt, arguments, folder)
        time.sleep(wait)
        asked = time.monotonic()
        child.send_signal(signal.SIGINT)
        said = child.communicate()[1].decode()
        latency = time.monotonic() - asked
        # It may have ended just before.
        if child.returncode != 0:
            latencies.append((latency, wait))
            parts = [path.name for path in folder.rglob(".prt-*")]
            whole_files = [path for path in folder.glob("out.*")]
            promised = child.returncode == 130 and "interrupted: " in said and said.count("\n") == 1
            if not promised or parts or whole_files:
                print(f"{name}: {child.returncode} '{said.strip()}' left {parts} {whole_files}")
                kept = False
        clear(folder)
    latencies.sort()
    if latencies:
        worst, wait = latencies[-1]
        more = "+" if whole >= LONGEST else ""
        print(f"{name:20} {whole:7.1f}{more:1} {latencies[len(latencies) // 2][0]:9.2f} {worst:8.2f}  {wait:.1f} s", flush=True)
    return kept


def start(prt, arguments, folder):
    return subprocess.Popen([prt, *arguments], cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)


def clear(folder):
    for path in sorted(folder.glob("out*"), reverse=True):
        if path.is_dir():
            subprocess.run(["rm", "-r", path], check=True)
        else:
            path.unlink()


if __name__ == "__main__":
    main()
