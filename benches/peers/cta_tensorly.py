"""Encoding time and error of tensorly and of plain numpy on clustered tensor approximation: the peers of the `cta` codec.

    pip install -r benches/peers/requirements.txt
    prt precompute bunny.ply --signal terms --transform srbf -o T.npy
    python benches/peers/cta_tensorly.py T.npy
    python benches/peers/cta_tensorly.py T.npy --ours target/release/prt

T.npy is samples x responses x lights, of coordinates in which squared error counts: responses are the paper's view mode. Peers, all with
the same clusters, ranks and threads:

- numpy: Tsai and Shih 2006 §5.2 in f64, with Eq. 16 by the right singular vectors. k-means from random samples in place of ELBG; one view
  basis for all clusters; `--sweeps` of clustering (each fits the clusters by `--inner` sweeps of HOOI and reclassifies), then as many of
  the approximation phase, which refit the view basis.
- tensorly: the same clustering loop, but every cluster is a Tucker decomposition of its own by tensorly.decomposition.tucker, with a view
  basis of its own: more numbers than the paper's model.
- ours, with `--ours PRT`: `prt encode cta`, f32, decoded by `prt decode`, in the same run.

It prints the seconds, the relative squared error Σ(T-T̃)²/ΣT² in f64, and how ours compares with each peer. Compare with figures of the
same machine and the same run only.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time

import numpy as np
import tensorly
from tensorly.decomposition import tucker
from threadpoolctl import threadpool_limits


def leading(gram, rank):
    """Leading eigenvectors of a symmetric matrix as columns, descending; those of rounding are left out."""
    values, vectors = np.linalg.eigh(gram)
    values, vectors = values[::-1][:rank], vectors[:, ::-1][:, :rank]
    return vectors[:, values > 1e-13 * max(values[0], 1e-300)]


def gram_of_mode(tensor, mode):
    """X_(n) X_(n)^T."""
    others = [axis for axis in range(tensor.ndim) if axis != mode]
    return np.tensordot(tensor, tensor, axes=(others, others))


def k_means(rows, clusters, sweeps, generator):
    """Clusters of Lloyd's algorithm from random rows; an empty one takes the farthest row."""
    means = rows[generator.choice(len(rows), clusters, replace=False)]
    squares = np.sum(rows**2, axis=1)
    for _ in range(sweeps):
        distances = squares[:, None] - 2 * rows @ means.T + np.sum(means**2, axis=1)
        members = np.argmin(distances, axis=1)
        for cluster in np.setdiff1d(np.arange(clusters), members):
            members[np.argmax(distances[np.arange(len(rows)), members])] = cluster
        means = np.array([rows[members == cluster].mean(axis=0) for cluster in range(clusters)])
    return members


def fit(z, light, ranks, inner):
    """U_light (L x R_light) and V (R_vert x R_view R_light) of a cluster's n x R_view x L, by HOOI from `light` or from HOSVD."""
    _, rank_light, rank_vert = ranks
    if light is None:
        light = leading(gram_of_mode(z, 2), rank_light)
    for _ in range(inner):
        projected = (z @ light).reshape(len(z), -1)
        dual = leading(projected.T @ projected, rank_vert)
        # U_vert U_vert^T Z: what the vertex mode keeps, in the coordinates of U_vert.
        vertex = np.linalg.svd(projected @ dual, full_matrices=False)[0]
        light = leading(gram_of_mode(np.tensordot(vertex.T, z, axes=1), 2), rank_light)
    projected = (z @ light).reshape(len(z), -1)
    return light, leading(projected.T @ projected, rank_vert).T


def kept(z, model):
    """What of each sample's square a cluster keeps: |V uf(z U_light)|^2 (Eq. 17)."""
    light, dual = model
    return np.sum(((z @ light).reshape(len(z), -1) @ dual.T) ** 2, axis=1)


def numpy_cta(tensor, options):
    """Relative squared error by sweep."""
    ranks, clusters = (options.view, options.light, options.sample), options.clusters
    generator = np.random.default_rng(options.seed)
    square = np.sum(tensor**2)
    view = leading(gram_of_mode(tensor, 1), options.view)
    z = np.einsum("nkl,kv->nvl", tensor, view, optimize=True)
    members = k_means(z.reshape(len(z), -1), clusters, options.start, generator)
    models = [None] * clusters
    for sweep in range(options.sweeps):
        models = [fit(z[members == c], models[c] and models[c][0], ranks, options.inner) for c in range(clusters)]
        captured = np.stack([kept(z, model) for model in models], axis=1)
        moved = np.argmax(captured, axis=1)
        changed, members = np.sum(moved != members), moved
        print(f"  numpy sweep {sweep + 1}: error {1 - captured.max(axis=1).sum() / square:.4f}, {changed} moved", flush=True)
    for _ in range(options.sweeps):
        gram = np.zeros((tensor.shape[1],) * 2)
        for c in range(clusters):
            mine = tensor[members == c]
            projected = (z[members == c] @ models[c][0]).reshape(len(mine), -1) @ models[c][1].T
            vertex = np.linalg.svd(projected, full_matrices=False)[0]
            part = np.tensordot(vertex.T, mine, axes=1) @ models[c][0]
            gram += gram_of_mode(part, 1)
        view = leading(gram, options.view)
        z = np.einsum("nkl,kv->nvl", tensor, view, optimize=True)
        models = [fit(z[members == c], models[c][0], ranks, options.inner) for c in range(clusters)]
    captured = sum(kept(z[members == c], models[c]).sum() for c in range(clusters))
    return 1 - captured / square


