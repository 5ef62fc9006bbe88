"""FLIP by its authors' own implementation, on the pictures of `cargo run --release -p prt-transfer --features io --example flip`.

    pip install -r benches/peers/requirements.txt
    prt render teapot T.npz -o reference.exr
    prt render teapot T.prt -o test.exr
    cargo run --release -p prt-transfer --features io --example flip -- reference.exr test.exr OUT
    python benches/peers/flip_reference.py OUT [OUT ...]

Each OUT holds reference.png, test.png and map.npy. Prints the mean of both maps, the difference of the means, the largest difference of a
pixel, and the seconds of the peer (all threads), which must be compared with figures of the same machine only.
"""

import argparse
import pathlib
import time

import flip_evaluator
import numpy as np

# The default of the program; the peer's own is 67.
PIXELS_PER_DEGREE = 67.0206


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", nargs="+", type=pathlib.Path)
    parser.add_argument("--runs", type=int, default=5)
    options = parser.parse_args()
    for out in options.out:
        ours = np.load(out / "map.npy").astype(np.float64)
        files = [str(out / name) for name in ("reference.png", "test.png")]
        pictures = [flip_evaluator.load(file) for file in files]
        seconds = []
        for _ in range(options.runs):
            begin = time.perf_counter()
            theirs, mean, _ = flip_evaluator.evaluate(*pictures, "LDR", applyMagma=False, parameters={"ppd": PIXELS_PER_DEGREE})
            seconds.append(time.perf_counter() - begin)
        theirs = np.squeeze(theirs).astype(np.float64)
        theirs = theirs if theirs.ndim == 2 else theirs[..., 0]
        difference = np.abs(ours - theirs)
        height, width = ours.shape
        print(
            f"{out}: {width} x {height}, mean {ours.mean():.6f}, peer's {theirs.mean():.6f} ({mean:.6f}), means differ by "
            f"{abs(ours.mean() - theirs.mean()):.1e}, pixels by at most {difference.max():.1e}; peer {1e3 * sorted(seconds)[len(seconds) // 2]:.1f} ms",
            flush=True,
        )


if __name__ == "__main__":
    main()
