"""Clusters, radii of gyration, distances of pairs and bond order from our GSD files, by freud.

The log of a run and its trajectory hold the same states; freud computes the columns of the log from the frames alone:
from positions, orientations and the meshes in the file.
"""

import csv

import freud
import gsd.hoomd
import numpy as np
import pytest

from conftest import rotation_matrix, sphere_mesh_off, write_assembly, write_sphere_body

GAP = 5.0  # Å, of contacts
BJERRUM = 7.0


def rows(path):
    with open(path) as file:
        return [{key: float(value) for key, value in row.items()} for row in csv.DictReader(file)]


def assemble(protomer, bodies, counts, box, output):
    protomer("assemble", "fluid", *bodies, "--counts", counts, "--box", box, "--seed", 3, "-o", output, parse=False)


def simulate(folder, protomer, assembly, *options):
    """Rows of the log and frames of the trajectory, one for one."""
    protomer("simulate", assembly, "-o", folder / "run", "--quiet", *options, parse=False)
    (log,) = (folder / "run").rglob("log.csv")
    with gsd.hoomd.open(str(log.with_name("trajectory.gsd"))) as trajectory:
        frames = list(trajectory)
    table = {row["sweep"]: row for row in rows(log)}
    return [table[frame.configuration.step] for frame in frames], frames


def surface_points(shape, spacing=1.0):
    """Points on every triangle of a mesh, about as far apart as the spacing (Å): one in each cell of 0.7 spacings, since
    long triangles alone would have five times as many."""
    corners = np.array(shape["vertices"])[np.array(shape["indices"])]
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max()
    parts = int(np.ceil(longest / spacing))
    weights = [(i, j, parts - i - j) for i in range(parts + 1) for j in range(parts + 1 - i)]
    points = np.einsum("wk,tkx->twx", np.array(weights) / parts, corners).reshape(-1, 3)
    _, chosen = np.unique(np.floor(points / (0.7 * spacing)), axis=0, return_index=True)
    return points[np.sort(chosen)]


def points_in_box(frame, shapes):
    """Points on the surfaces of all bodies, and of which body each is."""
    points, owners = [], []
    meshes = [surface_points(shape) for shape in shapes]
    for body in range(frame.particles.N):
        mesh = meshes[frame.particles.typeid[body]]
        rotation = rotation_matrix(frame.particles.orientation[body].astype(float))
        points.append(mesh @ rotation.T + frame.particles.position[body])
        owners += [body] * len(mesh)
    return np.concatenate(points), np.array(owners)


def largest_cluster(frame, shapes, gap=GAP, scale=1.0):
    """freud joins points of the surfaces nearer than the gap; a body is never in two clusters. Points 1 Å apart overrate the
    distance of surfaces by some hundredths of an Å."""
    box = freud.box.Box.from_box(frame.configuration.box)
    points, owners = points_in_box(frame, shapes)
    cluster = freud.cluster.Cluster().compute((box, box.wrap(points * scale)), neighbors={"r_max": gap})
    bodies = [set(owners[keys]) for keys in cluster.cluster_keys]
    assert sum(map(len, bodies)) == frame.particles.N, "a body is in two clusters"
    return max(map(len, bodies))


def r_g_of_pairs(frame):
    """Root of Σ r_ij² / 2 over all i and j, over N; freud finds the nearest images."""
    box = freud.box.Box.from_box(frame.configuration.box)
    distances = box.compute_all_distances(frame.particles.position, frame.particles.position).astype(float)
    return np.sqrt((distances**2).sum() / 2) / frame.particles.N


def r_g_of_cluster(frame):
    """About the centre that freud finds in the periodic box, all bodies together as one cluster."""
    box = freud.box.Box.from_box(frame.configuration.box)
    together = np.zeros(frame.particles.N, int)
    properties = freud.cluster.ClusterProperties().compute((box, frame.particles.position), together)
    return float(properties.radii_of_gyration[0])


def require_equal_column(ours, theirs, tolerance=0.0):
    assert len(ours) == len(theirs) > 1
    assert np.abs(np.array(ours) - theirs).max() <= tolerance


@pytest.fixture(scope="module")
def fluid(tmp_path_factory, protomer):
    """Sixteen spheres of opposite charges that cling together, in twos, threes and more."""
    folder = tmp_path_factory.mktemp("fluid")
    bodies = [write_sphere_body(folder, protomer, name, 8.0, charge) for name, charge in (("a", 7.0), ("b", -7.0))]
    assemble(protomer, bodies, "8,8", 130, folder / "fluid.json")
    return simulate(
        folder, protomer, folder / "fluid.json", "--bjerrum", f"{BJERRUM}A", "--debye", "9.6A", "--cutoff", "48A",
        "--equilibration", 50, "--sweeps", 600, "--log-every", 20, "--trajectory-every", 20, "--seed", 5,
    )


