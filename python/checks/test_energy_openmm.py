"""Yukawa energies of two and of sixteen charged bodies against OpenMM (CustomNonbondedForce, Reference platform).

V(r) = l_B q_i q_j exp(-r / l_D) / r below the cut-off and zero beyond it, between sites of different bodies only.
"""

import json

import numpy as np
import openmm
import pytest
from openmm import unit

from conftest import sphere_mesh_off

BJERRUM, DEBYE, CUTOFF = 7.0, 9.6, 48.0


def random_rotation(rng):
    quaternion = rng.normal(size=4)
    return quaternion / np.linalg.norm(quaternion)


def rotate(quaternion, points):
    w, vector = quaternion[0], quaternion[1:]
    t = 2 * np.cross(vector, points)
    return points + w * t + np.cross(vector, t)


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


def placements(rng, count, box):
    """Bodies on a cubic lattice with some disorder, no two closer than 21 Å."""
    side = int(np.ceil(count ** (1 / 3)))
    grid = np.array([(i, j, k) for i in range(side) for j in range(side) for k in range(side)])[:count]
    positions = (grid - (side - 1) / 2) * 23.0 + rng.uniform(-0.5, 0.5, size=(count, 3))
    assert side * 23.0 + 2 * CUTOFF < box
    return [("ab"[i % 2], positions[i], random_rotation(rng)) for i in range(count)]


def openmm_energy(charges, bodies, box):
    """Total energy in kT, with OpenMM's kJ/mol and nm standing for kT and Å."""
    system = openmm.System()
    force = openmm.CustomNonbondedForce(f"{BJERRUM} * q1 * q2 * exp(-r / {DEBYE}) / r")
    force.addPerParticleParameter("q")
    force.setNonbondedMethod(openmm.CustomNonbondedForce.CutoffPeriodic)
    force.setCutoffDistance(CUTOFF)
    system.setDefaultPeriodicBoxVectors(*(np.eye(3) * box))
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
    context.setPositions(np.array(positions))
    return context.getState(getEnergy=True).getPotentialEnergy().value_in_unit(unit.kilojoule_per_mole)


@pytest.mark.parametrize("count, sites", [(2, 300), (16, 60)])
def test_energy_equals_openmm(tmp_path, protomer, count, sites):
    rng = np.random.default_rng(count)
    box = 400.0
    charges = write_bodies(tmp_path, rng, protomer, sites)
    bodies = placements(rng, count, box)
    assembly = {
        "box_angstrom": [box] * 3,
        "bodies": [{"name": name, "file": f"{name}.body"} for name in "ab"],
        "placements": [
            {"body": name, "position_angstrom": list(position), "orientation_wxyz": list(quaternion)}
            for name, position, quaternion in bodies
        ],
    }
    (tmp_path / "assembly.json").write_text(json.dumps(assembly))
    conditions = ["--bjerrum", f"{BJERRUM}A", "--debye", f"{DEBYE}A", "--cutoff", f"{CUTOFF}A"]
    ours = protomer("inspect", tmp_path / "assembly.json", *conditions, "--energy", "direct", "--json")
    theirs = openmm_energy(charges, bodies, box)
    assert ours["overlaps"] == []
    assert ours["energy_kT"] == pytest.approx(theirs, rel=1e-9, abs=1e-9)
    # The comparison must notice a wrong sign and a wrong screening length.
    flipped = {name: (points, -charge if name == "a" else charge) for name, (points, charge) in charges.items()}
    assert abs(openmm_energy(flipped, bodies, box) - ours["energy_kT"]) > 1e-3
    weaker = protomer("inspect", tmp_path / "assembly.json", *conditions[:2], "--debye", "9.5A", *conditions[4:], "--json")
    assert abs(weaker["energy_kT"] - theirs) > 1e-4
