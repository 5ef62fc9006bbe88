"""Throughput of PyWavelets' non-standard two-dimensional Haar transform of a transfer matrix over a cubemap, on one thread.

    python haar_pywavelets.py                 a random matrix of 1,839 rows x 6 faces x 32 x 32 texels
    python haar_pywavelets.py T.npz           a matrix of scipy.sparse.save_npz
    python haar_pywavelets.py T.npy           a two-dimensional array

The rival is `cargo run --release -p prt-wavelet --example haar_throughput`, which prints the same line for the same matrix size.
Versions are pinned in requirements.txt beside this file.
"""

import argparse
import math
import sys
import time

import numpy as np
import pywt


def load(path):
    """The matrix of a file as dense float32, rows x texels; random values where no file is named."""
    if path is None:
        return np.random.default_rng(1).random((1839, 6 * 32 * 32), dtype=np.float32)
    if path.endswith(".npz"):
        import scipy.sparse

        return scipy.sparse.load_npz(path).toarray().astype(np.float32)
    return np.load(path).astype(np.float32)


def batched(faces, levels):
    """All faces of all rows in one call a level: the interpreter costs nothing."""
    return pywt.wavedec2(faces, "haar", mode="periodization", level=levels, axes=(-2, -1))


def one_by_one(faces, levels):
    """A call a face, as a script would be written first."""
    return [pywt.wavedec2(face, "haar", mode="periodization", level=levels) for face in faces]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("matrix", nargs="?", help="T.npz or T.npy; columns are 6 faces of a power of two squared")
    parser.add_argument("--runs", type=int, default=7, help="measured runs after one that warms up (7)")
    arguments = parser.parse_args()

    matrix = load(arguments.matrix)
    rows, texels = matrix.shape
    resolution = math.isqrt(texels // 6)
    if 6 * resolution**2 != texels or resolution & (resolution - 1) or resolution < 2:
        sys.exit(f"{texels} columns are not 6 faces of a power of two squared")
    levels = resolution.bit_length() - 1
    faces = matrix.reshape(rows * 6, resolution, resolution)
    for name, transform in (("batched", batched), ("face by face", one_by_one)):
        seconds = []
        for _ in range(arguments.runs + 1):
            start = time.perf_counter()
            transform(faces, levels)
            seconds.append(time.perf_counter() - start)
        median = sorted(seconds[1:])[arguments.runs // 2]
        rate = matrix.nbytes / median / 1e6
        print(
            f"pywavelets {pywt.__version__} {name}, 1 thread: {rows} x {texels} in {median * 1e3:.2f} ms "
            f"(fastest {min(seconds[1:]) * 1e3:.2f}), {rows / median:.0f} rows/s, {rate:.0f} MB/s"
        )


if __name__ == "__main__":
    main()
