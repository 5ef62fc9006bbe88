"""Holds decode.py and `prt` against each other on small matrices, by labels that reach every branch of docs/format.md.

    python benches/peers/test_decode.py target/release/prt [WORD ...]       # only matrices and labels with one of the words

Every matrix is encoded by every label that takes it. What decode.py reads must be what `prt decode` writes, bit for bit what was encoded where the method is
exact, and of the sizes that `prt encode` says; errors must be those of `prt bench`. Damaged files must be refused. At the end no branch may be left that no
file took. Some minutes on two cores.
"""

import json
import os
import struct
import subprocess
import sys
import tempfile
import zlib
from concurrent.futures import ProcessPoolExecutor

for library in ("OMP", "OPENBLAS", "MKL"):
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")

import numpy as np  # noqa: E402  (the environment must be set before)

from prtfile.codecs import rows_of  # noqa: E402
from prtfile.container import Broken, File  # noqa: E402
from prtfile.figures import Reference, figures  # noqa: E402
from prtfile.rows import read_matrix  # noqa: E402
from test_cases import BRANCHES, DAMAGED, FIGURES, LABELS, Matrices, branches, run  # noqa: E402

HERE = os.path.dirname(os.path.abspath(__file__))
EXACT = ("dense", "csr", "compact", "runs", "visibility", "bicluster")
# Squared differences of what both decode, relative to the matrix: f32 against f64. Wide lobes and their coefficients amplify it.
CLOSE, CLOSE_WIDE = 1e-12, 1e-9
WIDE = ("bandwidth=3", "bandwidth=0.2", "coordinates=lobes")


def examine(prt, path, told, label):
    """Encodes a matrix and reads it both ways: the branches of the file and what is wrong, or nothing where the method does not take the matrix."""
    with tempfile.TemporaryDirectory() as folder:
        encoded = f"{folder}/T.prt"
        done = subprocess.run([prt, "encode", label, path, "-o", encoded, "--json", *told], capture_output=True, text=True)
        if done.returncode:
            return None
        return read_both(prt, encoded, folder, read_matrix(path), label, json.loads(done.stdout))


def read_both(prt, encoded, folder, matrix, label, info):
    """The branches of a file, and what is wrong with it by its matrix, by `prt decode` and by what `prt` says of its sizes."""
    try:
        file = File(encoded)
        rows = rows_of(file)
        ours = rows.block(0, file.rows)
    except Exception as error:
        return set(), [f"{type(error).__name__}: {error}"]
    decoded = f"{folder}/D.{'npz' if file.layout == 0 else 'npy'}"
    run(prt, "decode", encoded, "-o", decoded)
    theirs, matrix = read_matrix(decoded).block(0, file.rows), matrix.block(0, file.rows)
    wrong = []
    exact = label.split(":")[0] in EXACT and "max_error" not in label
    if exact and not np.array_equal(ours, matrix):
        wrong += ["not what was encoded"]
    square = np.square(ours - theirs).sum() / max(np.square(matrix).sum(), 1e-300)
    if square > (0 if exact else CLOSE_WIDE if any(word in label for word in WIDE) else CLOSE):
        wrong += [f"not what prt decode writes: {square:.1e}"]
    sizes = {"resident_bytes": int(file.resident), "file_bytes": len(file.data)}
    wrong += [f"{name} {size}, prt says {info[name]}" for name, size in sizes.items() if info[name] != size]
    return branches(file), wrong


def compare_figures(prt, folder, path, labels):
    """Errors of `prt bench` on a matrix file, which says what its rows and columns are, beside ours."""
    bench = f"{folder}/bench-{os.path.basename(path)}"
    methods = [part for label in labels for part in ("--method", label)]
    rows = json.loads(run(prt, "bench", "--quick", "--scene", path, *methods, "--out", bench, "--json"))
    encoded = {os.path.basename(name): f"{bench}/encoded/{name}" for name in os.listdir(f"{bench}/encoded")}
    reference, wrong = Reference(read_matrix(path)), []
    for row in rows:
        safe = "".join(c if c.isalnum() or c in "-_." else "_" for c in row["method"])
        (file,) = [p for name, p in encoded.items() if name.endswith(f"npz-{safe}.prt") or name.endswith(f"npy-{safe}.prt")]
        ours = figures(file, reference)
        for figure in ("error", "error_sphere", "error_max"):
            a, b = row[figure], ours[figure]
            if (a is None) != (b is None) or (a is not None and abs(a - b) > 1e-6 * abs(a) + 1e-11):
                wrong.append(f"{os.path.basename(path)} {row['method']}: {figure} is {b}, by prt {a}")
    return wrong


