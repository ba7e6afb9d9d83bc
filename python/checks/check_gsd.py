"""Opens a trajectory written by protomer with the Python package `gsd` and verifies it.

    pip install gsd numpy
    python python/checks/check_gsd.py trajectory.gsd
    PROTOMER_GSD_CHECK=/tmp/check.gsd cargo test -p protomer-io --test integration gsd:: && \
        python python/checks/check_gsd.py --reference /tmp/check.gsd

Every trajectory is checked against the schema. With --reference the file is the one that the test suite writes, of
which every value is known.
"""

import argparse
import json
import sys

import gsd.fl
import gsd.hoomd
import gsd.version
import numpy as np


def require(holds, message):
    if not holds:
        sys.exit(f"check_gsd: {message}")


def check_schema(trajectory):
    """Invariants of any trajectory: readable frames, bodies in the box, unit quaternions, valid meshes."""
    first = trajectory[0]
    bodies = first.particles.N
    require(len(first.particles.type_shapes) == len(first.particles.types), "not every type has a shape")
    for shape in first.particles.type_shapes:
        if shape:
            require(shape["type"] == "Mesh", f"unknown shape {shape['type']}")
            vertices, indices = np.array(shape["vertices"]), np.array(shape["indices"])
            require(vertices.shape[1] == 3 and indices.shape[1] == 3, "a mesh is not made of triangles")
            require(indices.min() == 0 and indices.max() == len(vertices) - 1, "mesh indices do not fit the vertices")
    steps = []
    for frame in trajectory:
        frame.validate()
        steps.append(frame.configuration.step)
        require(frame.particles.N == bodies, "the number of bodies changes")
        half_box = frame.configuration.box[:3] / 2
        require((np.abs(frame.particles.position) <= half_box).all(), f"a body leaves the box at step {steps[-1]}")
        norms = np.linalg.norm(frame.particles.orientation, axis=1)
        require(np.allclose(norms, 1, atol=1e-6), f"a quaternion has no unit length at step {steps[-1]}")
        require((frame.particles.typeid < len(frame.particles.types)).all(), "a type index is out of range")
    require(all(a < b for a, b in zip(steps, steps[1:])), "the steps do not increase")


def check_reference(path, trajectory):
    """The values of `crates/base/io/tests/integration/gsd.rs`."""
    require(len(trajectory) == 300, f"{len(trajectory)} frames instead of 300")
    for k, frame in enumerate(trajectory):
        particles = frame.particles
        require(frame.configuration.step == 1000 * k, f"frame {k}: step")
        require(np.array_equal(frame.configuration.box, [90, 80, 70, 0, 0, 0]), f"frame {k}: box")
        require(particles.types == ["positive", "b"], f"frame {k}: types")
        require(np.array_equal(particles.typeid, [0, 1, 0]), f"frame {k}: typeid")
        require(np.array_equal(particles.charge, np.float32([6, -4.5, 6])), f"frame {k}: charge")
        i = np.arange(3)
        positions = np.stack([i, np.full(3, 10 - 0.01 * k), -0.5 * i], axis=1)
        require(np.allclose(particles.position, positions, rtol=0, atol=1e-6), f"frame {k}: position")
        half_angle = (0.1 * k + i) / 2
        orientations = np.stack([np.cos(half_angle), 0 * i, 0 * i, np.sin(half_angle)], axis=1)
        require(np.allclose(particles.orientation, orientations, atol=1e-6), f"frame {k}: orientation")
        require(frame.log["energy_kT"] == -1.5 * k, f"frame {k}: log/energy_kT")
    shape = trajectory[0].particles.type_shapes[0]
    require(shape["vertices"][1] == [3.5, 0, 0] and shape["indices"][0] == [0, 2, 1], "mesh")
    log = gsd.hoomd.read_log(path, scalar_only=True)
    require(np.array_equal(log["log/r_g_angstrom"], 50.0 + np.arange(300)), "log/r_g_angstrom")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("trajectory")
    parser.add_argument("--reference", action="store_true", help="the file of the test suite")
    arguments = parser.parse_args()
    with gsd.fl.open(arguments.trajectory, "r") as file:
        require(file.schema == "hoomd" and file.gsd_version >= (2, 0), "not a HOOMD trajectory in GSD 2")
        summary = {"application": file.application, "frames": file.nframes, "gsd": gsd.version.version}
    with gsd.hoomd.open(arguments.trajectory, "r") as trajectory:
        check_schema(trajectory)
        if arguments.reference:
            check_reference(arguments.trajectory, trajectory)
    print(json.dumps(summary | {"status": "ok"}))


if __name__ == "__main__":
    main()
