"""Simulations in memory: their arrays, loops, schedules and states of one's own."""

import re
from pathlib import Path

import numpy as np
import protomer as pm
import pytest

ROOT = Path(__file__).resolve().parents[2]


def squares(**settings):
    return pm.HardBodies("polygon:4", **{"bodies": 50, "packing_fraction": 0.5, "seed": 4, **settings})


@pytest.fixture
def disk(tmp_path):
    path = tmp_path / "point.txt"
    path.write_text("0 0\n")
    return str(path)


def test_arrays_are_the_same_objects_and_cannot_be_written_to():
    bodies = squares()
    positions, before = bodies.positions, bodies.positions.copy()
    bodies.run(5)
    assert bodies.positions is positions and not (positions == before).all()
    assert np.shares_memory(positions, bodies.positions)
    with pytest.raises(ValueError, match="read-only"):
        positions[0] = 0.0


def test_a_loop_samples_what_the_command_samples(tmp_path):
    gsd = pytest.importorskip("gsd.hoomd")
    settings = {"bodies": 50, "packing_fraction": 0.5, "seed": 4, "equilibration": 20}
    pm.hpmc.run(shape="polygon:4", sweeps=40, trajectory_every=20, output=tmp_path / "run", **settings)
    bodies = squares(equilibration=20)
    with gsd.open(str(tmp_path / "run" / "trajectory.gsd")) as frames:
        for frame in frames:
            bodies.run(frame.configuration.step - bodies.sweep)
            np.testing.assert_allclose(bodies.positions, frame.particles.position[:, :2], atol=1e-5)
    assert bodies.sweep == 60


def test_observers_are_called_at_their_sweeps_whatever_the_calls_of_run():
    seen = []
    bodies = squares()
    stop = bodies.every(7, lambda bodies: seen.append(bodies.sweep))
    bodies.every(10, lambda bodies: seen.append(-bodies.sweep))
    for sweeps in [5, 16, 9]:
        bodies.run(sweeps)
    stop()
    bodies.run(5)
    assert seen == [7, -10, 14, -20, 21, 28, -30]
    with pytest.raises(pm.ConfigError, match="count is 0"):
        bodies.every(0, print)
    with pytest.raises(pm.ConfigError, match="count is -1"):
        bodies.run(-1)


@pytest.mark.parametrize("engine", ["hard bodies", "dynamics"])
def test_a_saved_state_goes_on_bit_for_bit(engine):
    bodies = squares() if engine == "hard bodies" else pm.ContactDynamics(
        "polygon:4", bodies=36, packing_fraction=0.4, ensemble="langevin", compress_steps=20, equilibrate_steps=20
    )
    bodies.run(30)
    saved = bodies.save()
    first = bodies.run(30).positions.copy()
    bodies.restore(saved)
    assert bodies.done == 30
    assert (bodies.run(30).positions == first).all()
    with pytest.raises(pm.ProtomerError, match="saved"):
        bodies.restore(b"{}")


def test_a_state_that_overlaps_or_does_not_fit_is_refused_and_changes_nothing():
    pair = pm.HardBodies("polygon:4", positions=[[-1, 0], [1, 0]], box=[6, 6])
    before = pair.positions.copy()
    with pytest.raises(pm.GeometryError, match="1 pair"):
        pair.place(positions=[[0, 0], [0.5, 0]])
    for arrays, words in [
        ({"positions": [[0, 0, 0]] * 2}, "positions has 3 columns; give 2"),
        ({"positions": [[0, 0]] * 3}, "3 rows"),
        ({"places": [[0, 0]] * 2}, "there is no array places"),
        ({"box": [6]}, "box has 1 numbers"),
        ({"orientations": [[0, 0, 0, 0]] * 2}, "quaternion of zeros"),
        ({"positions": [[np.nan, 0], [1, 0]]}, "finite"),
    ]:
        with pytest.raises(pm.ProtomerError, match=re.escape(words)):
            pair.place(**arrays)
    assert (pair.positions == before).all()
    with pytest.raises(pm.ConfigError, match="pressur"):
        pair.change(pressur=1)
    with pytest.raises(pm.ProtomerError, match="other bodies"):
        pair.change(shape="polygon:5")
    with pytest.raises(pm.ProtomerError, match="positions"):
        pm.HardBodies("polygon:4", angles=[0.0, 0.1], box=[6, 6])