def test_largest_cluster_and_radius_of_gyration(fluid):
    log, frames = fluid
    shapes = frames[0].particles.type_shapes
    ours = [row["largest_cluster"] for row in log]
    theirs = [largest_cluster(frame, shapes) for frame in frames]
    print("largest clusters:", theirs)
    assert len(set(ours)) > 3, "the clusters hardly change: nothing is compared"
    require_equal_column(ours, theirs)
    r_g = [row["r_g_angstrom"] for row in log]
    distances = [r_g_of_pairs(frame) for frame in frames]
    print("R_g off by", np.abs(np.array(r_g) - distances).max())
    require_equal_column(r_g, distances, 2e-5)
    # The comparison must notice another gap, nm for Å, states of another row, and radii off by a part in 10 000.
    for wrong in ([largest_cluster(frame, shapes, gap=4.0) for frame in frames], theirs[1:] + theirs[:1]):
        with pytest.raises(AssertionError):
            require_equal_column(ours, wrong)
    for wrong in (np.array(distances) / 10, np.array(distances) * 1.0001, distances[1:] + distances[:1]):
        with pytest.raises(AssertionError):
            require_equal_column(r_g, wrong, 2e-5)


def test_meshes_turn_with_their_bodies(tmp_path, protomer):
    """Rods end to end: whether they touch depends on how the frames' orientations are read."""
    lines = sphere_mesh_off(6.0, bands=16).splitlines()
    count = int(lines[1].split()[0])
    for number in range(2, 2 + count):
        x, y, z = lines[number].split()
        lines[number] = f"{x} {y} {4 * float(z)!r}"
    mesh, charges, body = (tmp_path / f"rod.{suffix}" for suffix in ("off", "xyzq", "body"))
    mesh.write_text("\n".join(lines) + "\n")
    charges.write_text("0 0 0 0.0\n")
    protomer("body", "--mesh", mesh, "--charges", charges, "-o", body, parse=False)
    assemble(protomer, [body], 12, 140, tmp_path / "fluid.json")
    log, frames = simulate(
        tmp_path, protomer, tmp_path / "fluid.json", "--salt", "100mM", "--energy", "none", "--contact-gap", 6,
        "--equilibration", 20, "--sweeps", 300, "--log-every", 30, "--trajectory-every", 30,
    )
    shapes = frames[0].particles.type_shapes
    ours = [row["largest_cluster"] for row in log]
    theirs = [largest_cluster(frame, shapes, gap=6.0) for frame in frames]
    print("largest clusters of rods:", theirs)
    assert len(set(ours)) > 2, "the clusters hardly change: nothing is compared"
    require_equal_column(ours, theirs)
    # The comparison must notice quaternions read the other way round.
    for frame in frames:
        frame.particles.orientation[:, 1:] *= -1
    with pytest.raises(AssertionError):
        require_equal_column(ours, [largest_cluster(frame, shapes, gap=6.0) for frame in frames])


def test_radius_of_gyration_of_a_cluster(tmp_path, protomer):
    """A ring in a large box: freud's cluster, with its own centre, has the R_g of the log."""
    for name, charge in (("a", 12.0), ("b", -12.0)):
        write_sphere_body(tmp_path, protomer, name, 8.0, charge)
    angles = 2 * np.pi * np.arange(6) / 6
    around = enumerate(18 * np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=1))
    placements = [("ab"[k % 2], place, (1, 0, 0, 0)) for k, place in around]
    assembly = write_assembly(tmp_path / "ring.json", "ab", placements, 300.0)
    log, frames = simulate(
        tmp_path, protomer, assembly, "--bjerrum", f"{BJERRUM}A", "--debye", "9.6A", "--cutoff", "48A",
        "--equilibration", 20, "--sweeps", 200, "--log-every", 10, "--trajectory-every", 10,
    )
    assert all(row["largest_cluster"] == 6 for row in log)
    ours, theirs = [row["r_g_angstrom"] for row in log], [r_g_of_cluster(frame) for frame in frames]
    print("R_g of the ring:", ours[0], theirs[0], "off by", np.abs(np.array(ours) - theirs).max())
    require_equal_column(ours, theirs, 2e-4)
    for wrong in (np.array(theirs) / 10, theirs[1:] + theirs[:1]):
        with pytest.raises(AssertionError):
            require_equal_column(ours, wrong, 2e-4)