def tensorly_cta(tensor, options):
    """Relative squared error."""
    clusters, generator = options.clusters, np.random.default_rng(options.seed)
    square = np.sum(tensor**2)
    rows = tensor.reshape(len(tensor), -1)
    view = leading(gram_of_mode(tensor, 1), options.view)
    z = np.einsum("nkl,kv->nvl", tensor, view, optimize=True)
    members = k_means(z.reshape(len(z), -1), clusters, options.start, generator)
    for sweep in range(options.sweeps):
        captured, lost = np.zeros((len(tensor), clusters)), 0.0
        for c in range(clusters):
            mine = tensor[members == c]
            rank = [min(r, s) for r, s in zip((options.sample, options.view, options.light), mine.shape)]
            core, factors = tucker(tensorly.tensor(mine), rank=rank, n_iter_max=options.inner_tensorly, tol=1e-5)
            lost += np.sum(mine**2) - np.sum(core**2)
            dual = core.reshape(len(core), -1)
            dual = np.linalg.svd(dual, full_matrices=False)[2]
            projected = np.einsum("nkl,kv->nvl", tensor, factors[1], optimize=True) @ factors[2]
            captured[:, c] = np.sum((projected.reshape(len(rows), -1) @ dual.T) ** 2, axis=1)
        print(f"  tensorly sweep {sweep + 1}: error {lost / square:.4f}", flush=True)
        moved = np.argmax(captured, axis=1)
        if np.array_equal(moved, members) or np.unique(moved).size < clusters:
            break
        if sweep + 1 < options.sweeps:
            members = moved
    return lost / square


def of_prt(tensor, options):
    """Seconds of encoding by `prt`, and the error of what it decodes."""
    label = f"cta:clusters={options.clusters}:view={options.view}:light={options.light}:sample={options.sample}:seed={options.seed}"
    if options.parameters:
        label += f":{options.parameters}"
    with tempfile.TemporaryDirectory() as folder:
        prt, out = os.path.join(folder, "T.prt"), os.path.join(folder, "T.npy")
        run = [options.ours, "--threads", str(options.threads)]
        told = subprocess.run([*run, "encode", label, options.tensor, "-o", prt, "--json"], capture_output=True, text=True)
        if told.returncode != 0:
            sys.exit(f"{label}: {told.stderr.strip()}")
        subprocess.run([*run, "decode", prt, "-o", out], check=True, stdout=subprocess.DEVNULL)
        decoded = np.load(out).reshape(tensor.shape)
    return json.loads(told.stdout)["encode_s"], np.sum((tensor - decoded) ** 2) / np.sum(tensor**2)


def timed(run):
    begin = time.perf_counter()
    error = run()
    return time.perf_counter() - begin, error


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tensor", help="T.npy: samples x responses x lights")
    parser.add_argument("--clusters", type=int, default=9)
    parser.add_argument("--view", type=int, default=8, help="rank of the response mode (8)")
    parser.add_argument("--light", type=int, default=48, help="rank of the light mode of each cluster (48)")
    parser.add_argument("--sample", type=int, default=24, help="rank of the sample mode of each cluster (24)")
    parser.add_argument("--sweeps", type=int, default=4, help="of clustering, and of approximation (4)")
    parser.add_argument("--start", type=int, default=10, help="sweeps of k-means (10)")
    parser.add_argument("--inner", type=int, default=2, help="sweeps of HOOI in a fit of numpy's (2)")
    parser.add_argument("--inner-tensorly", type=int, default=20, help="sweeps of HOOI at most in a fit of tensorly's (20)")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--without", action="append", default=[], choices=["numpy", "tensorly"], help="leave a peer out")
    parser.add_argument("--ours", metavar="PRT", help="the program, measured in the same run")
    parser.add_argument("--parameters", default="", help="more parameters of ours, as members=2")
    options = parser.parse_args()

    tensor = np.load(options.tensor).astype(np.float64)
    shape = " x ".join(map(str, tensor.shape))
    print(f"{shape}; numpy {np.__version__}, tensorly {tensorly.__version__}; load {os.getloadavg()[0]:.1f}", flush=True)
    rows = {}
    with threadpool_limits(options.threads):
        for name, run in (("numpy", numpy_cta), ("tensorly", tensorly_cta)):
            if name not in options.without:
                rows[name] = timed(lambda: run(tensor, options))
    ours = of_prt(tensor, options) if options.ours else None
    for name, (seconds, error) in rows.items():
        print(f"{name:10} {seconds:8.2f} s  error {error:.4f}")
    if ours:
        print(f"{'prt':10} {ours[0]:8.2f} s  error {ours[1]:.4f}")
        for name, (seconds, error) in rows.items():
            print(f"prt / {name}: {seconds / ours[0]:.1f} times as fast, error {ours[1] / error:.4f}")


if __name__ == "__main__":
    main()
