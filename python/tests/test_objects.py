"""Assemblies, bodies and trajectories as objects, errors that say which names exist."""

import gzip
import pickle
import shutil

import numpy as np
import pytest

import protomer as pm
from conftest import BPTI

SHORT = {"sweeps": 30, "equilibration": 5, "trajectory_every": 10, "seed": 3}


@pytest.fixture(scope="module")
def finished(ring, tmp_path_factory):
    """A sweep of two salts and two replicas."""
    output = tmp_path_factory.mktemp("finished") / "sweep"
    pm.sweep(ring, salt_molar=np.array([0.03, 0.3]), replicas=2, **SHORT, output=output)
    return output


def test_an_assembly_is_poses_as_arrays_and_comes_back_from_its_file(ring, bodies, tmp_path):
    assembly = pm.Assembly.read(ring)
    assert len(assembly) == 4 and assembly.names == ["plus", "minus"] * 2
    assert assembly.positions_angstrom.shape == (4, 3) and assembly.orientations_wxyz.shape == (4, 4)
    np.testing.assert_allclose(np.linalg.norm(assembly.orientations_wxyz, axis=1), 1.0)
    np.testing.assert_array_equal(assembly.box_angstrom, [640.0] * 3)
    assert assembly.bodies["plus"].path == (bodies / "plus.body").absolute()
    # Rotations turn as the program does: half turns have no sign to mistake, quarter turns have.
    turned = assembly.with_poses(np.zeros((4, 3)), np.tile([np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)], (4, 1)))
    np.testing.assert_allclose(turned.rotations[0] @ [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], atol=1e-15)
    assembly.write(tmp_path / "again.json")
    again = pm.Assembly.read(tmp_path / "again.json")
    np.testing.assert_array_equal(again.positions_angstrom, assembly.positions_angstrom)
    np.testing.assert_array_equal(again.orientations_wxyz, assembly.orientations_wxyz)
    assembly.write(tmp_path / "again.json")
    assembly.positions_angstrom[0, 2] += 1.0
    with pytest.raises(FileExistsError, match="force=True"):
        assembly.write(tmp_path / "again.json")
    assembly.write(tmp_path / "again.json", force=True)
    assert pm.Assembly.read(tmp_path / "again.json").positions_angstrom[0, 2] == assembly.positions_angstrom[0, 2]


def test_names_and_shapes_that_do_not_fit_are_refused(ring):
    kinds = pm.Assembly.read(ring).bodies
    with pytest.raises(KeyError, match="no body 'plsu'; there are plus, minus"):
        pm.Assembly(kinds, ["plsu"], positions_angstrom=[[0, 0, 0]])
    with pytest.raises(KeyError, match="plus, minus"):
        kinds["other"]
    for wrong in ([0.0, 0.0, 0.0], [[0.0, 0.0]], [[0.0, 0.0, np.nan]]):
        with pytest.raises(pm.ConfigError, match="positions_angstrom"):
            pm.Assembly(kinds, ["plus"], positions_angstrom=wrong)
    with pytest.raises(pm.ConfigError, match="length zero"):
        pm.Assembly(kinds, ["plus"], positions_angstrom=[[0, 0, 0]], orientations_wxyz=[[0, 0, 0, 0]])
    with pytest.raises(pm.ConfigError, match="1 names, 2 positions"):
        pm.Assembly(kinds, ["plus"], positions_angstrom=np.zeros((2, 3)))


def test_assemblies_are_taken_where_files_are(ring, tmp_path, monkeypatch):
    assembly = pm.Assembly.read(ring)
    of_file = pm.inspect(ring, salt="100mM")
    assert pm.inspect(assembly, salt_molar=0.1).energy_kT == of_file.energy_kT
    # Moved in place: the energy is another one, and the file of before is not touched.
    before = ring.read_bytes()
    assembly.positions_angstrom[:] *= 1.5
    assert abs(pm.inspect(assembly, salt_molar=0.1).energy_kT) < 0.9 * abs(of_file.energy_kT)
    assert ring.read_bytes() == before
    monkeypatch.chdir(tmp_path)
    run = pm.simulate(assembly, salt="100mM", **SHORT, output="run")
    assert (tmp_path / "run" / "input" / "assembly.json").exists()
    # The same call continues it, others find the bodies, and a result is read without the call.
    longer = pm.simulate(assembly, salt="100mM", **{**SHORT, "sweeps": 60}, output="run")
    assert len(longer.trajectory()) == 6
    assert pm.export("run", output="end.pdb").copies == 4
    np.testing.assert_allclose(run.assembly().positions_angstrom, assembly.positions_angstrom)
    assembly.positions_angstrom[:] += 1.0
    with pytest.raises(pm.ProtomerError, match="choose another output"):
        pm.simulate(assembly, salt="100mM", **SHORT, output="run")


