"""Occlusion rays per second of Embree, for the rays of `cargo run --release --features scene --example rays MESH.ply`.

    python benches/peers/visibility_embree.py MESH.ply [RESOLUTION SUPERSAMPLING] [--origins N]

Every vertex of the mesh, lifted along its normal by 1e-4 of the diagonal of the bounding box, looks in the directions of a
cubemap that lie above its horizon. Prints the rate on one thread (embreex traces in the calling thread; only the trace call
is timed, by the wall clock and by the thread's own processor time, which a busy machine does not spoil) and the number of visible directions, which must agree with the example's to about 1e-4: Embree rounds rays that
pass along edges otherwise.
"""

import argparse
import time

import numpy as np
import trimesh
from embreex import rtcore_scene
from embreex.mesh_construction import TriangleMesh

# Forward, right (columns), down (rows) of the faces +x, -x, +y, -y, +z, -z, as in prt_transfer::basis::FACES.
FACES = np.array(
    [
        [[1, 0, 0], [0, 0, -1], [0, -1, 0]],
        [[-1, 0, 0], [0, 0, 1], [0, -1, 0]],
        [[0, 1, 0], [1, 0, 0], [0, 0, 1]],
        [[0, -1, 0], [1, 0, 0], [0, 0, -1]],
        [[0, 0, 1], [1, 0, 0], [0, -1, 0]],
        [[0, 0, -1], [-1, 0, 0], [0, -1, 0]],
    ],
    dtype=np.float64,
)


def cubemap(side):
    """Unit directions through the centres of 6 x side x side texels, float32."""
    centre = (2 * np.arange(side) + 1) / side - 1
    v, u = np.meshgrid(centre, centre, indexing="ij")
    forward, right, down = FACES[:, None, None, :, :].transpose(3, 0, 1, 2, 4)
    d = forward + u[None, :, :, None] * right + v[None, :, :, None] * down
    d /= np.linalg.norm(d, axis=-1, keepdims=True)
    return d.reshape(-1, 3).astype(np.float32)


def horizon(d, n):
    """d · n in float32, in the order x, y, z."""
    return (d[:, 0] * n[0] + d[:, 1] * n[1]) + d[:, 2] * n[2] > 0


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("mesh")
    parser.add_argument("resolution", nargs="?", type=int, default=32)
    parser.add_argument("supersampling", nargs="?", type=int, default=2)
    parser.add_argument("--origins", type=int, help="only the first N vertices")
    arguments = parser.parse_args()

    mesh = trimesh.load(arguments.mesh, process=False)
    positions = np.asarray(mesh.vertices, dtype=np.float32)
    normals = np.asarray(mesh.vertex_normals, dtype=np.float32)
    offset = np.float32(1e-4) * np.float32(np.linalg.norm(positions.max(0) - positions.min(0)))
    directions = cubemap(arguments.resolution * arguments.supersampling)

    scene = rtcore_scene.EmbreeScene()
    TriangleMesh(scene, positions, np.asarray(mesh.faces, dtype=np.int32))
    origins = (positions + offset * normals)[: arguments.origins]
    scene.run(origins[:1], directions[:1], query="OCCLUDED")  # commits the scene: not part of the rate

    seconds, busy, rays, visible = 0.0, 0.0, 0, 0
    for origin, normal in zip(origins, normals):
        above = np.ascontiguousarray(directions[horizon(directions, normal)])
        from_here = np.ascontiguousarray(np.broadcast_to(origin, above.shape))
        start, start_busy = time.perf_counter(), time.thread_time()
        blocked = scene.run(from_here, above, query="OCCLUDED")
        seconds += time.perf_counter() - start
        busy += time.thread_time() - start_busy
        rays += len(above)
        visible += np.count_nonzero(blocked == -1)
    print(f"{len(origins)} vertices, {len(mesh.faces)} faces, {len(directions)} directions, offset {offset:e}")
    rates = f"{rays / seconds / 1e6:.2f} M rays/s ({rays / busy / 1e6:.2f} M per second of processor time)"
    print(f"1 thread: {rates}; {rays} rays, {visible} visible")


if __name__ == "__main__":
    main()
