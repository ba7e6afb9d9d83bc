"""Energy, forces and Hessian of periodic networks of rods and hinges against OpenMM (HarmonicBondForce, HarmonicAngleForce).

OpenMM's bonded forces carry no image index: they take the nearest image, so the boxes are two cells wide or more.
"""

import tomllib

import numpy as np
import openmm
import pytest

KJ_PER_KCAL, ANGSTROM_PER_NM = 4.184, 10.0
NETWORKS = {
    "honeycomb": ["honeycomb", "--h", 2, "--l", 1, "--theta", 60, "--kh", 50, "--ks", 400, "--cells", "2x2"],
    "diamond": ["diamond", "--edge", 3, "--kh", 20, "--ks", 300, "--cells", "2x2x2"],
}


def angle(a, b):
    return np.arccos(np.dot(a, b) / np.linalg.norm(a) / np.linalg.norm(b))


def displaced(network, rng, amount):
    """The network with its rest lengths and angles written out and its nodes moved."""
    cell, nodes = np.array(network["cell_angstrom"]), np.array(network["nodes_angstrom"])
    place = lambda end: nodes[end["node"]] + np.array(end["image"]) @ cell
    for rod in network["rods"]:
        rod["rest_length_angstrom"] = float(np.linalg.norm(place(rod["to"]) - nodes[rod["from"]]) * rng.uniform(0.99, 1.01))
    for hinge in network["hinges"]:
        first, second = (place(end) - nodes[hinge["vertex"]] for end in hinge["between"])
        hinge["rest_angle_rad"] = float(angle(first, second) * rng.uniform(0.99, 1.01))
    network["nodes_angstrom"] = (nodes + rng.uniform(-amount, amount, size=nodes.shape)).tolist()
    return network


def toml(value):
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {toml(item)}" for key, item in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(map(toml, value)) + "]"
    return repr(value)


def openmm_force(network, kj_per_kcal=KJ_PER_KCAL, angle_scale=1.0):
    """A function from node positions (Å) to energy (kcal/mol) and forces (kcal/mol/Å)."""
    cell = np.array(network["cell_angstrom"])
    plane = len(cell) == 2
    box = np.eye(3) * 50.0
    box[3 - len(cell) :, 3 - len(cell) :] = cell
    system = openmm.System()
    system.setDefaultPeriodicBoxVectors(*(box / ANGSTROM_PER_NM))
    for _ in network["nodes_angstrom"]:
        system.addParticle(1.0)
    bonds, angles = openmm.HarmonicBondForce(), openmm.HarmonicAngleForce()
    for rod in network["rods"]:
        k = rod["stiffness_kcal_mol_angstrom2"] * kj_per_kcal * ANGSTROM_PER_NM**2
        bonds.addBond(rod["from"], rod["to"]["node"], rod["rest_length_angstrom"] / ANGSTROM_PER_NM, k)
    for hinge in network["hinges"]:
        first, second = (end["node"] for end in hinge["between"])
        k = hinge["stiffness_kcal_mol_rad2"] * kj_per_kcal
        angles.addAngle(first, hinge["vertex"], second, angle_scale * hinge["rest_angle_rad"], k)
    for force in (bonds, angles):
        force.setUsesPeriodicBoundaryConditions(True)
        system.addForce(force)
    context = openmm.Context(system, openmm.VerletIntegrator(0.001), openmm.Platform.getPlatformByName("Reference"))

    def evaluate(nodes):
        positions = np.zeros((len(nodes), 3))
        positions[:, 1 if plane else 0 :] = nodes
        context.setPositions(positions / ANGSTROM_PER_NM)
        state = context.getState(getEnergy=True, getForces=True)
        energy = state.getPotentialEnergy().value_in_unit(openmm.unit.kilojoule_per_mole) / KJ_PER_KCAL
        forces = state.getForces(asNumpy=True).value_in_unit(openmm.unit.kilojoule_per_mole / openmm.unit.nanometer)
        forces = np.array(forces) / KJ_PER_KCAL / ANGSTROM_PER_NM
        if plane:
            assert np.abs(forces[:, 0]).max() < 1e-9
        return energy, forces[:, 1 if plane else 0 :].ravel()

    return evaluate


def hessian(evaluate, nodes, step=1e-4):
    """Minus the two-sided differences of forces."""
    flat, columns = np.array(nodes), []
    for index in np.ndindex(flat.shape):
        ends = []
        for sign in (1, -1):
            moved = flat.copy()
            moved[index] += sign * step
            ends.append(evaluate(moved)[1])
        columns.append(-(ends[0] - ends[1]) / (2 * step))
    return np.array(columns)


def deviations(ours, evaluate, nodes):
    """Of energy, forces and Hessian, each in parts of its largest value."""
    energy, forces = evaluate(nodes)
    theirs = energy, forces, hessian(evaluate, nodes)
    keys = "energy_kcal_mol", "forces_kcal_mol_angstrom", "hessian_kcal_mol_angstrom2"
    return [np.abs(np.array(ours[key]) - value).max() / np.abs(value).max() for key, value in zip(keys, theirs)]


def require_small(found):
    energy, forces, curvature = found
    assert energy < 1e-9 and forces < 1e-8 and curvature < 1e-6


@pytest.mark.parametrize("name", NETWORKS)
def test_derivatives_equal_openmm(tmp_path, protomer, name):
    rng = np.random.default_rng(7)
    protomer("framework", *NETWORKS[name], "--write", tmp_path / "built.toml", "--quiet", parse=False)
    network = displaced(tomllib.loads((tmp_path / "built.toml").read_text()), rng, 0.02)
    path = tmp_path / "moved.toml"
    path.write_text("\n".join(f"{key} = {toml(value)}" for key, value in network.items()) + "\n")
    ours = protomer("framework", path, "--derivatives", "--json")["derivatives"]
    nodes = np.array(network["nodes_angstrom"])
    assert ours["energy_kcal_mol"] > 0.1 and np.abs(ours["forces_kcal_mol_angstrom"]).max() > 1
    found = deviations(ours, openmm_force(network), nodes)
    print(f"{name}: energy {found[0]:.1e}, forces {found[1]:.1e}, Hessian {found[2]:.1e}")
    require_small(found)
    # The comparison must notice a unit left out, an angle in other units, and a sign.
    flipped = dict(ours, forces_kcal_mol_angstrom=[-force for force in ours["forces_kcal_mol_angstrom"]])
    wrong = [
        deviations(ours, openmm_force(network, kj_per_kcal=1.0), nodes),
        deviations(ours, openmm_force(network, angle_scale=np.pi / 3), nodes),
        deviations(flipped, openmm_force(network), nodes),
    ]
    for found in wrong:
        with pytest.raises(AssertionError):
            require_small(found)