def test_turned_bodies_in_a_tilted_box_come_back_as_they_were_given():
    angles = np.array([0.3, -2.0])
    pair = pm.HardBodies("polygon:5", positions=[[-1, 0.5], [1, 0]], angles=angles, box=[6, 5, 0.2])
    np.testing.assert_allclose(pair.angles, angles)
    np.testing.assert_allclose(pair.box, [6, 5, 0, 0.2, 0, 0])
    np.testing.assert_allclose(pair.positions, [[-1, 0.5], [1, 0]])


def test_a_ramp_of_pressure_compresses_hard_rods_to_their_exact_density():
    """Hard rods of length 1 on a line: βP = ρ / (1 - ρ) (Tonks)."""
    rods = pm.HardBodies("rod:1", bodies=50, packing_fraction=0.3, pressure=1.0, equilibration=500)
    rods.run(500)
    for pressure in [1.0, 4.0]:
        rods.change(pressure=pressure)
        rods.run(200)
        densities = []
        stop = rods.every(5, lambda rods: densities.append(len(rods) / rods.box[0]))
        rods.run(6000)
        stop()
        blocks = np.array(densities).reshape(10, -1).mean(1)
        # At constant pressure the mean of V is exact: N + (N + 1)/P for N rods on a ring with the measure V dV/V.
        error = blocks.std(ddof=1) / np.sqrt(10)
        assert abs(blocks.mean() - pressure / (1 + pressure)) < 4 * error + 0.01, pressure


def test_ten_lines_sample_disks_on_a_spring(disk):
    """Two hard disks, u(r) = 4 (r - 1.5)²: the density of r is r exp(-u) from contact on."""
    box = 8.0
    random = np.random.default_rng(1)

    def distance(disks):
        apart = disks.positions[0] - disks.positions[1]
        return float(np.linalg.norm(apart - box * np.round(apart / box)))

    disks = pm.HardBodies(disk, rounding_radius=0.5, positions=[[0, 0], [1.5, 0]], box=[box, box], equilibration=0)
    energy, found = 0.0, []
    for _ in range(6000):
        before = disks.positions.copy()
        proposed = 4.0 * (distance(disks.run(4)) - 1.5) ** 2
        if np.log(random.random()) < energy - proposed:
            energy = proposed
        else:
            disks.place(positions=before)
        found.append(distance(disks))
    r = np.linspace(1.0, 4.0, 3001)
    weight = r * np.exp(-4.0 * (r - 1.5) ** 2)
    exact = (r * weight).sum() / weight.sum()
    blocks = np.array(found[1000:]).reshape(10, -1).mean(1)
    assert abs(blocks.mean() - exact) < 4 * blocks.std(ddof=1) / np.sqrt(10)
    assert min(found) >= 1.0


def test_bodies_in_motion_keep_their_energy_and_take_over_arrays():
    first = pm.ContactDynamics("cube", bodies=27, packing_fraction=0.3, compress_steps=100, equilibrate_steps=100, seed=2)
    first.run(400)
    arrays = {name: getattr(first, name) for name in ["positions", "orientations", "velocities", "spins", "box"]}
    second = pm.ContactDynamics("cube", seed=2, **arrays)
    assert second.step == 0 and abs(second.measure()["energy"] - first.measure()["energy"]) < 1e-9
    energy = second.measure()["energy"]
    second.run(500)
    assert abs(second.measure()["energy"] - energy) < 1e-3
    second.change(ensemble="nvt", temperature=2.0, relaxation_time=0.01)
    second.run(3000)
    assert second.measure()["temperature"] > 1.5
    with pytest.raises(pm.ProtomerError, match="other bodies"):
        second.change(packing_fraction=0.1)


