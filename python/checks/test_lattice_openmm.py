"""The lattice of squares and rods, before anything collides, against constrained points in OpenMM (Reference platform).

There a square is five points: its centre and its corners, held by seven distances, of masses that give the square its
mass 1 and its moment of inertia 4 m l² = 1/3. A rod is a distance between two corners. protomer moves x, y, θ instead, so
the two agree only in the limit of short steps: their difference must fall with the square of the step.
"""

import json

import gsd.hoomd
import numpy as np
import openmm
import pytest

ROD = 0.3
CORNERS = np.array([[-1, 1], [1, 1], [-1, -1], [1, -1]]) / np.sqrt(2)  # vertices 1 to 4 of the guide at θ = 0
CORNER_MASS = 1 / 12


def points(state):
    """Centre and corners of every square from x, y, θ, in space: (5 n, 3)."""
    x, y, theta = np.asarray(state).T
    cosine, sine = np.cos(theta)[:, None], np.sin(theta)[:, None]
    out = np.zeros((len(x), 5, 3))
    out[:, :, 0], out[:, :, 1] = x[:, None], y[:, None]
    out[:, 1:, 0] += cosine * CORNERS[:, 0] - sine * CORNERS[:, 1]
    out[:, 1:, 1] += sine * CORNERS[:, 0] + cosine * CORNERS[:, 1]
    return out.reshape(-1, 3)


def point_velocities(state, rates):
    """Of the points, from x, y, θ and their rates."""
    step = 1e-5
    forward, back = (points(np.asarray(state) + sign * step * np.asarray(rates)) for sign in (1, -1))
    return (forward - back) / (2 * step)


def rods_of_lattice(size):
    """Pairs of points that the rods join (Table I of the paper): even squares give corners 4 and 3."""
    rods = []
    for i in range(size):
        for j in range(size):
            here, even = i * size + j, (i + j) % 2 == 0
            if j + 1 < size:
                rods.append((5 * here + (4 if even else 2), 5 * (here + 1) + (3 if even else 1)))
            if i + 1 < size:
                rods.append((5 * here + (3 if even else 4), 5 * (here + size) + (1 if even else 2)))
    return rods


def constrained(squares, rods, integrator, corner_mass=CORNER_MASS):
    """An OpenMM context of squares and rods; lengths and times are those of the lattice."""
    system = openmm.System()
    for square in range(squares):
        system.addParticle(1 - 4 * corner_mass)
        for corner in range(1, 5):
            system.addParticle(corner_mass)
            system.addConstraint(5 * square, 5 * square + corner, 1.0)
        for first, second in ((1, 2), (2, 4), (4, 3)):
            system.addConstraint(5 * square + first, 5 * square + second, np.sqrt(2))
    for first, second in rods:
        system.addConstraint(first, second, ROD)
    integrator.setConstraintTolerance(1e-12)
    return openmm.Context(system, integrator, openmm.Platform.getPlatformByName("Reference"))


def run_trajectory(folder, protomer, step, steps):
    """x, y, θ of every step of `lattice run` (frames, squares, 3), and the pairs of points that its rods join."""
    folder = folder / f"run_{step}"
    outcome = protomer(
        "lattice", "run", "-o", folder, "--ns", 3, "--r0", ROD, "--start", 0.4, "--velocities", "random", "--dt", step,
        "--steps", steps, "--trajectory-every", 1, "--json",
    )
    assert outcome["events"] == 0, "the run must not collide"
    with gsd.hoomd.open(str(folder / "trajectory.gsd")) as trajectory:
        states = np.array([frame.log["positions"] for frame in trajectory])
        first, squares = trajectory[0], states.shape[1]
        corners, dots = points(states[0]), first.particles.position[squares:]
        distances = np.linalg.norm(corners[None] - dots[:, None], axis=2)
        assert distances.min(axis=1).max() < 1e-6, "an end of a rod is not on a corner"
        ends = distances.argmin(axis=1)
        return states, [tuple(ends[pair - squares]) for pair in first.bonds.group.astype(int)]


def openmm_trajectory(states, rods, step, corner_mass=CORNER_MASS):
    """Points of every step, from the first two frames: OpenMM's leapfrog has the velocities of the middle of a step."""
    integrator = openmm.VerletIntegrator(step)
    context = constrained(states.shape[1], rods, integrator, corner_mass)
    before, now = points(states[0]), points(states[1])
    context.setPositions(now)
    context.setVelocities((now - before) / step)
    out = [before, now]
    for _ in states[2:]:
        integrator.step(1)
        out.append(np.array(context.getState(getPositions=True).getPositions(asNumpy=True)._value))
    return np.array(out)


