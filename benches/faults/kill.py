#!/usr/bin/env python3
"""Kills `prt` 100 times at random moments, and looks at what is left.

    benches/faults/kill.py target/release/prt [--times 100] [--seed 0]

Every command goes on where the last one was killed, in one folder. After each kill: an output that is being replaced is the old
file or the whole new one, results.csv parses and has no fewer rows, trials.csv has no fewer whole lines, and `prt info` reads
every .prt there is. Files of killed processes do not pile up: there is at most one in a folder, and none after a run that was not
killed. Needs Python 3.9 and nothing else."""

import argparse
import csv
import pathlib
import random
import signal
import subprocess
import sys
import tempfile
import time

PRECOMPUTED = "teapot --signal diffuse --vertices 1000 --basis cubemap:16"
# Commands, each with the outputs that it replaces.
COMMANDS = {
    "encode": ("encode cpca:clusters=64 T.npz -o T.prt", ["T.prt"]),
    "encode, large": ("encode f16 T.npz -o large.prt", ["large.prt"]),
    "precompute .npz": (f"precompute {PRECOMPUTED} -o T.npz", ["T.npz"]),
    "precompute .npy": (f"precompute {PRECOMPUTED} -o T.npy", ["T.npy"]),
    "decode": ("decode large.prt -o decoded.npy", ["decoded.npy"]),
    "bench": ("bench --quick --signal glossy --no-pictures --out bench", []),
    "select": ("select T.npz --max-error 1e-3 --method vq --method pca --method truncate --out select -o selected.prt", ["selected.prt"]),
}
# Commands that keep what is finished: they are killed until one comes to its end.
KEEPING = ["bench", "select"]


# Models that `prt info` has read, and when they were written.
READ = {}


class Broken(Exception):
    pass


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("prt", type=pathlib.Path)
    parser.add_argument("--times", type=int, default=100)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    prt, random_of = options.prt.resolve(), random.Random(options.seed)
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        # What every run must come to, and how long it takes.
        whole, seconds = {}, {}
        for name in ["precompute .npz", "encode, large", *COMMANDS]:
            arguments, outputs = COMMANDS[name]
            began = time.monotonic()
            subprocess.run([prt, *arguments.split()], cwd=folder, check=True, stdout=subprocess.DEVNULL)
            seconds[name] = time.monotonic() - began
            for output in outputs:
                whole[output] = (folder / output).read_bytes()
        for kept in ["bench", "select"]:
            subprocess.run(["rm", "-r", folder / kept], check=True)
        counts = {name: Counts() for name in COMMANDS}
        try:
            while (kills := sum(count.kills for count in counts.values())) < options.times:
                killed(prt, folder, whole, seconds, random_of, counts)
                if sys.stderr.isatty():
                    print(f"\r{kills}", end="", file=sys.stderr)
            # Whatever was killed last comes to its end now, and to the same.
            for name, (arguments, outputs) in COMMANDS.items():
                subprocess.run([prt, *arguments.split()], cwd=folder, check=True, stdout=subprocess.DEVNULL)
                for output in outputs:
                    if (folder / output).read_bytes() != whole[output]:
                        raise Broken(f"{output} differs after all")
            if parts := leftovers(folder):
                raise Broken(f"left after the last run: {parts}")
            told = None
        except KeyboardInterrupt:
            told = "interrupted"
        except Broken as broken:
            told = str(broken)
        print(f"{'command':16} {'kills':>6} {'too late':>9} {'old file':>9} {'new file':>9} {'half written':>13} {'rows kept':>10}")
        for name, count in counts.items():
            print(f"{name:16} {count.kills:6} {count.late:9} {count.old:9} {count.new:9} {count.parts:13} {count.rows or '':>10}")
        sys.exit(told)


class Counts:
    kills = late = old = new = parts = rows = 0


def killed(prt, folder, whole, seconds, random_of, counts):
    """Kills one command at a random moment, and checks everything."""
    name = random_of.choice(list(COMMANDS))
    (arguments, outputs), count = COMMANDS[name], counts[name]
    if name not in KEEPING:
        # Recognised below, whichever command reads it.
        for output in outputs:
            old(folder / output, whole[output], random_of)
    before = {output: (folder / output).read_bytes() for output in outputs if (folder / output).exists()}
    rows_before = rows(folder)
    moment = random_of.uniform(0, seconds[name])
    child = subprocess.Popen([prt, *arguments.split()], cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    time.sleep(moment)
    child.kill()
    said = child.communicate()[1].decode()
    if child.returncode == 0:
        count.late += 1
        # Faster than it was: the next one comes sooner.
        seconds[name] = max(moment, 0.05)
    elif child.returncode != -9:
        raise Broken(f"{name} failed after an earlier kill: {said}")
    else:
        count.kills += 1
    for output in outputs:
        now = (folder / output).read_bytes() if (folder / output).exists() else None
        if now == whole[output] and before.get(output) != now:
            count.new += 1
        elif now == before.get(output):
            count.old += 1
        else:
            raise Broken(f"{name}: {output} is neither the old file nor the new one")
    rows_now = rows(folder)
    for path, old_rows in rows_before.items():
        if rows_now.get(path, 0) < old_rows:
            raise Broken(f"{name}: {path} had {old_rows} rows and has {rows_now.get(path, 0)}")
    if name in KEEPING:
        count.rows += sum(rows_now.values()) - sum(rows_before.values())
        if child.returncode == 0:
            # Begun anew, so that there is something to kill.
            subprocess.run(["rm", "-r", folder / name], check=True)
    parts = leftovers(folder)
    count.parts += any(parts)
    for place in {part.parent for part in parts}:
        if sum(part.parent == place for part in parts) > 1:
            raise Broken(f"{name}: files pile up: {parts}")
    for path in folder.rglob("*.prt"):
        # Each once, as long as it stays the same.
        stamp = (path.stat().st_mtime_ns, path.stat().st_size)
        if READ.get(path) == stamp:
            continue
        READ[path] = stamp
        read = subprocess.run([prt, "info", path], cwd=folder, capture_output=True)
        if read.returncode != 0:
            raise Broken(f"{name}: {path}: {read.stderr.decode()}")


def old(path, bytes_whole, random_of):
    """Puts an older output in place: the new one itself where another command reads it, else something of another length or nothing."""
    if path.name in ("T.npz", "large.prt"):
        path.write_bytes(bytes_whole)
    elif path.suffix == ".prt":
        # Readable, and not the new one.
        path.write_bytes((path.parent / "large.prt").read_bytes())
    elif random_of.random() < 0.5:
        path.write_bytes(b"old")
    elif path.exists():
        path.unlink()


def rows(folder):
    """Whole lines of every CSV that is added to; results.csv has no others."""
    counted = {}
    for path in [folder / "bench" / "results.csv", folder / "select" / "trials.csv"]:
        if path.exists():
            with open(path, newline="", encoding="utf-8") as file:
                lines = list(csv.reader(file))
            whole = [line for line in lines[1:] if len(line) == len(lines[0])]
            if path.name == "results.csv" and len(whole) < len(lines) - 1:
                raise Broken(f"{path} has a line that is cut short")
            counted[path] = len(whole)
    return counted


def leftovers(folder):
    return [path for path in folder.rglob(".prt-*")]


if __name__ == "__main__":
    main()