def test_kinds_and_potentials_are_given_in_memory(disk):
    """A square and a triangle, and two disks in a well: their energy is that of the well."""
    pair = pm.HardBodies(["polygon:4", "polygon:3"], positions=[[-1, 0], [1, 0]], kinds=[1, 0], box=[6, 6])
    assert len(pair.run(20)) == 2
    well = [{"kind": "square-well", "range": 1.5, "depth_kt": 2.0}]
    disks = pm.HardBodies(disk, rounding_radius=0.5, positions=[[0, 0], [1.2, 0]], box=[8, 8], potential=well)
    assert disks.measure()["energy_kt_per_body"] == -1.0
    disks.place(positions=[[0, 0], [2.2, 0]])
    assert disks.measure()["energy_kt_per_body"] == 0.0
    with pytest.raises(pm.ConfigError, match="depth"):
        disks.change(potential=[{"kind": "square-well", "range": 1.5, "depth": 2.0}])


def test_bodies_in_motion_have_potentials_and_fields_in_memory():
    """Two ellipsoids out of each other's reach feel their table alone: 1 kT at a distance of 2, and that of their heights."""
    table = [{"kind": "radial", "distances": [1.5, 2.0, 2.5], "energies_kt": [3.0, 1.0, 0.0]}]
    settings = {"keep_size": True, "temperature": 2.0, "ensemble": "nve", "pair_potential": table}
    pair = {"positions": [[0, 0, 0], [2, 0, 0]], "velocities": [[0, 0, 0.5], [0, 0, 0]], "box": [9, 9, 9]}
    balls = pm.ContactDynamics("ellipsoid:0.5,0.5,0.5", **settings, **pair)
    assert balls.measure()["potential_energy"] == balls.measure()["pair_potential_energy"] == 1.0
    energy = balls.measure()["energy"]
    balls.run(2000)
    assert balls.measure()["potential_energy"] < 1.0 and abs(balls.measure()["energy"] - energy) < 1e-6
    field = {"heights": [0.0, 4.5, 9.0], "energies_kt": [3.0, 1.0, 3.0]}
    fallen = pm.ContactDynamics("ellipsoid:0.5,0.5,0.5", field=field, **settings, **pair)
    assert fallen.measure()["potential_energy"] == pytest.approx(3.0)
    assert fallen.measure()["field_energy"] == pytest.approx(2.0) and "field_energy" not in balls.measure()
    for changed in ({"temperature": 1.0}, {"pair_potential": []}):
        with pytest.raises(pm.ProtomerError, match="other bodies"):
            balls.change(**changed)
    with pytest.raises(pm.ProtomerError, match="no finite force"):
        well = [{"kind": "square-well", "range": 1.5, "depth_kt": 2.0}]
        pm.ContactDynamics("cube", **pair, pair_potential=well)


def test_files_are_those_of_the_command(tmp_path):
    gsd = pytest.importorskip("gsd.hoomd")
    bodies = squares()
    bodies.write_to(tmp_path / "mine")
    for _ in range(3):
        bodies.run(5)
        row = bodies.log()
        bodies.frame()
    text = (tmp_path / "mine" / "log.csv").read_text().splitlines()
    pm.hpmc.run(shape="polygon:4", bodies=50, packing_fraction=0.5, equilibration=0, sweeps=5, output=tmp_path / "run")
    assert text[0] == (tmp_path / "run" / "log.csv").read_text().splitlines()[0]
    assert len(text) == 4 and row["sweep"] == 15
    with gsd.open(str(tmp_path / "mine" / "trajectory.gsd")) as frames:
        assert [frame.configuration.step for frame in frames] == [5, 10, 15]
        np.testing.assert_allclose(frames[2].particles.position[:, :2], bodies.positions, atol=1e-5)
    with pytest.raises(FileExistsError, match="not empty"):
        bodies.write_to(tmp_path / "mine")


def test_a_file_of_another_program_starts_both_engines(tmp_path):
    gsd = pytest.importorskip("gsd.hoomd")
    frame = gsd.Frame()
    frame.configuration.box = [8, 8, 0, 0, 0, 0]
    frame.configuration.dimensions = 2
    places = (np.arange(5) - 2) * 1.55
    frame.particles.position = np.array([[x, y, 0] for x in places for y in places])
    frame.particles.N = 25
    frame.particles.velocity = np.random.default_rng(1).normal(size=(25, 3)) * [1, 1, 0]
    path = str(tmp_path / "mine.gsd")
    with gsd.open(path, "w") as file:
        file.append(frame)
    run = {"shape": "polygon:5", "start": path, "equilibration": 20, "output": tmp_path / "hard"}
    first = pm.hpmc.run(sweeps=20, **run)
    longer = pm.hpmc.run(sweeps=40, **run)
    assert (first.bodies, longer.sweeps) == (25, 40)
    np.testing.assert_allclose(longer.box_edges, [8, 8])
    moved = pm.md.run(shape="polygon:5", start=path, equilibrate_steps=0, compress_steps=0, steps=50, output=tmp_path / "moving")
    energy = 0.5 * (frame.particles.velocity**2).sum() / 25
    assert moved.bodies == 25 and abs(moved.energy_per_body - energy) < 0.05 * energy
    with pytest.raises(pm.ProtomerError, match="3-dimensional|dimensions"):
        pm.hpmc.run(shape="cube", start=path, sweeps=20, output=tmp_path / "cubes")