def require_second_order(differences, largest):
    """Of two runs, the second with half the step of the first."""
    coarse, fine = differences
    assert coarse < largest and fine < largest
    assert 3.5 < coarse / fine < 4.5


def test_rods_of_a_run_equal_constraints(tmp_path, protomer):
    runs = [(*run_trajectory(tmp_path, protomer, step, steps), step) for step, steps in ((0.002, 250), (0.001, 500))]
    assert [tuple(sorted(rod)) for rod in runs[0][1]] == [tuple(sorted(rod)) for rod in rods_of_lattice(3)]
    assert np.abs(runs[0][0][-1] - runs[0][0][0]).max() > 0.2, "nothing moves"

    def differences(**changes):
        ours = [np.array([points(state) for state in states]) for states, _, _ in runs]
        return [np.abs(openmm_trajectory(*run, **changes) - mine).max() for run, mine in zip(runs, ours)]

    found = differences()
    print("largest difference of a point:", found)
    require_second_order(found, 1e-6)
    # The comparison must notice another moment of inertia, and angles that turn the other way.
    with pytest.raises(AssertionError):
        require_second_order(differences(corner_mass=0.09), 1e-6)
    for states, _, _ in runs:
        states[2:, :, 2] *= -1
    with pytest.raises(AssertionError):
        require_second_order(differences(), 1e-6)


def replayed(folder, protomer, start, rates, times, step):
    """States, rates and energies at these times, by `lattice replay`."""
    path = folder / "state.json"
    flat = lambda values: np.asarray(values).ravel().tolist()
    path.write_text(json.dumps({"ns": 3, "r0": ROD, "s0": flat(start), "v0": flat(rates), "times": times}))
    outcome = protomer("lattice", "replay", path, "--dt", step, "--json")
    shaped = lambda values: np.array(values).reshape(len(times), -1, 3)
    return shaped(outcome["s"]), shaped(outcome["v"]), np.array(outcome["energy"])


def motion_of_replay(folder, protomer, start, rates, times, step):
    """Points, their velocities and the energy at these times."""
    states, all_rates, energies = replayed(folder, protomer, start, rates, times, step)
    velocities = [point_velocities(state, rate) for state, rate in zip(states, all_rates)]
    return np.array([points(state) for state in states]), np.array(velocities), energies


def motion_of_openmm(start, rates, times, step):
    """The same by OpenMM. Velocities are (x(t + h) - x(t - h)) / 2 h; its own leave the constraints in first order."""
    integrator = openmm.VerletIntegrator(step)
    context = constrained(len(start), rods_of_lattice(3), integrator)
    context.setPositions(points(start))
    context.setVelocities(point_velocities(start, rates))
    path = [points(start)]
    for _ in range(round(times[-1] / step) + 1):
        integrator.step(1)
        path.append(np.array(context.getState(getPositions=True).getPositions(asNumpy=True)._value))
    path, at = np.array(path), np.array([round(time / step) for time in times])
    velocities = (path[at + 1] - path[at - 1]) / (2 * step)
    masses = np.tile([1 - 4 * CORNER_MASS] + [CORNER_MASS] * 4, len(start))
    return path[at], velocities, 0.5 * (masses[:, None] * velocities**2).sum(axis=(1, 2))


def test_velocities_and_energies_of_a_replay(tmp_path, protomer):
    times, steps = [0.1, 0.2, 0.3], (0.002, 0.001)
    states, _ = run_trajectory(tmp_path, protomer, 0.001, 3)
    # A state whose rates obey the rods: `replay` makes it so in one step from rates that almost do.
    rates = (states[2] - states[0]) / (2 * 0.001)
    start, rates = (values[0] for values in replayed(tmp_path, protomer, states[1], rates, [0.001], 0.001)[:2])
    ours = [motion_of_replay(tmp_path, protomer, start, rates, times, step) for step in steps]

    def differences(quantity, factor=1.0):
        theirs = (motion_of_openmm(start, factor * rates, times, step)[quantity] for step in steps)
        return [np.abs(mine[quantity] - other).max() for mine, other in zip(ours, theirs)]

    for quantity, name in enumerate(("points", "velocities", "energies")):
        found = differences(quantity)
        print(f"largest difference of {name}:", found)
        require_second_order(found, 2e-5)
        # The comparison must notice a start that turns the other way (no energy tells that) and a unit of time.
        for factor in (1.001,) if name == "energies" else (-1.0, 1.001):
            with pytest.raises(AssertionError):
                require_second_order(differences(quantity, factor), 2e-5)