def damage(path):
    """Every byte of the header and many of the sections flipped, one at a time; ends cut off: what was read to something else all the same. Bits that
    zstd does not need may flip."""
    with open(path, "rb") as file:
        data = file.read()
    end = 16 + int.from_bytes(data[12:16], "little")
    places = [*range(end), *range(end, len(data), max(1, (len(data) - end) // 200))]
    broken = [data[:at] + bytes([data[at] ^ 1 << at % 8]) + data[at + 1 :] for at in places]
    broken += [data[:at] for at in (0, 8, 15, end - 1, end, len(data) - 1)] + [data + b"\0"]
    whole, wrong = File(path).sections, []
    for number, damaged in enumerate(broken):
        with open(f"{path}.broken", "wb") as file:
            file.write(damaged)
        try:
            found = File(f"{path}.broken")
        except Broken:
            continue
        if number < end or found.sections != whole:
            wrong.append(f"{found.label}: damage {number} of {len(broken)} was not noticed")
    return wrong


def crafted(path, label, tag, shape, basis, sections):
    """A file by the page, sections raw: what no command writes."""
    text = lambda form, value: struct.pack(form, len(value)) + value.encode()
    stored = [(name, array.tobytes()) for name, array in sections.items()]
    table = b"".join(text("<B", n) + struct.pack("<BQQI", 0, len(d), len(d), zlib.crc32(d)) for n, d in stored)
    header = text("<H", label) + text("<H", tag) + struct.pack("<3Q", *shape) + text("<H", basis)
    header += struct.pack("<BH", 1, len(stored)) + table
    start = b"\x89PRT\r\n\x1a\n" + struct.pack("<II", 1, len(header) + 4) + header
    with open(path, "wb") as file:
        file.write(start + struct.pack("<I", zlib.crc32(start)) + b"".join(data for _, data in stored))


def given_centres(prt, folder, random, seen):
    """Lobes of the library's, which no command takes, by either reader."""
    wrong, centres = [], random.normal(size=(9, 3))
    centres /= np.linalg.norm(centres, axis=1, keepdims=True)
    for kernel, low, high in (("gaussian", 2, 9), ("abel-poisson", 0.2, 0.7)):
        for coordinates in ("orthonormal", "lobes"):
            label = f"srbf:centers=given:kernel={kernel}:coordinates={coordinates}+dense"
            sections = {"basis/srbf-centers": centres, "basis/srbf-bandwidths": random.uniform(low, high, 9)}
            sections["weights/values"] = random.normal(size=(5, 9)).astype("<f4")
            crafted(f"{folder}/given.prt", label, "dense.1", (5, 1, 96), "cubemap:4", sections)
            run(prt, "decode", f"{folder}/given.prt", "-o", f"{folder}/given.npy")
            info = json.loads(run(prt, "info", f"{folder}/given.prt", "--json"))
            found = read_both(prt, f"{folder}/given.prt", folder, read_matrix(f"{folder}/given.npy"), label, info)
            seen |= found[0]
            wrong += [f"{label}: {what}" for what in found[1]]
    return wrong


def others(prt, folder, matrices, seen):
    """What takes more than an encoding: figures, damage, superclusters, files of old, the command line."""
    wrong, path = given_centres(prt, folder, matrices.random, seen), lambda name: matrices.files[name][0]
    for name, labels in FIGURES.items():
        wrong += compare_figures(prt, folder, path(name), labels)
    for label, name in DAMAGED.items():
        run(prt, "encode", label, path(name), "-o", f"{folder}/damaged.prt")
        wrong += damage(f"{folder}/damaged.prt")
    run(prt, "encode", "cpca:clusters=6:components=2", path("diffuse"), "-o", f"{folder}/T.prt")
    line = ["coherence", f"{folder}/T.prt", "--matrix", path("diffuse"), "--mesh", "teapot", "--vertices", "100"]
    run(prt, *line, "-o", f"{folder}/coherent.prt")
    for file in (f"{folder}/coherent.prt", f"{HERE}/../../transfer/tests/golden/csr-1.prt"):
        run(prt, "decode", file, "-o", f"{folder}/D.npz")
        info = json.loads(run(prt, "info", file, "--json"))
        found = read_both(prt, file, folder, read_matrix(f"{folder}/D.npz"), info["label"], info)
        seen |= found[0]
        wrong += found[1]
    run(sys.executable, f"{HERE}/decode.py", f"{folder}/T.prt", "-o", f"{folder}/ours.npy")
    run(prt, "decode", f"{folder}/T.prt", "-o", f"{folder}/theirs.npy")
    ours, theirs = [np.load(f"{folder}/{name}.npy") for name in ("ours", "theirs")]
    wrong += [] if ours.shape == theirs.shape and np.allclose(ours, theirs, 1e-5, 1e-7) else ["decode.py -o writes something else than prt decode"]
    return wrong


def main():
    prt, words = os.path.abspath(sys.argv[1]), sys.argv[2:]
    with tempfile.TemporaryDirectory() as folder, ProcessPoolExecutor(os.cpu_count()) as pool:
        matrices = Matrices(folder, prt)
        cases = [(m, label) for m in matrices.files for label in LABELS if not words or any(w in f"{m} {label}" for w in words)]
        results = pool.map(examine, *zip(*[(prt, *matrices.files[m], label) for m, label in cases]))
        seen, taken, wrong = set(), set(), []
        for (matrix, label), result in zip(cases, results):
            if result is not None:
                seen |= result[0]
                taken.add(label)
                report(wrong, [f"{matrix} {label}: {what}" for what in result[1]])
        if not words:
            report(wrong, others(prt, folder, matrices, seen))
            report(wrong, [f"no matrix was encoded by {label}" for label in LABELS if label not in taken])
            report(wrong, [f"no file had: {branch}" for branch in BRANCHES if branch not in seen])
    print(f"{len(taken)} labels, {len(seen)} branches, {len(wrong)} mistakes")
    sys.exit(bool(wrong))


def report(wrong, more):
    wrong += more
    print(*more, sep="\n", end="\n" if more else "", flush=True)


if __name__ == "__main__":
    main()