def test_an_assembly_moves_in_memory_as_its_command_moves_it(ring, tmp_path):
    settings = {"salt": "100mM", "equilibration": 4, "seed": 3, "energy": "direct"}
    run = pm.simulate(ring, sweeps=6, trajectory_every=2, log_every=2, output=tmp_path / "run", **settings)
    bodies = pm.AssemblySimulation(ring, **settings)
    bodies.run(10)
    last = run.trajectory()[-1]
    np.testing.assert_allclose(bodies.positions, last.positions_angstrom, atol=1e-3)
    assert abs(bodies.measure()["energy_kT"] - run.log["energy_kT"][-1]) < 1e-9
    np.testing.assert_allclose(bodies.box[:3], 640.0)

    saved = bodies.save()
    first = bodies.run(4).positions.copy()
    bodies.restore(saved)
    assert (bodies.run(4).positions == first).all()

    # Screening by more salt weakens the attraction of opposite charges at the same places.
    again = pm.AssemblySimulation(pm.Assembly.read(ring), start=tmp_path / "run", **settings)
    np.testing.assert_allclose(again.positions, last.positions_angstrom)
    strong = again.measure()["energy_kT"]
    again.change(salt_M=[0.5])
    assert 0 > again.measure()["energy_kT"] > strong

    with pytest.raises(pm.GeometryError, match="overlap"):
        again.place(positions=np.zeros((4, 3)))
    with pytest.raises(pm.ProtomerError, match="leave box out"):
        again.place(box=[[100, 100, 100]])
    with pytest.raises(pm.ConfigError, match="salt"):
        pm.AssemblySimulation(ring)
    with pytest.raises(pm.ConfigError, match="sed"):
        pm.AssemblySimulation(ring, salt="100mM", sed=1)


def test_a_command_starts_where_a_file_of_another_program_has_the_bodies(ring, tmp_path):
    gsd = pytest.importorskip("gsd.hoomd")
    turned = np.array([[1, 0, 0, 0], [0, 1, 0, 0], [0.5, 0.5, 0.5, 0.5], [0.8, 0, 0.6, 0]])
    places = np.array([[x, 7.0, -5.0] for x in (-90, -30, 30, 90)], dtype=float)
    path = tmp_path / "mine.gsd"
    with gsd.open(str(path), "w") as file:
        for shift in (0.0, 25.0):
            frame = gsd.Frame()
            frame.configuration.box = [640, 640, 640, 0, 0, 0]
            frame.particles.N, frame.particles.types, frame.particles.typeid = 4, ["A", "B"], [0, 1, 0, 1]
            frame.particles.position, frame.particles.orientation = places + [0, shift, 0], turned
            file.append(frame)
    settings = {"salt": "100mM", "equilibration": 0, "seed": 5, "energy": "direct"}
    lengths = {"sweeps": 4, "trajectory_every": 4, "log_every": 4}
    for number, shift in [(0, 0.0), (None, 25.0)]:
        chosen = {} if number is None else {"frame": number}
        run = pm.simulate(ring, state=path, **chosen, **lengths, **settings, output=tmp_path / f"from_{number}")
        bodies = pm.AssemblySimulation(ring, positions=places + [0, shift, 0], orientations=turned, **settings)
        bodies.run(4)
        last = run.trajectory()[-1]
        np.testing.assert_allclose(last.positions_angstrom, bodies.positions, atol=1e-3)
        np.testing.assert_allclose(np.abs((last.orientations_wxyz * bodies.orientations).sum(axis=1)), 1, atol=1e-6)
    longer = pm.simulate(ring, state=path, frame=0, **{**lengths, "sweeps": 8}, **settings, output=tmp_path / "from_0")
    assert longer.log["sweep"][-1] == 8

    with pytest.raises(pm.ProtomerError, match="frame"):
        pm.simulate(ring, state=path, frame=2, **lengths, **settings, output=tmp_path / "beyond")
    with pytest.raises(pm.ProtomerError, match="add --state"):
        pm.simulate(ring, frame=0, **lengths, **settings, output=tmp_path / "alone")
    with gsd.open(str(tmp_path / "other.gsd"), "w") as file:
        frame.particles.typeid = [1, 0, 0, 1]
        file.append(frame)
    with pytest.raises(pm.ProtomerError, match="other.gsd"):
        pm.simulate(ring, state=tmp_path / "other.gsd", **lengths, **settings, output=tmp_path / "other")