def test_bodies_are_taken_where_files_are(bodies, tmp_path):
    plus, minus = (pm.Body.read(bodies / f"{name}.body") for name in ("plus", "minus"))
    made = pm.Body.from_arrays(
        vertices_angstrom=plus.vertices_angstrom,
        triangles=plus.triangles,
        charge_positions_angstrom=plus.charge_positions_angstrom,
        charges_e=plus.charges_e,
        name="made",
    )
    assert made.path is None
    pm.assemble.ring([made, minus], members=4, box=640.0, output=tmp_path / "ring.json")
    assembly = pm.Assembly.read(tmp_path / "ring.json")
    assert assembly.bodies["made"].path == tmp_path / "ring_input" / "made.body"
    assert assembly.bodies["minus"].path.samefile(bodies / "minus.body")
    own = pm.Assembly([made, minus], ["made", "minus"], positions_angstrom=[[0, 0, 0], [60, 0, 0]], box_angstrom=640)
    direct = [pm.Assembly([plus, minus], positions_angstrom=own.positions_angstrom, box_angstrom=640), own]
    energies = [pm.inspect(assembly, salt="50mM").energy_kT for assembly in direct]
    assert energies[0] < -0.01 and energies[1] == pytest.approx(energies[0], rel=1e-9)


def test_bodies_get_files_of_their_own_whatever_their_names_are(bodies, tmp_path):
    plus, minus = (pm.Body.read(bodies / f"{name}.body") for name in ("plus", "minus"))
    long = "ä" * 300
    names = ["../../x", "a/b", "a:b", "a_b_2", "A", "a", "-o", ".hidden", "=1+1", "it's \"A\"", "/"]
    names += [long + "1", long + "2"]
    kinds = {}
    for number, name in enumerate(names):
        # Different charges, so that each file has its own content.
        kinds[name] = pm.Body.from_arrays(
            vertices_angstrom=plus.vertices_angstrom,
            triangles=plus.triangles,
            charge_positions_angstrom=minus.charge_positions_angstrom,
            charges_e=minus.charges_e * (1 + 0.01 * number),
            name=name,
        )
    positions = [[60.0 * number, 0.0, 0.0] for number in range(len(names))]
    pm.Assembly(kinds, names, positions_angstrom=positions).write(tmp_path / "all.json")
    files = list((tmp_path / "all_input").iterdir())
    assert len({file.name.lower() for file in files}) == len(names)
    assert not [file.name for file in files if file.name.startswith((".", "-")) or len(file.name.encode()) > 230]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["all.json", "all_input"]
    again = pm.Assembly.read(tmp_path / "all.json")
    assert again.names == names
    for name, body in kinds.items():
        np.testing.assert_array_equal(again.bodies[name].charges_e, body.charges_e)


def test_results_are_read_back_and_name_their_trajectories(finished, ring):
    sweep = pm.SweepResult.read(finished)
    np.testing.assert_array_equal(sweep.salt_molar, [0.03, 0.3])
    folders = [path.parent.relative_to(finished).as_posix() for path in sweep.trajectories]
    assert folders == [f"salt_{salt}M/replica_{replica}" for salt in ("0.030000", "0.300000") for replica in (0, 1)]
    trajectory = sweep.trajectory(salt_molar=0.3, replica=1)
    assert trajectory.path == sweep.trajectories[3] and trajectory.names == ["plus", "minus"] * 2
    assert len(trajectory) == 3 and trajectory.sweeps.tolist() == [10, 20, 30]
    assert trajectory.positions_angstrom.shape == (3, 4, 3) and trajectory.orientations_wxyz.shape == (3, 4, 4)
    last = trajectory[-1]
    np.testing.assert_array_equal(last.positions_angstrom, trajectory.positions_angstrom[2])
    np.testing.assert_allclose(last.box_angstrom, 640.0)
    assert [frame.sweep for frame in trajectory[1:]] == [20, 30]
    with pytest.raises(IndexError, match="only 3"):
        trajectory[3]
    # The log has the radius of gyration of each frame, here from the poses.
    log = sweep.log(salt_molar=0.3, replica=1)
    away = last.positions_angstrom[:, None] - last.positions_angstrom
    away -= 640.0 * np.round(away / 640.0)
    r_g = np.sqrt((away**2).sum() / 2) / 4
    assert log["r_g_angstrom"][log["sweep"] == 30][0] == pytest.approx(r_g, rel=1e-5)
    # A frame as an assembly: the energy in the log is that of the charges at these poses.
    assembly = sweep.assembly(-1, salt_molar=0.3, replica=1)
    energy = pm.inspect(assembly, salt_molar=0.3).energy_kT
    assert energy == pytest.approx(log["energy_kT"][log["sweep"] == 30][0], abs=1e-3)
    assert not np.allclose(assembly.positions_angstrom, pm.Assembly.read(ring).positions_angstrom)


