#!/usr/bin/env python3
"""Every command of `prt` that writes, on a disk that is full.

    sudo benches/faults/disk_full.py target/release/prt [--room 64]

Mounts a small file system in memory (Linux, root), fills it but for so many kB, and runs each command there over an old file: it
must fail with 1 and one sentence that names the file, and leave the old file and nothing else. Without root the test
`a_full_disk_leaves_every_old_file_and_one_sentence_with_its_name` does the same by a limit on the size of files. Needs Python 3.9."""

import argparse
import contextlib
import pathlib
import subprocess
import sys
import tempfile

SIZE = "64m"
FIELD = "--texels 64x64 --directions 32x16 --shape sphere"
# The last word is what is written; a folder where it has no extension.
COMMANDS = [
    "precompute teapot --signal diffuse --vertices 1000 -o out.npz",
    "precompute teapot --signal diffuse --vertices 1000 -o out.npy",
    "precompute teapot --signal biscale --vertices 1000 -o out.mtx",
    "precompute teapot --signal terms --terms 4 --transform srbf -o out.npy",
    "encode csr {in}/T.npz -o out.prt",
    "encode cpca:clusters=16 {in}/T.npz -o out.prt",
    "decode {in}/T.prt -o out.npz",
    "decode {in}/T.prt -o out.npy",
    "decode {in}/T.prt -o out.mtx",
    "export {in}/P.prt -o out.pca",
    "import {in}/P.pca -o out.prt",
    "relight {in}/T.prt --light sky -o out.npy",
    "render teapot {in}/T.prt --vertices 1000 --size 1024x768 -o out.png",
    "render teapot {in}/T.prt --vertices 1000 --size 1024x768 --background 0,0,0 -o out.exr",
    "fit-light sky --lobes 162 --cubemap 8 --steps 1 --exchanges 0 -o out.json",
    "select {in}/T.npz --max-error 0.5 --method csr -o out.prt",
    "select {in}/T.npz --max-error 0.01 --method pca --out out",
    f"slf glossy-sphere {FIELD} -o out",
    "bench --quick --signal diffuse --out out",
    "tables tensor --table table1 --out out",
    "figures srbf --figure bandwidth --out out",
    "stability biclustering --sweep columns --vertices 50 --out out",
]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("prt", type=pathlib.Path)
    parser.add_argument("--room", type=int, default=4, help="kB that are left on the disk")
    options = parser.parse_args()
    prt, wrong = options.prt.resolve(), []
    with tempfile.TemporaryDirectory() as inputs, tempfile.TemporaryDirectory() as disk, mounted(disk):
        inputs, disk = pathlib.Path(inputs), pathlib.Path(disk)
        for arguments in [
            "precompute teapot --signal diffuse --vertices 1000 -o T.npz",
            "encode csr T.npz -o T.prt",
            "precompute teapot --signal diffuse --basis sh:5 --vertices 1000 -o P.npz",
            "encode cpca:clusters=4 P.npz -o P.prt",
            "export P.prt -o P.pca",
        ]:
            subprocess.run([prt, *arguments.split()], cwd=inputs, check=True, stdout=subprocess.DEVNULL)
        for command in COMMANDS:
            arguments = command.replace("{in}", str(inputs)).split()
            output = disk / arguments[-1]
            if output.suffix:
                output.write_bytes(b"old")
            else:
                output.mkdir()
                (output / "kept").write_bytes(b"old")
            fill(disk, options.room)
            ran = subprocess.run([prt, *arguments], cwd=disk, capture_output=True, text=True)
            old = output if output.suffix else output / "kept"
            said = ran.stderr.strip()
            parts = [path for path in disk.rglob(".prt-*")]
            promised = ran.returncode == 1 and said.count("\n") == 0 and "panicked" not in said
            if not (promised and old.read_bytes() == b"old" and not parts):
                wrong.append(command)
            print(f"{ran.returncode} {' '.join(arguments[:2])[:24]:24} {output.name:8} {said.replace(str(inputs), 'IN')[:110]}", flush=True)
            subprocess.run(f"rm -rf {disk}/*", shell=True, check=True)
    sys.exit(f"not as promised: {wrong}" if wrong else 0)


@contextlib.contextmanager
def mounted(folder):
    subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={SIZE}", "tmpfs", folder], check=True)
    try:
        yield
    finally:
        subprocess.run(["umount", folder], check=True)


def fill(disk, room):
    with open(disk / "filler", "wb", buffering=0) as filler:
        with contextlib.suppress(OSError):
            while filler.write(bytes(1 << 16)):
                pass
        with contextlib.suppress(OSError):
            while filler.write(bytes(1 << 10)):
                pass
        filler.truncate(max(filler.tell() - 1024 * room, 0))


if __name__ == "__main__":
    main()
