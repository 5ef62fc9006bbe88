#!/usr/bin/env python3
"""Renders scenes from every signal beside a brute-force reference, and tables the error.

    benches/pictures.py PRT OUT LIGHT.exr [LIGHT.exr ...] [--mesh MESH ...]

PRT is the program; the Utah teapot is always there, meshes (y up) come on top. Writes OUT/SCENE-LIGHT-SIGNAL.png (picture, reference, error of
each pixel) and OUT/pictures.csv. No package beyond the standard library.
"""

import argparse
import csv
import json
import pathlib
import subprocess

ROUGH = "cook-torrance"
# Name, options of precompute, BRDF of the reference, options of render.
SIGNALS = [
    ("diffuse", ["--signal", "diffuse"], "lambert", []),
    ("glossy", ["--signal", "glossy", "--brdf", ROUGH], ROUGH, []),
    ("glossy-99x81", ["--signal", "glossy", "--brdf", ROUGH, "--coefficients", "99", "--orthonormal", "--incident", "10", "--basis", "sh:9"], ROUGH, []),
    ("terms-16", ["--signal", "terms", "--brdf", ROUGH, "--terms", "16"], ROUGH, ["--responses", f"terms:16:{ROUGH}", "--basis", "cubemap:32"]),
]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("prt")
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("lights", nargs="+")
    parser.add_argument("--mesh", action="append", default=[])
    parser.add_argument("--size", default="320x320")
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)

    def prt(*words):
        done = subprocess.run([arguments.prt, *map(str, words)], check=True, capture_output=True, text=True)
        return json.loads(done.stdout)

    rows = []
    for scene, up in [("teapot", "z"), *((mesh, "y") for mesh in arguments.mesh)]:
        name = pathlib.Path(scene).stem
        matrices = {}
        for signal, options, _, _ in SIGNALS:
            # Terms are streamed; everything else carries its meaning.
            matrix = arguments.out / f"{name}-{signal}.{'npy' if signal.startswith('terms') else 'npz'}"
            matrices[signal] = (matrix, prt("precompute", scene, "--up", up, *options, "-o", matrix, "--json"))
        for light in arguments.lights:
            stem = f"{name}-{pathlib.Path(light).stem}"
            common = ["render", scene, "--up", up, "--light", light, "--size", arguments.size, "--samples", 2, "--json"]
            references = {}
            for brdf in dict.fromkeys(brdf for _, _, brdf, _ in SIGNALS):
                references[brdf] = arguments.out / f"{stem}-{brdf}.exr"
                traced = prt(*common, "--reference", "--brdf", brdf, "-o", references[brdf])
                print(f"{stem} {brdf}: traced in {traced['seconds']:.1f} s", flush=True)
            for signal, _, brdf, described in SIGNALS:
                matrix, precomputed = matrices[signal]
                beside = arguments.out / f"{stem}-{signal}.png"
                relit = arguments.out / "relit.exr"
                told = prt(*common, matrix, *described, "--compare", references[brdf], "--beside", beside, "-o", relit)
                row = {
                    "scene": name, "light": pathlib.Path(light).stem, "signal": signal, "brdf": brdf, "size": arguments.size,
                    "relative_squared_error": f"{told['relative_squared_error']:.3g}", "psnr_db": f"{told['psnr_db']:.1f}",
                    "precompute_s": f"{precomputed['seconds']:.2f}", "render_s": f"{told['seconds']:.2f}",
                }
                rows.append(row)
                print(*row.values(), flush=True)
        for matrix, _ in matrices.values():
            matrix.unlink()
    with open(arguments.out / "pictures.csv", "w", newline="") as file:
        table = csv.DictWriter(file, rows[0])
        table.writeheader()
        table.writerows(rows)


if __name__ == "__main__":
    main()