def test_trajectories_agree_with_those_of_the_package_gsd(finished):
    gsd = pytest.importorskip("gsd.hoomd", reason="gsd is not installed")
    for path in pm.SweepResult.read(finished).trajectories:
        trajectory = pm.Trajectory(path)
        with gsd.open(str(path)) as frames:
            for ours, theirs in zip(trajectory, frames, strict=True):
                np.testing.assert_allclose(ours.positions_angstrom, theirs.particles.position, atol=1e-6)
                np.testing.assert_allclose(ours.orientations_wxyz, theirs.particles.orientation, atol=1e-6)


def test_unknown_names_say_which_exist(finished):
    sweep = pm.SweepResult.read(finished)
    with pytest.raises(KeyError, match="salt concentration .* 0.2; there are 0.03, 0.3"):
        sweep.trajectory(salt_molar=0.2)
    with pytest.raises(KeyError, match="there are 0.03, 0.3"):
        sweep.trajectory()
    with pytest.raises(KeyError, match="no replica 2; there are 0, 1"):
        sweep.trajectory(salt_molar=0.3, replica=2)
    with pytest.raises(KeyError, match="no field 'nothing'; there are equilibrium, version"):
        sweep["nothing"]
    with pytest.raises(KeyError, match="no column of log.csv 'r_g'; there are sweep, r_g_angstrom"):
        sweep.log(salt_molar=0.3)["r_g"]
    with pytest.raises(KeyError, match="no quantity 'speed'; there are r_g"):
        sweep.plot(quantity="speed")
    # They go to other processes, as Dask needs it.
    log = pickle.loads(pickle.dumps(sweep.log(salt_molar=0.3)))
    with pytest.raises(KeyError, match="there are sweep"):
        log["r_g"]


def test_missing_files_are_file_not_found_errors(tmp_path, finished, bodies):
    nowhere = tmp_path / "nowhere"
    calls = [
        lambda: pm.inspect(nowhere),
        lambda: pm.sweep(nowhere, salt="0.1M", output=tmp_path / "x"),
        lambda: pm.pair(nowhere, salt="0.1M"),
        lambda: pm.ingest(nowhere, output=tmp_path / "x"),
        lambda: pm.export(nowhere, output=tmp_path / "x.pdb"),
        lambda: pm.surface(nowhere),
        lambda: pm.Body.read(nowhere),
        lambda: pm.Body.from_structure(nowhere),
        lambda: pm.Assembly.read(nowhere),
        lambda: pm.Trajectory(nowhere),
        lambda: pm.SweepResult.read(nowhere),
        lambda: pm.SimulationResult.read(tmp_path),
        lambda: pm.PairResult.read(nowhere),
        lambda: pm.read_log(nowhere),
    ]
    for call in calls:
        with pytest.raises(FileNotFoundError) as caught:
            call()
        assert isinstance(caught.value, pm.ProtomerError)
        assert str(tmp_path) in str(caught.value)
    shutil.copytree(finished, tmp_path / "lost")
    (tmp_path / "lost" / "salt_0.030000M" / "replica_0" / "trajectory.gsd").unlink()
    lost = pm.SweepResult.read(tmp_path / "lost")
    assert len(lost.trajectories) == 3
    with pytest.raises(FileNotFoundError, match="trajectory_every"):
        lost.trajectory(salt_molar=0.03)
    with pytest.raises(pm.ProtomerError, match="holds a sweep, which is no PairResult"):
        pm.PairResult.read(finished)
    with pytest.raises(ValueError, match="4 simulations"):
        pm.SimulationResult.read(finished)


