"""Yukawa energies, forces and torques of two and of sixteen bodies against OpenMM (CustomNonbondedForce, Reference).

V(r) = l_B q_i q_j exp(-r / l_D) / r below the cut-off and zero beyond it, between sites of different bodies only. The
binary prints energies: its forces and torques are two-sided differences of them, with a cut-off that no pair crosses.
"""

import numpy as np
import openmm
import pytest
from openmm import unit

from conftest import sphere_mesh_off, write_assembly

BJERRUM, DEBYE, CUTOFF = 7.0, 9.6, 48.0
BOX = 400.0


def random_rotation(rng):
    quaternion = rng.normal(size=4)
    return quaternion / np.linalg.norm(quaternion)


def rotate(quaternion, points):
    w, vector = quaternion[0], quaternion[1:]
    t = 2 * np.cross(vector, points)
    return points + w * t + np.cross(vector, t)


def turned(quaternion, rotation):
    """The quaternion after a further small rotation about the axes of space, radians."""
    angle = np.linalg.norm(rotation)
    w, v = np.cos(angle / 2), np.sin(angle / 2) * rotation / angle
    scalar, vector = quaternion[0], quaternion[1:]
    return np.array([w * scalar - v @ vector, *(w * vector + scalar * v + np.cross(v, vector))])


def write_bodies(folder, rng, protomer, sites):
    """Two kinds of spheres of radius 10 Å with random charges inside."""
    (folder / "sphere.off").write_text(sphere_mesh_off(10.0))
    charges = {}
    for name, net in (("a", 8.0), ("b", -5.0)):
        points = rng.normal(size=(sites, 3))
        points *= (9.0 * rng.uniform(size=(sites, 1)) ** (1 / 3)) / np.linalg.norm(points, axis=1, keepdims=True)
        charge = rng.normal(size=sites) * 0.4
        charge += (net - charge.sum()) / sites
        charges[name] = (points, charge)
        rows = (" ".join(map(repr, map(float, (*p, q)))) for p, q in zip(points, charge))
        (folder / f"{name}.xyzq").write_text("\n".join(rows) + "\n")
        protomer(
            "body", "--mesh", folder / "sphere.off", "--charges", folder / f"{name}.xyzq", "-o", folder / f"{name}.body",
            parse=False,
        )
    return charges


def placements(rng, count):
    """Bodies on a cubic lattice with some disorder, no two closer than 21 Å."""
    side = int(np.ceil(count ** (1 / 3)))
    grid = np.array([(i, j, k) for i in range(side) for j in range(side) for k in range(side)])[:count]
    positions = (grid - (side - 1) / 2) * 23.0 + rng.uniform(-0.5, 0.5, size=(count, 3))
    assert side * 23.0 + 2 * CUTOFF < BOX
    return [("ab"[i % 2], positions[i], random_rotation(rng)) for i in range(count)]


def our_energy(folder, protomer, bodies, cutoff=CUTOFF):
    """Total energy in kT, as `inspect` prints it."""
    path = write_assembly(folder / "assembly.json", "ab", bodies, BOX)
    medium = ["--bjerrum", f"{BJERRUM}A", "--debye", f"{DEBYE}A", "--cutoff", f"{cutoff}A"]
    outcome = protomer("inspect", path, *medium, "--energy", "direct", "--json")
    assert outcome["overlaps"] == []
    return outcome["energy_kT"]


