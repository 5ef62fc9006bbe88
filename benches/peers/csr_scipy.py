"""Times scipy.sparse's CSR product with one light on one thread: the peer of the `csr` codec.

    pip install -r benches/peers/requirements.txt
    python benches/peers/csr_scipy.py [T.npz]

Without a file it draws the matrix of `cargo bench -p prt-benches` (see `synthetic` there). It prints the median and the best
of the products, the bytes that one moves over that time, and the bandwidth of a numpy copy of as many bytes (read and
written together) in the same run. Compare with figures of the same machine and the same hour only.
"""

import os
import sys
import time

# One thread, also for a library that numpy loads.
os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"

import numpy as np  # noqa: E402  (the environment must be set before)
import scipy.sparse as sparse  # noqa: E402

ROWS, LIGHTS, REPEATS = 117_696, 6144, 31


def mix(counter):
    """SplitMix64's output function."""
    z = (counter + np.uint64(1)) * np.uint64(0x9E3779B97F4A7C15)
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return z ^ (z >> np.uint64(31))


def synthetic(rows, lights):
    """The benchmark's matrix: rows of runs of consecutive columns, 32 apart; ones, and quarters at the ends of a run."""
    bits = mix(np.arange(rows, dtype=np.uint64))
    runs, width = (bits % 12).astype(int), (3 + (bits >> np.uint64(8)) % 11).astype(int)
    start = ((bits >> np.uint64(16)) % (lights - 384)).astype(int)
    row = np.repeat(np.arange(rows), runs * width)
    offsets = np.concatenate([[0], np.cumsum(runs * width)])
    element = np.arange(offsets[-1]) - offsets[row]
    run, i = element // width[row], element % width[row]
    left = 1 + (bits[row] >> (40 + run).astype(np.uint64)) % np.uint64(3)
    right = 1 + (bits[row] >> (50 + run).astype(np.uint64)) % np.uint64(3)
    quarters = np.where(i == 0, left, np.where(i + 1 == width[row], right, 4))
    columns = (start[row] + 32 * run + i).astype(np.int32)
    values = quarters.astype(np.float32) / 4
    return sparse.csr_matrix((values, columns, offsets.astype(np.int32)), shape=(rows, lights))


def seconds(work):
    """Sorted times of repeated runs, after one to warm up."""
    work()
    times = []
    for _ in range(REPEATS):
        begin = time.perf_counter()
        work()
        times.append(time.perf_counter() - begin)
    return sorted(times)


def main():
    if len(sys.argv) > 1:
        matrix = sparse.csr_matrix(sparse.load_npz(sys.argv[1]), dtype=np.float32)
    else:
        matrix = synthetic(ROWS, LIGHTS)
    light = np.linspace(0, 1, matrix.shape[1], dtype=np.float32)
    arrays = (matrix.data, matrix.indices, matrix.indptr)
    moved = sum(a.nbytes for a in arrays) + 4 * matrix.shape[0]
    source = np.ones(moved // 8, dtype=np.float32)
    target = np.empty_like(source)
    print(f"{matrix.shape[0]} x {matrix.shape[1]}, {matrix.nnz} non-zeros, numpy {np.__version__}")
    for name, work in [("copy", lambda: np.copyto(target, source)), ("csr", lambda: matrix @ light)]:
        times = seconds(work)
        median = times[len(times) // 2]
        print(f"{name:5} median {1e3 * median:.2f} ms, best {1e3 * times[0]:.2f} ms, {moved / median / 1e9:.1f} GB/s")


if __name__ == "__main__":
    main()