def test_a_result_that_was_read_is_the_one_that_was_returned(ring, pebbles, tmp_path):
    run = pm.simulate(ring, salt="100mM", **SHORT, output=tmp_path / "run")
    assert pm.SimulationResult.read(tmp_path / "run") == run
    np.testing.assert_array_equal(pm.SimulationResult.read(tmp_path / "run").log["sweep"], run.log["sweep"])
    settings = {"relative_error": 0.5, "most_directions": 1024, "output": tmp_path / "pair"}
    pair = pm.pair(pm.Body.read(pebbles[0]), pebbles[1], salt_molar=[0.05, 0.1], **settings)
    assert pm.PairResult.read(tmp_path / "pair") == pair
    assert pair.pose_files and all(path.exists() for path in pair.pose_files)
    bodies = [pm.Body.read(path) for path in pebbles]
    touching = pm.Assembly(bodies, positions_angstrom=[[0, 0, 0], [0, 0, 13]])
    settings = {"model": "thesis", "live_states": 24, "runs": 2, "output": tmp_path / "yields"}
    found = pm.stability(touching, salt_molar=[0.05, 0.1], concentration="1mM,10mM", **settings)
    assert pm.StabilityResult.read(tmp_path / "yields") == found
    assert found.yields.shape == (2, 2) and np.all(np.diff(found.yields, axis=1) > 0)
    assert found.free_energies_kt.shape == (2, 3) and found.plot().get_ylabel() == "bodies in whole assemblies"
    positions, turns, energies = pair.poses(salt_molar=0.05)
    assert positions.shape == (len(energies), 3) and turns.shape == (len(energies), 4)
    assert np.all(np.diff(energies) >= 0.0) and energies[0] < 0.0
    with pytest.raises(KeyError, match="there are 0.05, 0.1"):
        pair.poses(salt_molar=0.2)


def test_salts_are_arrays_in_mol_per_litre_or_text_with_units(ring):
    by_text = pm.inspect(ring, salt="0.15M").energy_kT
    for salt in (0.15, np.float64(0.15), np.array(0.15), np.array([0.15])):
        assert pm.inspect(ring, salt_molar=salt).energy_kT == by_text
    for bare in (0.15, np.float64(0.15), np.array([0.15])):
        with pytest.raises(pm.ConfigError, match="give salt_molar="):
            pm.inspect(ring, salt=bare)
    with pytest.raises(pm.ConfigError, match="give one of them"):
        pm.inspect(ring, salt="0.1M", salt_molar=0.1)
    with pytest.raises(pm.ConfigError, match="potential needs a salt concentration"):
        pm.potential(BPTI)
    with pytest.raises(pm.ConfigError, match="negative"):
        pm.inspect(ring, salt_molar=-0.1)
    with pytest.raises(pm.ConfigError, match="shape"):
        pm.inspect(ring, salt_molar=np.zeros((2, 2)))


def test_a_file_that_cannot_be_ingested_raises_and_the_others_are_made(tmp_path):
    broken = tmp_path / "broken.pdb"
    broken.write_text("ATOM      1  N   ALA A   1      11.104   x.134  -6.504  1.00  0.00           N\n")
    good = tmp_path / "good.cif"
    good.write_bytes(gzip.decompress(BPTI.read_bytes()))
    with pytest.raises(pm.PartialError, match="broken.pdb") as caught:
        pm.ingest([good, broken], output=tmp_path / "bodies")
    files = caught.value.result.files
    assert [bool(file["error"]) for file in files] == [False, True]
    assert pm.Body.read(tmp_path / "bodies" / "good.body").net_charge_e > 0.0
    with pytest.raises(pm.ProtomerError, match="broken.pdb"):
        pm.Body.from_structure(broken)


def test_docstrings_say_what_goes_in_and_comes_out():
    documented = [pm.ingest, pm.sweep, pm.pair, pm.export, pm.assemble.ring, pm.read_log]
    documented += [pm.Assembly.read, pm.Assembly.write, pm.Body.read, pm.Body.from_structure, pm.SweepResult.read]
    documented += [pm.SweepResult.trajectory, pm.SimulationResult.assembly, pm.PairResult.poses]
    for function in documented:
        for section in ("Parameters", "Returns", "Raises", "Examples"):
            assert f"{section}\n" in function.__doc__, (function, section)
    annotations = pm.sweep.__annotations__
    assert annotations["assembly"] == "Path | str | Assembly" and annotations["salt"] == "str | Sequence[str] | None"