RADIUS, CHARGE, DEBYE, CUTOFF, BOX = 4.0, 8.0, 3.0, 20.0, 60.0
R_MIN, R_MAX, BINS = 9.5, 24.5, 15


def expected_rdf(debye=DEBYE, sign=1.0):
    """V exp(-U) / Z, mean over each bin; two bodies in a periodic box."""
    grid = np.linspace(0, R_MAX, 50001)[1:]
    energy = np.where(grid < CUTOFF, sign * BJERRUM * CHARGE**2 * np.exp(-grid / debye) / grid, 0.0)
    weight = np.where(grid < 2 * RADIUS, 0.0, np.exp(-np.clip(energy, -700.0, 700.0)))
    shell = 4 * np.pi * grid**2 * (grid[1] - grid[0])
    partition = BOX**3 - ((1 - weight) * shell).sum()
    edges = np.linspace(R_MIN, R_MAX, BINS + 1)
    inside = [(grid >= low) & (grid < high) for low, high in zip(edges, edges[1:])]
    return np.array([BOX**3 / partition * (weight * shell)[bin_].sum() / shell[bin_].sum() for bin_ in inside]), edges


def require_equal_rdf(found, expected, counts):
    """χ² over the bins with the errors of independent counts; 3 standard deviations of χ² are allowed."""
    chi_squared = ((found - expected) ** 2 / (expected**2 / np.maximum(counts, 1e-9))).sum()
    print("chi squared per bin:", chi_squared / BINS)
    assert chi_squared < BINS + 3 * np.sqrt(2 * BINS)


def test_radial_distribution_is_that_of_boltzmann(tmp_path, protomer):
    """Two like charges in a box: g(r) from freud against exp(-U)."""
    write_sphere_body(tmp_path, protomer, "a", RADIUS, CHARGE)
    placements = [("a", (x, 0, 0), (1, 0, 0, 0)) for x in (-12, 12)]
    assembly = write_assembly(tmp_path / "pair.json", "a", placements, BOX)
    _, frames = simulate(
        tmp_path, protomer, assembly, "--bjerrum", f"{BJERRUM}A", "--debye", f"{DEBYE}A", "--cutoff", f"{CUTOFF}A",
        "--equilibration", 1000, "--sweeps", 200000, "--log-every", 20, "--trajectory-every", 20, "--seed", 2,
    )
    expected, edges = expected_rdf()
    rdf = freud.density.RDF(bins=BINS, r_max=R_MAX, r_min=R_MIN, normalization_mode="finite_size")
    for frame in frames:
        rdf.compute((frame.configuration.box, frame.particles.position), reset=False)
    counts = len(frames) * expected * 4 / 3 * np.pi * (edges[1:] ** 3 - edges[:-1] ** 3) / BOX**3
    assert counts.min() > 5, "too few counts for a χ²"
    print("g(r):", np.round(rdf.rdf, 3), np.round(expected, 3))
    require_equal_rdf(rdf.rdf, expected, counts)
    # The comparison must notice a flipped charge, and a screening length that is 30 % off.
    for wrong in (expected_rdf(sign=-1.0)[0], expected_rdf(debye=1.3 * DEBYE)[0]):
        with pytest.raises(AssertionError):
            require_equal_rdf(rdf.rdf, wrong, counts)


def bond_order(box, centres, corners, fold):
    """ψ of each square from the four bonds to its corners."""
    squares, points = len(centres), np.concatenate([centres, corners])
    owners = np.repeat(np.arange(squares), 4)
    bonds = box.wrap(corners - centres[owners])
    neighbours = freud.locality.NeighborList.from_arrays(
        len(points), len(points), owners, squares + np.arange(4 * squares), bonds
    )
    return freud.order.Hexatic(k=fold).compute((box, points), neighbors=neighbours).particle_order[:squares]


def angles_by_freud(frame, shape):
    """θ of every square from the polygons and orientations in the file: four-fold order of the bonds to the corners."""
    squares = int((frame.particles.typeid == 0).sum())
    box = freud.box.Box(Lx=frame.configuration.box[0], Ly=frame.configuration.box[1], is2D=True)
    flat = np.c_[np.array(shape["vertices"]), np.zeros(4)]
    turns = [rotation_matrix(quaternion.astype(float)) for quaternion in frame.particles.orientation[:squares]]
    centres = frame.particles.position[:squares]
    corners = np.concatenate([flat @ turn.T + centre for turn, centre in zip(turns, centres)])
    psi = bond_order(box, centres, corners, 4)
    assert np.allclose(np.abs(psi), 1, atol=1e-4) and np.abs(bond_order(box, centres, corners, 6)).max() < 1e-3
    return np.angle(-psi) / 4, corners, box