def test_the_page_about_own_loops_runs(tmp_path, monkeypatch, capsys):
    pytest.importorskip("gsd.hoomd")
    text = (ROOT / "docs/tutorial/own-loop.md").read_text()
    blocks = re.findall(r"^```(python|text)\n(.*?)^```", text, re.MULTILINE | re.DOTALL)
    # The page speaks from the root of the project.
    (tmp_path / "data").symlink_to(ROOT / "data")
    monkeypatch.chdir(tmp_path)
    names = {}
    for kind, block in blocks:
        if kind == "python":
            capsys.readouterr()
            exec(compile(block, "own-loop.md", "exec"), names)
        else:
            assert capsys.readouterr().out == block


def test_a_lattice_in_memory_gives_the_states_of_the_verb(tmp_path):
    hoomd = pytest.importorskip("gsd.hoomd")
    fl = pytest.importorskip("gsd.fl")
    settings = {"rows": 4, "columns": 4, "r0": 0.5}
    pm.lattice.run(ns=4, r0=0.5, steps=200, trajectory_every=100, output=tmp_path / "run")
    lattice = pm.LatticeSimulation(**settings)
    angles = lattice.angles
    lattice.run(200)
    assert lattice.step == 200
    assert angles is not lattice.angles and np.shares_memory(angles, lattice.angles), "filled again, not copied"
    with fl.open(str(tmp_path / "run" / "trajectory.gsd"), "r") as file:
        last = file.read_chunk(frame=file.nframes - 1, name="log/positions")
    assert np.array_equal(np.column_stack([lattice.positions, lattice.angles]), last)

    lattice.write_to(tmp_path / "own")
    row = lattice.log()
    lattice.frame()
    assert row["step"] == 200 and row["rod_violation"] < 1e-9
    # Its file starts a run of the verb, which adds the velocities of its settings.
    found = pm.lattice.run(
        ns=4, r0=0.5, state=tmp_path / "own" / "trajectory.gsd", velocities="rest", steps=10, output=tmp_path / "next"
    )
    assert found.energy == pytest.approx(0.0, abs=1e-12)
    # Another program's file has single precision and no log.
    with hoomd.open(str(tmp_path / "own" / "trajectory.gsd"), "r") as file:
        frame = file[0]
    bare = hoomd.Frame()
    bare.particles.N = 16
    bare.particles.types = ["square"]
    bare.particles.typeid = np.zeros(16)
    bare.particles.position = frame.particles.position[:16]
    bare.particles.orientation = frame.particles.orientation[:16]
    bare.configuration.box = frame.configuration.box
    with hoomd.open(str(tmp_path / "bare.gsd"), "w") as file:
        file.append(bare)
    started = pm.LatticeSimulation(**settings, state=tmp_path / "bare.gsd")
    assert np.allclose(started.positions, lattice.positions, atol=1e-5)

    with pytest.raises(pm.ProtomerError, match="off their rods"):
        pm.LatticeSimulation(rows=4, columns=4, r0=0.7, state=tmp_path / "bare.gsd")
    with pytest.raises(pm.ProtomerError, match="there are no angles"):
        pm.LatticeSimulation(**settings, positions=lattice.positions)
    with pytest.raises(pm.ProtomerError, match="--rows and --columns"):
        pm.LatticeSimulation(**settings, positions=[[0, 0]], angles=[0])
