"""Encoding time and error of scikit-learn, faiss and plain numpy on clustered PCA: the peers of the `vq` and `cpca` codecs.

    pip install -r benches/peers/requirements.txt
    python benches/peers/cpca_sklearn_faiss.py T.npy
    python benches/peers/cpca_sklearn_faiss.py T.npy --iterative 2
    python benches/peers/cpca_sklearn_faiss.py T.npy --ours target/release/prt

T.npy is samples x responses x lights or samples x lights; a sample is one vector. Peers, all with the same clusters, sweeps and
threads, each with the mean and the leading components of every cluster:

- scikit-learn: one run of Lloyd's algorithm from k-means++ and from random samples, then its PCA of each cluster;
- faiss: k-means on all samples, then the eigenvectors of the smaller Gram matrix of each cluster (numpy);
- numpy, with `--iterative S`: Sloan et al. 2003 in f64, from random samples: §4.1 (static), then §4.2 (iterative: clusters by the
  error of reconstruction, components introduced one by one with S sweeps for each number of them). It shares no code with `prt`;
- ours, with `--ours PRT`: `prt encode` with those labels, decoded by `prt decode`, in the same run.

It prints the seconds of clustering and of PCA, the relative squared error Σ(T-T̃)²/ΣT² in f64, and how ours compares with each
peer. Compare with figures of the same machine and the same run only.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
import warnings

import faiss
import numpy as np
import sklearn
from sklearn.cluster import KMeans
from sklearn.decomposition import PCA
from sklearn.exceptions import ConvergenceWarning
from threadpoolctl import threadpool_limits

# Rows of T whose distances to all clusters are in memory at once.
BLOCK = 2048
# Our labels by name, with the options of the command line.
OURS = {
    "prt static": "cpca:clusters={clusters}:components={components}:sweeps={sweeps}:seed={seed}",
    "prt iterative": "cpca:clusters={clusters}:components={components}:mode=iterative:sweeps={ours_sweeps}:seed={seed}",
    "prt adaptive": "cpca:clusters={clusters}:components={components}:mode=adaptive:sweeps={ours_sweeps}:seed={seed}",
}


class Model:
    """The cluster of each sample, and the mean (n) and the components (orthonormal, k x n) of each cluster."""

    def __init__(self, members, means, bases):
        self.members, self.means, self.bases = members, means, bases

    def error(self, samples):
        """Σ(T-T̃)²/ΣT², from explicit residuals in f64."""
        lost = 0.0
        for cluster, (mean, basis) in enumerate(zip(self.means, self.bases)):
            residual = samples[self.members == cluster].astype(np.float64) - mean
            basis = basis.astype(np.float64)
            residual -= residual @ basis.T @ basis
            lost += np.sum(residual**2)
        return lost / square(samples)


def square(samples):
    """ΣT² in f64."""
    return np.sum(np.square(samples, dtype=np.float64))


def leading(samples, components):
    """Mean and leading components of a cluster, by the eigenvectors of the smaller Gram matrix; fewer where its rank is."""
    mean = samples.mean(axis=0)
    centred = samples - mean
    wide = centred.shape[0] < centred.shape[1]
    squares, vectors = np.linalg.eigh(centred @ centred.T if wide else centred.T @ centred)
    # Descending; what is nothing but rounding has no direction.
    kept = [i for i in range(len(squares) - 1, -1, -1)[:components] if squares[i] > 1e-12 * squares[-1] > 0]
    basis = vectors[:, kept].T
    if wide:
        basis = basis @ centred / np.sqrt(squares[kept])[:, None]
    return mean, basis


def subspaces(samples, members, clusters, fit):
    """What `fit` finds for the members of each cluster."""
    pairs = [fit(samples[members == cluster]) for cluster in range(clusters)]
    return Model(members, [mean for mean, _ in pairs], [basis for _, basis in pairs])


def scikit_learn(samples, options, init):
    """Seconds of k-means and of PCA, and the model."""

    def fit(members):
        if len(members) <= 1:
            return members.sum(axis=0), np.zeros((0, members.shape[1]), members.dtype)
        most = min(options.components, len(members) - 1, members.shape[1])
        pca = PCA(n_components=most, random_state=options.seed)
        pca.fit_transform(members)
        return pca.mean_, pca.components_

    begin = time.perf_counter()
    means = KMeans(options.clusters, init=init, n_init=1, max_iter=options.sweeps, tol=0, random_state=options.seed)
    members = means.fit(samples).labels_
    middle = time.perf_counter()
    model = subspaces(samples, members, options.clusters, fit)
    return middle - begin, time.perf_counter() - middle, model


def of_faiss(samples, options):
    """Seconds of k-means, its last assignment included, and of PCA, and the model."""

    def fit(members):
        if len(members) == 0:
            return np.zeros(members.shape[1], members.dtype), np.zeros((0, members.shape[1]), members.dtype)
        mean, basis = leading(members, options.components)
        # The weights, which the others compute too.
        (members - mean) @ basis.T
        return mean, basis

    begin = time.perf_counter()
    means = faiss.Kmeans(
        samples.shape[1],
        options.clusters,
        niter=options.sweeps,
        seed=options.seed,
        spherical=False,
        max_points_per_centroid=len(samples),
        min_points_per_centroid=1,
    )
    means.train(samples)
    members = means.index.search(samples, 1)[1][:, 0]
    middle = time.perf_counter()
    model = subspaces(samples, members, options.clusters, fit)
    return middle - begin, time.perf_counter() - middle, model


def nearest(samples, squares, model):
    """The cluster with the least error of reconstruction for each sample, and that error: ‖x-x0‖² - Σ((x-x0)·xi)² (§4.2)."""
    means, clusters = np.array(model.means), len(model.means)
    width = max(len(basis) for basis in model.bases)
    bases = np.zeros((clusters, width, samples.shape[1]))
    for cluster, basis in enumerate(model.bases):
        bases[cluster, : len(basis)] = basis
    of_means = np.einsum("cwn,cn->cw", bases, means)
    members, errors = np.empty(len(samples), int), np.empty(len(samples))
    for start in range(0, len(samples), BLOCK):
        block = samples[start : start + BLOCK]
        error = squares[start : start + BLOCK, None] - 2 * (block @ means.T) + np.sum(means**2, axis=1)
        for i in range(width):
            error -= (block @ bases[:, i].T - of_means[:, i]) ** 2
        members[start : start + BLOCK] = best = np.argmin(error, axis=1)
        errors[start : start + BLOCK] = error[np.arange(len(block)), best]
    return members, errors


def lloyd(samples, squares, model, components, sweeps):
    """Generalised LBG: assigns by the error of reconstruction, fits again by PCA; until nothing moves, `sweeps` times at most."""
    for _ in range(sweeps):
        members, errors = nearest(samples, squares, model)
        # A cluster that lost its last member takes the sample that is represented worst.
        for cluster in np.setdiff1d(np.arange(len(model.means)), members):
            worst = np.argmax(errors)
            members[worst], errors[worst] = cluster, 0
        if np.array_equal(members, model.members):
            break
        model = fitted(samples, members, len(model.means), components)
    return model


def fitted(samples, members, clusters, components):
    """Means and components of the members of each cluster."""
    return subspaces(samples, members, clusters, lambda x: leading(x, components))


def numpy_cpca(samples, options):
    """Static and iterative CPCA in f64: a line for each, and for each number of components on the way."""
    samples = samples.astype(np.float64)
    squares = np.sum(samples**2, axis=1)
    drawn = np.random.default_rng(options.seed).choice(len(samples), options.clusters, replace=False)
    start = Model(None, list(samples[drawn]), [np.zeros((0, samples.shape[1]))] * options.clusters)

    begin = time.perf_counter()
    model = lloyd(samples, squares, start, 0, options.sweeps)
    middle = time.perf_counter()
    model = fitted(samples, model.members, options.clusters, options.components)
    static = (middle - begin, time.perf_counter() - middle, model.error(samples))

    begin, model = time.perf_counter(), start
    for components in range(options.components + 1):
        if components > 0:
            model = fitted(samples, model.members, options.clusters, components)
        model = lloyd(samples, squares, model, components, options.iterative)
        seconds = time.perf_counter() - begin
        print(f"  iterative, {components} components: {seconds:7.1f} s, error {model.error(samples):.4e}", flush=True)
    return static, (seconds, 0.0, model.error(samples))


def of_prt(samples, options, label):
    """Seconds of encoding by `prt` (all of them in the first figure), and the error of what it decodes."""
    label = label.format(**vars(options))
    with tempfile.TemporaryDirectory() as folder:
        prt, out = os.path.join(folder, "T.prt"), os.path.join(folder, "T.npy")
        run = [options.ours, "--threads", str(options.threads)]
        told = subprocess.run([*run, "encode", label, options.matrix, "-o", prt, "--json"], capture_output=True, text=True)
        if told.returncode != 0:
            sys.exit(f"{label}: {told.stderr.strip()}")
        subprocess.run([*run, "decode", prt, "-o", out], check=True, stdout=subprocess.DEVNULL)
        decoded = np.load(out).reshape(samples.shape)
    return json.loads(told.stdout)["encode_s"], 0.0, np.sum((samples.astype(np.float64) - decoded) ** 2) / square(samples)


def middle_of(run, runs):
    """The run of median total time."""
    done = sorted((run() for _ in range(runs)), key=lambda figures: figures[0] + figures[1])
    return done[len(done) // 2]


def measured(samples, options):
    """(name, seconds of clustering, seconds of PCA, error) of each peer and of ours."""
    peers = {
        "scikit-learn k-means++": lambda: scikit_learn(samples, options, "k-means++"),
        "scikit-learn random": lambda: scikit_learn(samples, options, "random"),
        "faiss": lambda: of_faiss(samples, options),
    }
    for name, run in peers.items():
        clustering, pca, model = middle_of(run, options.runs)
        yield name, clustering, pca, model.error(samples)
    if options.iterative is not None:
        static, iterative = numpy_cpca(samples, options)
        yield "numpy static, f64", *static
        yield f"numpy iterative S={options.iterative}, f64", *iterative
    for name, label in OURS.items() if options.ours else ():
        yield name, *middle_of(lambda: of_prt(samples, options, label), options.runs)


def report(rows):
    """Each row, then ours as multiples of each peer: seconds and error."""
    print(f"{'':28} {'cluster s':>10} {'PCA s':>8} {'sum s':>8} {'error':>11}")
    for name, clustering, pca, error in rows:
        print(f"{name:28} {clustering:10.2f} {pca:8.2f} {clustering + pca:8.2f} {error:11.4e}")
    ours = [row for row in rows if row[0] in OURS]
    for name, *figures in ours:
        for peer, clustering, pca, error in rows:
            if peer not in OURS:
                print(f"{name} / {peer}: time {sum(figures[:2]) / (clustering + pca):.3f}, error {figures[2] / error:.4f}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("matrix", help="T.npy: samples x responses x lights, or samples x lights")
    parser.add_argument("--clusters", type=int, default=256)
    parser.add_argument("--components", type=int, default=8, help="of each cluster, beside its mean (8)")
    parser.add_argument("--sweeps", type=int, default=20, help="of k-means (20)")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--runs", type=int, default=1, help="the run of median time counts (1)")
    parser.add_argument("--iterative", type=int, metavar="S", help="numpy's static and iterative CPCA too")
    parser.add_argument("--ours", metavar="PRT", help="the program, measured in the same run")
    options = parser.parse_args()
    options.ours_sweeps = options.iterative or 10

    samples = np.load(options.matrix).astype(np.float32)
    samples = np.ascontiguousarray(samples.reshape(len(samples), -1))
    faiss.omp_set_num_threads(options.threads)
    warnings.simplefilter("ignore", ConvergenceWarning)
    print(
        f"{len(samples)} samples x {samples.shape[1]}, {options.clusters} clusters, {options.components} components, "
        f"{options.sweeps} sweeps, {options.threads} threads; numpy {np.__version__}, scikit-learn {sklearn.__version__}, "
        f"faiss {faiss.__version__}; load {os.getloadavg()[0]:.1f}",
        flush=True,
    )
    with threadpool_limits(options.threads):
        report(list(measured(samples, options)))


if __name__ == "__main__":
    main()
