"""Encoding time and error of faiss and numpy on surface light fields (Miandji et al. 2011): the peer of the codec `slf`.

    pip install -r benches/peers/requirements.txt
    prt slf cornell-spheres --shape blue-sphere --frame world --keep -o field
    python benches/peers/slf_faiss.py field/blue-sphere.npy --ours target/release/prt

T.npy is (texels x channels) x directions, 3m x n, or m x 3 x n. The peer follows the paper: the mean of each row (mean map), k-means of the residuals of
all channels together (faiss, so many sweeps from random samples), then the k leading right singular vectors of each cluster and channel from the
eigenvectors of the smaller Gram matrix (numpy, in f64 with --double). It shares no code with `prt`. Ours is `prt encode` with the same numbers, decoded
by `prt decode`. It prints the seconds of both, the relative squared error Σ(F-F̃)²/ΣF² in f64, and the numbers that Eq. 5 counts. Compare with figures of
the same machine and the same run only.
"""

import argparse
import json
import os
import subprocess
import tempfile
import time

import faiss
import numpy as np

CHANNELS = 3
# Texels whose error is summed at once.
BLOCK = 1024


def leading(rows, k, dtype):
    """The k leading right singular vectors of rows, k x n."""
    m, n = rows.shape
    if m <= n:
        values, vectors = np.linalg.eigh((rows @ rows.T).astype(dtype))
        top = vectors[:, ::-1][:, :k].astype(np.float32)
        basis = top.T @ rows
        norms = np.linalg.norm(basis, axis=1, keepdims=True)
        return np.divide(basis, norms, out=np.zeros_like(basis), where=norms > 0)
    values, vectors = np.linalg.eigh((rows.T @ rows).astype(dtype))
    return vectors[:, ::-1][:, :k].T.astype(np.float32)


def peer(field, clusters, k, sweeps, seed, dtype):
    """Mean map, clusters, surface map and view maps; seconds of clustering and of singular vectors."""
    m, channels, n = field.shape
    began = time.perf_counter()
    means = field.mean(axis=2)
    residual = field - means[:, :, None]
    flat = residual.reshape(m, channels * n)
    kmeans = faiss.Kmeans(channels * n, clusters, niter=sweeps, seed=seed, max_points_per_centroid=m, min_points_per_centroid=1)
    kmeans.train(flat)
    _, ids = kmeans.index.search(flat, 1)
    ids = ids[:, 0]
    clustered = time.perf_counter() - began
    began = time.perf_counter()
    surface = np.zeros((m, channels, k), np.float32)
    views = np.zeros((clusters, channels, k, n), np.float32)
    for cluster in range(clusters):
        members = np.flatnonzero(ids == cluster)
        for channel in range(channels):
            rows = np.ascontiguousarray(residual[members, channel])
            if len(members) == 0:
                continue
            basis = leading(rows, k, dtype)
            views[cluster, channel, : len(basis)] = basis
            surface[members, channel, : len(basis)] = rows @ basis.T
    return (means, ids, surface, views), clustered, time.perf_counter() - began


def error_of(field, model):
    """Eq. 7 for every element."""
    means, ids, surface, views = model
    error = whole = 0.0
    for first in range(0, len(field), BLOCK):
        part = slice(first, first + BLOCK)
        decoded = means[part, :, None] + np.einsum("pck,pckn->pcn", surface[part], views[ids[part]])
        error += np.sum((field[part].astype(np.float64) - decoded) ** 2)
        whole += np.sum(field[part].astype(np.float64) ** 2)
    return error / whole


def ours(prt, path, field, label, folder):
    encoded, decoded = os.path.join(folder, "a.prt"), os.path.join(folder, "a.npy")
    m, channels, n = field.shape
    described = ["--responses", str(channels), "--basis", f"plain:{n}"]
    said = subprocess.run([prt, "encode", label, path, "-o", encoded, "--json"] + described, check=True, capture_output=True)
    subprocess.run([prt, "decode", encoded, "-o", decoded], check=True)
    back = np.load(decoded, mmap_mode="r").reshape(field.shape)
    error = whole = 0.0
    for first in range(0, m, BLOCK):
        part = slice(first, first + BLOCK)
        error += np.sum((field[part].astype(np.float64) - back[part]) ** 2)
        whole += np.sum(field[part].astype(np.float64) ** 2)
    return json.loads(said.stdout), error / whole


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("matrix")
    parser.add_argument("--clusters", type=int, default=256)
    parser.add_argument("--components", type=int, default=8)
    parser.add_argument("--sweeps", type=int, default=20)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--double", action="store_true")
    parser.add_argument("--ours", metavar="PRT")
    arguments = parser.parse_args()
    field = np.load(arguments.matrix)
    field = field.reshape(-1, CHANNELS, field.shape[-1])
    m, channels, n = field.shape
    k, clusters = arguments.components, arguments.clusters
    count = channels * m * k + clusters * channels * n * k + channels * m + m
    print(f"{m} texels x {channels} channels x {n} directions; Eq. 5: {count} numbers, {channels * m * n / count:.2f} : 1")
    print(f"numpy {np.__version__}, faiss {faiss.__version__}, {faiss.omp_get_max_threads()} threads")
    dtype = np.float64 if arguments.double else np.float32
    model, clustered, components = peer(field, clusters, k, arguments.sweeps, arguments.seed, dtype)
    seconds, error = clustered + components, error_of(field, model)
    print(f"faiss + numpy: {clustered:.1f} s clusters + {components:.1f} s vectors = {seconds:.1f} s, error {error:.5f}")
    if arguments.ours:
        label = f"slf:clusters={clusters}:components={k}:sweeps={arguments.sweeps}:seed={arguments.seed}"
        with tempfile.TemporaryDirectory(dir=os.path.dirname(os.path.abspath(arguments.matrix))) as folder:
            told, own = ours(arguments.ours, arguments.matrix, field, label, folder)
        print(f"prt: {told['encode_s']:.1f} s, error {own:.5f}, file {told['file_bytes']} bytes")
        print(f"prt / peer: time {told['encode_s'] / seconds:.2f}, error {own / error:.4f}")


if __name__ == "__main__":
    main()
