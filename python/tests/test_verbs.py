"""Verbs as functions: the same results as the command, errors as exceptions, progress, Ctrl-C."""

import inspect
import json
import os
import pickle
import signal
import subprocess
import sys
import threading
import time
import tomllib
from pathlib import Path

import numpy as np
import pytest

import protomer as pm
from protomer import _protomer
from conftest import BPTI

SHORT = {"salt": ["30mM", "300mM"], "replicas": 2, "sweeps": 20, "equilibration": 10, "seed": 7}


def command(*words):
    """The command line of the same package."""
    run = subprocess.run([sys.executable, "-m", "protomer", *map(str, words)], capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    return run.stdout


def test_every_verb_is_a_function_with_keywords_and_a_description():
    for name in pm._verb_names:
        verb = getattr(pm, name)
        assert callable(verb) or any(callable(getattr(verb, method)) for method in dir(verb))
        assert (verb.__doc__ or type(verb).__doc__).strip()
    kinds = {parameter.kind for name, parameter in inspect.signature(pm.sweep).parameters.items() if name != "assembly"}
    assert kinds == {inspect.Parameter.KEYWORD_ONLY}


def test_a_sweep_is_that_of_the_command_line_byte_for_byte(ring, tmp_path):
    heard = []
    result = pm.sweep(ring, **SHORT, output=tmp_path / "python", progress=lambda *news: heard.append(news))
    words = ["--salt=30mM,300mM", "--replicas=2", "--sweeps=20", "--equilibration=10", "--seed=7"]
    printed = json.loads(command("sweep", ring, *words, "-o", tmp_path / "shell", "--json"))
    assert result.to_dict() == printed
    for file in ["sweep.csv", "sweep.json", "salt_0.030000M/replica_1/log.csv", "salt_0.300000M/replica_0/trajectory.gsd"]:
        assert (tmp_path / "python" / file).read_bytes() == (tmp_path / "shell" / file).read_bytes(), file
    np.testing.assert_allclose(result.salt_molar, [0.03, 0.3])
    assert result.r_g_angstrom.shape == (2,) and np.all(result.r_g_angstrom > 0)
    # Every average is that of its column in the logs.
    for name, column in [
        ("r_g_angstrom", "r_g_angstrom"),
        ("contacts", "contacts"),
        ("bound_fraction", "bound_fraction"),
        ("largest_cluster", "largest_cluster"),
        ("energy_kt", "energy_kT"),
    ]:
        logs = [[result.log(salt_molar=salt, replica=replica)[column].mean() for replica in (0, 1)] for salt in (0.03, 0.3)]
        np.testing.assert_allclose(getattr(result, name), np.mean(logs, axis=1), rtol=1e-12, err_msg=name)
    done, total, unit = heard[-1]
    assert 0 < done <= total and unit == "sweeps"
    both = pm.compare([tmp_path / "python", tmp_path / "shell"], output=tmp_path / "both.svg")
    assert [curve.name for curve in both.sweeps] == ["python", "shell"]
    np.testing.assert_array_equal(both.sweeps[1].r_g_sd_angstrom, result.r_g_sd_angstrom)


def test_lists_reach_the_program():
    with pytest.raises(pm.ConfigError, match="'speed' for '--part"):
        pm.bench(part=["charges", "speed"])
    with pytest.raises(pm.ProtomerError, match="chain Y"):
        pm.Body.from_structure(BPTI, chain=["A", "Y"])


def repeated_flags():
    """The flags that the program reads once per value, by verb, as its table of flags has them."""
    functions = [function for group in _protomer.verbs() for function in group["functions"]]
    return {
        (" ".join(function["verb"]), parameter["flag"])
        for function in functions
        for parameter in function["parameters"]
        if parameter["is_repeated"]
    }


def test_a_call_that_does_not_fit_is_a_type_error_with_the_name_of_the_function():
    with pytest.raises(TypeError, match=r"^sweep\(\): got an unexpected keyword argument 'sallt'$"):
        pm.sweep("ring.json", sallt="100mM", output="out")
    with pytest.raises(TypeError, match=r"^_Assemble.ring\(\): missing a required argument: 'bodies'$"):
        pm.assemble.ring(output="ring.json")
    with pytest.raises(TypeError, match=r"^sweep\(\): too many positional arguments$"):
        pm.sweep("ring.json", "out")


def test_functions_look_like_those_of_a_module():
    assert pm.sweep.__name__ == "sweep" and pm.sweep.__module__ == "protomer._verbs"
    assert pickle.loads(pickle.dumps(pm.sweep)) is pm.sweep
    signature = inspect.signature(pm.lattice.run)
    assert signature.parameters["output"].default is inspect.Parameter.empty
    assert signature.parameters["no_collisions"].default is False
    assert signature.return_annotation == "LatticeResult"
    assert "rod" in inspect.getdoc(pm.lattice.run)


def test_both_values_of_every_repeated_flag_reach_the_program(tmp_path):
    called = set()

    def calls(verb, *flags):
        called.update((verb, flag) for flag in flags)

    # Free energies of two phases, parabolas about 0.2 and 0.7: a line touches both.
    density = np.linspace(0.0, 1.0, 101)
    tables = []
    for name, least, curvature in [("fluid", 0.2, 2.0), ("solid", 0.7, 3.0)]:
        tables.append(tmp_path / f"{name}.txt")
        np.savetxt(tables[-1], np.column_stack([density, curvature * (density - least) ** 2]))
    found = pm.phase_diagram(branch=tables)
    assert found.to_dict()["coexistences"][0]["phases"] == ["fluid", "solid"]
    calls("phase-diagram", "--branch")

    two, one = [tmp_path / "first", tmp_path / "second"], [tmp_path / "only"]
    with pytest.raises(pm.ProtomerError, match="2 crystals and 1 free energies"):
        pm.phase_diagram(fluid=tmp_path, crystal=two, free_energy=one)
    with pytest.raises(pm.ProtomerError, match="1 crystals and 2 free energies"):
        pm.phase_diagram(fluid=tmp_path, crystal=one, free_energy=two)
    calls("phase-diagram", "--crystal", "--free-energy")

    with pytest.raises(pm.ConfigError, match="'speed' for '--part"):
        pm.bench(part=["charges", "speed"])
    calls("bench", "--part")

    run = pm.md.run(
        shape=["polygon:4", "polygon:5"],
        share=[3, 1],
        bodies=16,
        packing_fraction=0.3,
        steps=10,
        compress_steps=10,
        equilibrate_steps=10,
        output=tmp_path / "mixture",
    )
    assert run.bodies == 16
    settings = tomllib.loads((tmp_path / "mixture" / "run.toml").read_text())
    assert settings["shape"] == ["polygon:4", "polygon:5"] and settings["share"] == [3.0, 1.0]

    mixed = {"shape": ["cube", "octahedron"], "share": [3, 1], "bodies": 32, "equilibration": 5, "sweeps": 5, "trajectory_every": 0}
    pm.hpmc.run(packing_fraction=0.05, output=tmp_path / "mixed", **mixed)
    pm.hpmc.sweep(packing_fractions=[0.05], output=tmp_path / "mixed_sweep", **mixed)
    for folder, key in [("mixed", None), ("mixed_sweep", "run")]:
        settings = tomllib.loads((tmp_path / folder / "run.toml").read_text())
        settings = settings[key] if key else settings
        assert settings["shape"] == ["cube", "octahedron"] and settings["share"] == [3.0, 1.0]
    calls("hpmc run", "--shape", "--share")
    calls("hpmc sweep", "--shape", "--share")

    scan = pm.framework.honeycomb(theta=60, kh=50, ks=10000, scan=["theta=60,70", "h=1,2"])
    assert len(scan.to_dict()["items"]) == 4
    calls("framework honeycomb", "--scan")
    for name, builder in vars(type(pm.framework)).items():
        verb = f"framework {name.replace('_', '-')}"
        if (verb, "--scan") in repeated_flags() - called:
            # Any numbers: the second value is refused before a network is built.
            numbers = [key for key, parameter in inspect.signature(builder).parameters.items() if parameter.default is inspect.Parameter.empty]
            with pytest.raises(pm.ProtomerError, match="other"):
                getattr(pm.framework, name)(**{key: 0.5 for key in numbers if key != "self"}, scan=["other=1", "other=2"])
            calls(verb, "--scan")
    with pytest.raises(pm.ProtomerError, match="--scan changes the parameters of a builder"):
        pm.framework("network.toml", scan=["theta=1", "h=2"])
    calls("framework", "--scan")
    calls("md run", "--shape", "--share")

    dimer = Path(__file__).parents[2] / "data/structures/4e43.pdb.gz"
    scored = pm.score(dimer, body=["A", "B"], columns="charge", output=tmp_path / "scores")
    assert (scored.rows, scored.failed) == (1, 0)
    calls("score", "--body")
    for body in (["A", "X"], ["X", "B"]):
        with pytest.raises(pm.ProtomerError, match="no chain X"):
            pm.assemble.structure(dimer, body=body, output=tmp_path / "dimer")
        with pytest.raises(pm.ProtomerError, match="no chain X"):
            pm.binding(dimer, body=body, salt="50mM")
        with pytest.raises(pm.ProtomerError, match="no chain X"):
            pm.stability(dimer, body=body)
    for verb in ("assemble structure", "binding", "stability"):
        calls(verb, "--body")

    # A new repeated flag needs a call here.
    assert called == repeated_flags()


def test_results_show_their_fields():
    result = pm.framework.honeycomb(theta=60, kh=50, ks=10000)
    assert dir(result) and "<table>" in result._repr_html_()
    with pytest.raises(AttributeError, match="it has"):
        result.nothing


def test_a_sweep_labels_its_salts_readably():
    matplotlib = pytest.importorskip("matplotlib", reason="matplotlib is not installed")
    matplotlib.use("Agg")
    rows = [{"salt_M": salt, "r_g_mean_angstrom": 20.0, "r_g_sd_angstrom": 1.0} for salt in [0.03, 0.3]]
    axes = pm.SweepResult({"salts": rows}).plot()
    axes.figure.canvas.draw()
    low, high = axes.get_xlim()
    labels = [label.get_text() for label in axes.get_xticklabels(which="both") if low <= label.get_position()[0] <= high]
    assert [label for label in labels if label] == ["50", "100", "200"]
    rows = [row | {"bound_fraction_mean": bound, "bound_fraction_sd": 0.1} for row, bound in zip(rows, [0.9, 0.2])]
    axes = pm.SweepResult({"salts": rows}).plot(quantity="bound_fraction")
    assert axes.get_ylabel() == "bodies that touch another"
    np.testing.assert_allclose(axes.lines[0].get_ydata(), [0.9, 0.2])
    # A sweep of an earlier version has no contacts.
    assert np.isnan(pm.SweepResult({"salts": rows}).contacts).all()


def test_errors_are_exceptions_of_their_kind(ring, tmp_path):
    broken = tmp_path / "broken.pdb"
    broken.write_text("ATOM      1  N   ALA A   1      11.104   x.134  -6.504  1.00  0.00           N\n")
    with pytest.raises(pm.ParseError) as caught:
        pm.surface(broken, output=tmp_path / "surface.ply")
    assert caught.value.line == 1 and caught.value.path.endswith("broken.pdb")
    with pytest.raises(pm.ConfigError, match="--replicas"):
        pm.sweep(ring, **{**SHORT, "replicas": "many"}, output=tmp_path / "sweep")
    with pytest.raises(pm.ConfigError, match="temperature"):
        pm.inspect(ring, salt="100mM", temperature=500)
    with pytest.raises(pm.ConfigError, match="box"):
        pm.simulate(ring, salt="100mM", cutoff="400A", output=tmp_path / "wide")
    with pytest.raises(pm.ConvergenceError, match="too large"):
        pm.lattice.run(ns=4, r0=0.01, velocities="random", speed=50, dt=0.5, time=5, output=tmp_path / "lattice")
    pm.framework.rotating_squares(side=2, angle=25, ks=1000, kh=0, write=tmp_path / "squares.toml")
    with pytest.raises(pm.ConvergenceError, match="no minimum"):
        pm.framework(tmp_path / "squares.toml", load="y", stress="1GPa")
    few = {"bodies": 4, "packing_fraction": 0.5}
    with pytest.raises(pm.ConfigError, match="more bodies"):
        pm.md.run(shape="polygon:4", **few, steps=10, output=tmp_path / "md")
    with pytest.raises(pm.ConfigError, match="at least"):
        pm.hpmc.run(shape="cube", bodies=2, packing_fraction=0.5, sweeps=10, output=tmp_path / "hpmc")
    with pytest.raises(pm.GeometryError, match="overlap in this crystal"):
        pm.hpmc.run(shape="cube", start="fcc", bodies=108, packing_fraction=0.9, sweeps=5, output=tmp_path / "dense")
    with pytest.raises(pm.GeometryError, match="smaller time step"):
        fast = {"bodies": 64, "packing_fraction": 0.6, "time_step": 1, "steps": 50}
        pm.md.run(shape="polygon:4", **fast, output=tmp_path / "fast")
    with pytest.raises(pm.ProtomerError, match="nowhere.json"):
        pm.inspect("nowhere.json", salt="0.1M")
    assert issubclass(pm.ParseError, ValueError)


def test_salts_are_found_by_the_digits_that_tables_show(tmp_path):
    fields = {"settings": {"salt_M": [0.03, 0.094868, 0.3], "replicas": 1}}
    sweep = pm.SweepResult(fields, tmp_path)
    for asked in (0.094868, 0.09487, 0.0949, 0.095):
        assert sweep._folder(asked, 0) == tmp_path / "salt_0.094868M" / "replica_0"
    for asked in (0.0948, 0.09, 0.1):
        with pytest.raises(KeyError, match="0.094868"):
            sweep._folder(asked, 0)


def test_lists_of_objects_become_tables_of_pandas():
    pytest.importorskip("pandas", reason="pandas is not installed")
    row = {"body": "plus", "number": 15, "energy_kt": {"mean": -1.5, "error": 0.1}}
    pair = {"first": {"body": "plus", "number": 15}, "contacts": 2.0}
    result = pm.Result({"bodies": 2, "files": ["a.csv"], "residues": [row, row], "pairs": [pair]})
    table = result.to_dataframe()
    assert list(table.columns) == ["body", "number", "energy_kt", "energy_kt_error"] and len(table) == 2
    assert list(result.to_dataframe("pairs").columns) == ["first_body", "first_number", "contacts"]
    with pytest.raises(KeyError, match="residues, pairs"):
        result.to_dataframe("files")


def test_virial_coefficients_are_those_of_the_closed_forms():
    cube = pm.shape.virial("cube", triples=200, depletants="0.1:5", rays=20)
    assert cube.b2 == pytest.approx(5.5) and cube.b3_error > 0 and cube.osmotic_b2 < 5.5
    mixed = pm.shape.virial("cube", "tetrahedron")
    assert mixed.b2_alone[0] == pytest.approx(5.5) and mixed.b2_error == 0


def test_salts_need_a_unit_and_much_salt_is_warned_of(ring):
    with pytest.raises(pm.ConfigError, match=r"give salt_molar=0.1 in mol/L, or salt='100mM'"):
        pm.inspect(ring, salt=100)
    with pytest.raises(pm.ConfigError, match=r"a number without a unit \(0.1\); give salt_molar=0.1 in mol/L"):
        pm.inspect(ring, salt=0.1)
    with pytest.raises(pm.ConfigError, match=r"salt_molar=\[0.1, 0.3\] in mol/L, or salt=\['100mM', '300mM'\]"):
        pm.sweep(ring, salt=np.array([0.1, 0.3]), output="unused")
    with pytest.raises(pm.ConfigError, match=r"100 what\? write 100mM"):
        pm.inspect(ring, salt="100")
    with pytest.warns(UserWarning, match="^2 M of salt"):
        concentrated = pm.inspect(ring, salt="2M")
    assert abs(concentrated.energy_kT) < abs(pm.inspect(ring, salt="100mM").energy_kT)
    assert pm.inspect(ring).energy_kT is None


def test_stopped_work_goes_on(ring, tmp_path):
    with pytest.raises(pm.StoppedError, match="continues it"):
        pm.sweep(ring, **SHORT, output=tmp_path / "sweep", time_limit=0)
    whole = pm.sweep(ring, **SHORT, output=tmp_path / "whole")
    assert pm.sweep(ring, **SHORT, output=tmp_path / "sweep").salts[0].to_dict() == whole.salts[0].to_dict()


@pytest.fixture
def python_hears_ctrl_c():
    """A shell starts its background jobs with Ctrl-C ignored, and this test may run in one."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def test_ctrl_c_stops_resumably_and_raises(ring, tmp_path, python_hears_ctrl_c):
    long = {**SHORT, "sweeps": 10_000_000}
    log = tmp_path / "sweep" / "salt_0.030000M" / "replica_0" / "log.csv"

    def interrupt():
        # From the first record on there is something to go on from.
        while not (log.exists() and log.read_text().count("\n") > 1):
            time.sleep(0.05)
        os.kill(os.getpid(), signal.SIGINT)

    threading.Thread(target=interrupt, daemon=True).start()
    with pytest.raises(KeyboardInterrupt):
        pm.sweep(ring, **long, output=tmp_path / "sweep")
    record = json.loads((tmp_path / "sweep" / "salt_0.030000M" / "replica_0" / "run.json").read_text())
    assert record["exit_reason"] == "stopped" and record["done"] < long["sweeps"]
    assert (tmp_path / "sweep" / "salt_0.030000M" / "replica_0" / "checkpoint.bin").exists()


def test_the_interpreter_is_free_while_a_verb_works(ring, tmp_path):
    counted = []
    stop = threading.Event()

    def count():
        while not stop.is_set():
            counted.append(1)
            time.sleep(0.005)

    thread = threading.Thread(target=count)
    thread.start()
    with pytest.raises(pm.StoppedError):
        pm.sweep(ring, **{**SHORT, "sweeps": 10_000_000}, time_limit=0.01, output=tmp_path / "sweep")
    stop.set()
    thread.join()
    # Holding the interpreter, the verb would let the thread count before it and after it only.
    assert len(counted) > 10


def test_the_binding_of_two_charges_is_that_of_the_command_line(tmp_path):
    files = []
    for name, line in [
        ("lysine", "ATOM 1 NZ LYS A 1 0.0 0.0 0.0 1.0 2.0"),
        ("aspartate", "ATOM 1 OD1 ASP B 1 3.8 0.0 0.0 -1.0 2.0"),
    ]:
        files.append(tmp_path / f"{name}.pqr")
        files[-1].write_text(line + "\n")
    found = pm.binding(*files, salt_molar=[0.05, 0.5])
    printed = json.loads(command("binding", *files, "--salt=50mM,500mM", "--json"))
    assert found.to_dict() == printed
    low, high = found["conditions"]
    terms = low["terms_kt"]
    # Atoms of a PQR file have no native core, so the terms of natural-1 are not the model.
    assert set(terms) == {"charges", "contacts", "solvent_response"} and found["model"] == "own terms"
    assert low["salt_effect_kt"] == 0 and low["energy_kt"] == pytest.approx(sum(terms[name] for name in terms))
    assert 0 < low["log10_kd_error"] < 0.3
    own = pm.binding(*files, salt="50mM", model="thesis", no_kd=True)
    assert own["model"] == "thesis" and own["conditions"][0]["log10_kd_molar"] is None
    # Salt weakens the attraction of opposite charges.
    assert high["poisson_boltzmann_kt"] > low["poisson_boltzmann_kt"] and found["d_ln_k_d_ln_salt"] < 0
    with pytest.raises(pm.ConfigError, match="binding needs a salt concentration"):
        pm.binding(*files)
    with pytest.raises(pm.ProtomerError, match="--body"):
        pm.binding(*files, body=["A", "B"], salt="50mM")