def openmm_state(charges, bodies, cutoff=CUTOFF, debye=DEBYE):
    """Energy (kT) and the force (kT/Å) and torque (kT) on each body, OpenMM's kJ/mol and nm standing for kT and Å."""
    system = openmm.System()
    force = openmm.CustomNonbondedForce(f"{BJERRUM} * q1 * q2 * exp(-r / {debye}) / r")
    force.addPerParticleParameter("q")
    force.setNonbondedMethod(openmm.CustomNonbondedForce.CutoffPeriodic)
    force.setCutoffDistance(cutoff)
    system.setDefaultPeriodicBoxVectors(*(np.eye(3) * BOX))
    positions, groups = [], []
    for name, position, quaternion in bodies:
        points, charge = charges[name]
        groups.append(range(len(positions), len(positions) + len(points)))
        positions.extend(rotate(quaternion, points) + position)
        for q in charge:
            system.addParticle(1.0)
            force.addParticle([q])
    for i, first in enumerate(groups):
        for second in groups[i + 1 :]:
            force.addInteractionGroup(first, second)
    system.addForce(force)
    context = openmm.Context(system, openmm.VerletIntegrator(0.001), openmm.Platform.getPlatformByName("Reference"))
    positions = np.array(positions)
    context.setPositions(positions)
    state = context.getState(getEnergy=True, getForces=True)
    on_sites = state.getForces(asNumpy=True).value_in_unit(unit.kilojoule_per_mole / unit.nanometer)
    loads = []
    for (_, at, _), group in zip(bodies, groups):
        torques = np.cross(positions[group] - at, on_sites[group])
        loads.append(np.concatenate([on_sites[group].sum(axis=0), torques.sum(axis=0)]))
    return state.getPotentialEnergy().value_in_unit(unit.kilojoule_per_mole), np.array(loads)


def our_load(folder, protomer, bodies, body, cutoff, step=2e-4):
    """Force (kT/Å) and torque (kT) on one body: minus the differences of our energies."""
    load = []
    for component in range(6):
        ends = []
        for sign in (1, -1):
            name, at, turn = bodies[body]
            along = sign * step * np.eye(3)[component % 3]
            moved = (name, at + along, turn) if component < 3 else (name, at, turned(turn, along))
            ends.append(our_energy(folder, protomer, [*bodies[:body], moved, *bodies[body + 1 :]], cutoff))
        load.append(-(ends[0] - ends[1]) / (2 * step))
    return np.array(load)


def require_equal_energies(ours, theirs):
    assert ours == pytest.approx(theirs, rel=1e-9, abs=1e-9)


def require_equal_loads(ours, theirs):
    """To the error of the differences, in parts of the largest component; forces and torques apart."""
    for part in (slice(0, 3), slice(3, 6)):
        assert np.abs(ours[part] - theirs[part]).max() < 1e-6 * np.abs(theirs[part]).max()


def flipped(charges):
    return {name: (points, -charge if name == "a" else charge) for name, (points, charge) in charges.items()}


@pytest.mark.parametrize("count, sites", [(2, 300), (16, 60)])
def test_energy_equals_openmm(tmp_path, protomer, count, sites):
    rng = np.random.default_rng(count)
    charges = write_bodies(tmp_path, rng, protomer, sites)
    bodies = placements(rng, count)
    ours = our_energy(tmp_path, protomer, bodies)
    theirs = openmm_state(charges, bodies)[0]
    print(f"{count} bodies: {ours!r} and {theirs!r} kT")
    require_equal_energies(ours, theirs)
    # The comparison must notice a sign, a screening length, and nm for Å.
    wrong = [openmm_state(flipped(charges), bodies)[0], openmm_state(charges, bodies, debye=9.59)[0]]
    wrong.append(openmm_state(charges, bodies, debye=DEBYE / 10)[0])
    for energy in wrong:
        with pytest.raises(AssertionError):
            require_equal_energies(ours, energy)


@pytest.mark.parametrize("count, sites, body", [(2, 300, 0), (16, 60, 5)])
def test_forces_and_torques_equal_openmm(tmp_path, protomer, count, sites, body):
    rng = np.random.default_rng(100 + count)
    charges = write_bodies(tmp_path, rng, protomer, sites)
    bodies = placements(rng, count)
    cutoff = 120.0  # further than any two sites are apart
    ours = our_load(tmp_path, protomer, bodies, body, cutoff)
    theirs = openmm_state(charges, bodies, cutoff)[1][body]
    print(f"{count} bodies: force {theirs[:3]} kT/Å, torque {theirs[3:]} kT, off {np.abs(ours - theirs).max():.1e}")
    require_equal_loads(ours, theirs)
    # The comparison must notice a sign, exchanged axes, nm for Å, and a screening length.
    wrong = [-theirs, theirs[[0, 2, 1, 3, 5, 4]], 10 * theirs]
    wrong.append(openmm_state(charges, bodies, cutoff, debye=9.59)[1][body])
    for load in wrong:
        with pytest.raises(AssertionError):
            require_equal_loads(ours, load)