def test_bond_order_of_a_lattice(tmp_path, protomer):
    """Amplitudes of the modes in the log from freud's four-fold order; dots on the corners; centres on a lattice."""
    size = 4
    protomer(
        "lattice", "run", "-o", tmp_path / "run", "--ns", size, "--r0", 0.3, "--start", 0.4, "--velocities", "random",
        "--dt", 0.001, "--time", 0.5, "--log-every", 50, "--trajectory-every", 50, "--json",
    )
    log = rows(tmp_path / "run" / "log.csv")
    with gsd.hoomd.open(str(tmp_path / "run" / "trajectory.gsd")) as trajectory:
        frames = list(trajectory)
    assert len(log) == len(frames) > 5
    shape = frames[0].particles.type_shapes[0]
    sign = np.array([(-1) ** (i + j) for i in range(size) for j in range(size)])
    theirs = {"uniform": [], "checkerboard": []}
    for frame in frames:
        angles, corners, box = angles_by_freud(frame, shape)
        theirs["uniform"].append(angles.mean())
        theirs["checkerboard"].append((sign * angles).mean())
        dots = frame.particles.position[size * size :]
        query = freud.locality.AABBQuery(box, corners).query(dots, {"num_neighbors": 1})
        assert max(distance for _, _, distance in query) < 1e-4, "an end of a rod is not on a corner"
    ours = {key: [row[key] for row in log] for key in theirs}
    assert np.ptp(ours["checkerboard"]) > 0.003, "the squares hardly turn"
    for key in theirs:
        print(key, "off by", np.abs(np.array(ours[key]) - theirs[key]).max())
        require_equal_column(ours[key], theirs[key], 1e-6)
        # The comparison must notice a sign and degrees.
        for wrong in (-np.array(theirs[key]), np.degrees(theirs[key])):
            with pytest.raises(AssertionError):
                require_equal_column(ours[key], wrong, 1e-6)
    # Before anything moves, a square inside has its four neighbours on a square lattice: |ψ4| is 1 and |ψ6| is not.
    centres = frames[0].particles.position[: size * size]
    inner = [i * size + j for i in range(1, size - 1) for j in range(1, size - 1)]
    for fold, expected in ((4, 1), (6, 0)):
        order = freud.order.Hexatic(k=fold).compute((box, centres), {"num_neighbors": 4}).particle_order
        assert np.allclose(np.abs(order[inner]), expected, atol=1e-5)


def test_table_of_a_sweep(tmp_path, protomer):
    """Means of a sweep over replicas and rows from all its trajectories."""
    for name, charge in (("a", 7.0), ("b", -7.0)):
        write_sphere_body(tmp_path, protomer, name, 8.0, charge)
    bodies = [tmp_path / f"{name}.body" for name in "ab"]
    assemble(protomer, bodies, "3,3", 130, tmp_path / "fluid.json")
    protomer(
        "sweep", tmp_path / "fluid.json", "--salt", "100mM,300mM", "--replicas", 2, "--equilibration", 50,
        "--sweeps", 200, "--log-every", 20, "--trajectory-every", 20, "-o", tmp_path / "sweep", "--quiet", parse=False,
    )
    for row in rows(tmp_path / "sweep" / "sweep.csv"):
        theirs = {"r_g_mean_angstrom": [], "largest_cluster_mean": []}
        for path in (tmp_path / "sweep" / f"salt_{row['salt_M']:.6f}M").rglob("trajectory.gsd"):
            with gsd.hoomd.open(str(path)) as trajectory:
                frames = list(trajectory)
            theirs["r_g_mean_angstrom"].append(np.mean([r_g_of_pairs(frame) for frame in frames]))
            shapes = frames[0].particles.type_shapes
            theirs["largest_cluster_mean"].append(np.mean([largest_cluster(frame, shapes) for frame in frames]))
        for key, values in theirs.items():
            print(row["salt_M"], key, row[key], values)
            require_equal_column([row[key]] * 2, [np.mean(values)] * 2, 1e-5)
            # The comparison must notice a replica that is left out (unless it is like the other), and nm for Å.
            left_out = [values[0]] if values[0] != np.mean(values) else []
            for wrong in (*left_out, np.mean(values) / 10):
                with pytest.raises(AssertionError):
                    require_equal_column([row[key]] * 2, [wrong] * 2, 1e-5)
