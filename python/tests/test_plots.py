"""The plots of results: data and labels."""

from pathlib import Path

import numpy as np
import pytest

import protomer as pm

matplotlib = pytest.importorskip("matplotlib", reason="matplotlib is not installed")
matplotlib.use("Agg")

BPTI = Path(__file__).resolve().parents[2] / "data" / "structures" / "5pti.cif.gz"


@pytest.fixture(autouse=True)
def closed_figures():
    yield
    import matplotlib.pyplot as plt

    plt.close("all")


def labels(axes):
    return axes.get_xlabel(), axes.get_ylabel()


def legend(axes):
    return [text.get_text() for text in axes.get_legend().get_texts()]


def error_bars(container):
    """Middle and half length of each."""
    ((bars,),) = [container[2]]
    ends = np.array([[low[1], high[1]] for low, high in bars.get_segments()])
    return ends.mean(axis=1), (ends[:, 1] - ends[:, 0]) / 2


def sweep_rows(salts):
    return [
        {
            "salt_M": salt,
            "r_g_mean_angstrom": 20.0 + n,
            "r_g_sd_angstrom": 1.0 + n,
            "r_g_se_angstrom": 0.1,
            "native_contacts_mean": 1.0 - 0.5 * n,
            "native_contacts_sd": 0.25,
            "largest_cluster_mean": 8.0 - n,
            "largest_cluster_sd": 0.5,
        }
        for n, salt in enumerate(salts)
    ]


def test_a_sweep_draws_each_quantity_with_its_spread():
    sweep = pm.SweepResult({"salts": sweep_rows([0.03, 0.3])})
    assert sweep.native_contacts_sd.tolist() == [0.25, 0.25] and sweep.largest_cluster.tolist() == [8.0, 7.0]
    # A result of an earlier version has no numbers for the columns that it lacks.
    assert sweep.r_g_angstrom.tolist() == [20.0, 21.0] and np.isnan(sweep.energy_sd_kt).all() and "contacts" in dir(sweep)
    with pytest.raises(AttributeError, match="has no 'colour'"):
        sweep.colour  # noqa: B018
    for quantity, label, values, deviations in [
        ("r_g", "radius of gyration (Å)", [20.0, 21.0], [1.0, 2.0]),
        ("native_contacts", "native contacts left", [1.0, 0.5], [0.25, 0.25]),
        ("largest_cluster", "bodies in the largest cluster", [8.0, 7.0], [0.5, 0.5]),
    ]:
        axes = sweep.plot(quantity=quantity)
        assert labels(axes) == ("salt (mM)", label) and axes.get_xscale() == "log"
        (container,) = axes.containers
        np.testing.assert_allclose(container[0].get_xydata(), np.column_stack([[30.0, 300.0], values]))
        np.testing.assert_allclose(error_bars(container), [values, deviations])
    # Zero cannot be shown on a logarithmic axis.
    assert pm.SweepResult({"salts": sweep_rows([0.0, 0.3])}).plot().get_xscale() == "linear"


def test_a_comparison_draws_a_line_for_each_sweep():
    columns = ["salt_M", "r_g_mean_angstrom", "r_g_sd_angstrom"]
    curve = {name: [row[name] for row in sweep_rows([0.03, 0.3])] for name in columns}
    axes = pm.CompareResult({"figure": "both.png", "sweeps": [{"name": "a", **curve}, {"name": "b", **curve}]}).plot()
    assert legend(axes) == ["a", "b"] and labels(axes) == ("salt (mM)", "radius of gyration (Å)")
    assert [container[0].get_ydata().tolist() for container in axes.containers] == [[20.0, 21.0]] * 2


def pair_rows(grid):
    return [
        {
            "ph": ph,
            "salt_M": salt,
            "b2_angstrom3": 1000.0 * b2,
            "b2_error_angstrom3": 500.0,
            "b22_mol_ml_per_g2": None if ph is None else 1e-4 * b2,
            "b22_error_mol_ml_per_g2": None if ph is None else 2e-5,
            "kd_molar": None,
            "mean_force": [
                {"distance_angstrom": 20.0 + at, "w_kt": b2 / (1.0 + at), "w_error_kt": error}
                for at, error in enumerate([None, 2.0, 0.1, 0.2])
            ],
        }
        for ph, salt, b2 in grid
    ]


GRID = [(7.0, 0.3, -1.0), (7.0, 0.03, 2.0), (4.5, 0.3, 3.0), (4.5, 0.03, 8.0)]


def test_a_pair_draws_a_line_for_each_ph():
    pair = pm.PairResult({"conditions": pair_rows(GRID)})
    axes = pair.plot()
    assert labels(axes) == ("salt (mM)", "B22 (10⁻⁴ mol mL/g²)") and legend(axes) == ["pH 4.5", "pH 7"]
    assert axes.get_xscale() == "log"
    for container, values in zip(axes.containers, [[8.0, 3.0], [2.0, -1.0]], strict=True):
        np.testing.assert_allclose(container[0].get_xydata(), np.column_stack([[30.0, 300.0], values]))
        np.testing.assert_allclose(error_bars(container), [values, [0.2, 0.2]])
    axes = pm.PairResult({"conditions": pair_rows([(None, 0.3, -1.0), (None, 0.1, 2.0)])}).plot()
    assert axes.get_ylabel() == "B2 (10³ Å³)" and legend(axes) == ["bodies as they are"]
    np.testing.assert_allclose(axes.containers[0][0].get_ydata(), [2.0, -1.0])


def test_a_pair_draws_a_map_that_is_symmetric_about_zero():
    pair = pm.PairResult({"conditions": pair_rows(GRID)})
    axes = pair.plot(kind="map")
    (mesh,) = axes.collections
    # Rows rise with the pH, columns with the salt.
    np.testing.assert_allclose(mesh.get_array().reshape(2, 2), [[8.0, 3.0], [2.0, -1.0]])
    assert mesh.get_clim() == (-8.0, 8.0) and labels(axes) == ("salt (mM)", "pH")
    red, _, blue, _ = mesh.cmap(0.0)
    assert red > blue, "attraction is red"
    assert mesh.cmap(1.0)[2] > mesh.cmap(1.0)[0]
    assert [text.get_text() for text in axes.get_xticklabels()] == ["30", "300"]
    assert [text.get_text() for text in axes.get_yticklabels()] == ["4.5", "7"]
    assert mesh.colorbar.ax.get_ylabel() == "B22 (10⁻⁴ mol mL/g²)"
    # A condition that is missing stays empty.
    axes = pm.PairResult({"conditions": pair_rows(GRID[:3])}).plot(kind="map")
    assert np.ma.getmaskarray(axes.collections[0].get_array()).reshape(2, 2).tolist() == [[True, False], [False, False]]
    for few in (GRID[:2], GRID[::2], [(None, 0.1, 1.0), (None, 0.3, 1.0)]):
        with pytest.raises(ValueError, match="at least two salts and two pH"):
            pm.PairResult({"conditions": pair_rows(few)}).plot(kind="map")


def test_a_pair_draws_its_potential_of_mean_force():
    pair = pm.PairResult({"conditions": pair_rows([(4.5, 0.03, 8.0), (4.5, None, 2.0)])})
    axes = pair.plot(quantity="distance")
    assert labels(axes) == ("distance of the origins (Å)", "w (kT)") and legend(axes) == ["pH 4.5, 30 mM", "pH 4.5"]
    # Without an error, and with a large one, w has no value.
    np.testing.assert_allclose(axes.lines[0].get_xydata(), [[22.0, 8.0 / 3.0], [23.0, 2.0]])
    with pytest.raises(ValueError, match="Debye length"):
        pair.plot()
    with pytest.raises(ValueError, match="no quantity 'heat'; there are salt, map, distance"):
        pair.plot(quantity="heat")


def test_a_simulation_and_its_log(ring, tmp_path):
    run = pm.simulate(ring, salt="100mM", sweeps=6, equilibration=2, log_every=2, output=tmp_path / "run")
    log = pm.read_log(tmp_path / "run")
    assert list(log)[:3] == ["sweep", "r_g_angstrom", "native_contacts"] and "energy_kT" in log
    assert log["sweep"].tolist() == [2, 4, 6] and log["sweep"].dtype == np.int64
    assert log["r_g_angstrom"].dtype == np.float64
    assert log["r_g_angstrom"].mean() == pytest.approx(run["r_g_angstrom"]["mean"])
    axes = run.plot()
    assert labels(axes) == ("sweep", "radius of gyration (Å)")
    np.testing.assert_array_equal(axes.lines[0].get_xydata().T, [log["sweep"], log["r_g_angstrom"]])
    assert axes.lines[1].get_ydata()[0] == run["r_g_angstrom"]["mean"]
    axes = run.plot(quantity="energy")
    assert labels(axes) == ("sweep", "energy (kT)")
    np.testing.assert_array_equal(axes.lines[0].get_ydata(), log["energy_kT"])
    with pytest.raises(KeyError, match="no quantity 'colour'; there are r_g, native_contacts"):
        run.plot(quantity="colour")


def test_tables_are_read_by_what_their_columns_hold(tmp_path):
    (tmp_path / "table.csv").write_text('name,count,energy_kT\n"a, b",1,\nc,2,nan\nd,3,-1.5e3\n')
    table = pm.read_log(tmp_path / "table.csv")
    assert table["name"].tolist() == ["a, b", "c", "d"] and table["count"].dtype == np.int64
    np.testing.assert_array_equal(table["energy_kT"], [np.nan, np.nan, -1500.0])
    (tmp_path / "cut.csv").write_text("a,b\n1,2\n3\n")
    with pytest.raises(ValueError, match="cut.csv:3 has 1 cells under 2 columns"):
        pm.read_log(tmp_path / "cut.csv")
    with pytest.raises(FileNotFoundError, match="give the directory of a simulation"):
        pm.read_log(tmp_path)
    for replica in (0, 1):
        (tmp_path / f"salt_0.1M/replica_{replica}").mkdir(parents=True)
        (tmp_path / f"salt_0.1M/replica_{replica}/log.csv").write_text("sweep\n1\n")
    with pytest.raises(ValueError, match="holds 2 logs.*replica_0"):
        pm.read_log(tmp_path)


def test_lattices(tmp_path):
    run = pm.lattice.run(ns=3, r0=0.136, time=1, output=tmp_path / "run")
    axes = run.plot(quantity="strain_xx")
    log = pm.read_log(tmp_path / "run")
    assert labels(axes) == ("time", "strain xx") and log["time"][-1] == pytest.approx(run.time)
    np.testing.assert_array_equal(axes.lines[0].get_xydata().T, [log["time"], log["strain_xx"]])
    with pytest.raises(KeyError, match="no column of the log 'colour'; there are step, time"):
        run.plot(quantity="colour")
    sweep = pm.lattice.sweep(ns=3, r0_list=[0.3, 0.136], kappa_list=[0, 1], seeds=2, time=1, output=tmp_path / "sweep")
    axes = sweep.plot(quantity="collision_rate")
    assert legend(axes) == ["κ = 0", "κ = 1"] and labels(axes) == ("length of the rods r₀", "collision rate")
    for container, kappa in zip(axes.containers, [0.0, 1.0]):
        own = sorted((row.r0, row.collision_rate.mean) for row in sweep.conditions if row.kappa == kappa)
        assert len(own) == 2
        np.testing.assert_array_equal(container[0].get_xydata(), own)
    with pytest.raises(KeyError, match="no estimate 'runs'"):
        sweep.plot(quantity="runs")


def test_a_framework_draws_its_moduli_around_the_plane():
    framework = pm.framework.honeycomb(theta=60, kh=50, ks=10000)
    axes = framework.plot()
    assert axes.name == "polar" and legend(axes) == ["E (GPa)"]
    angle, modulus = axes.lines[0].get_data()
    quarter = np.argmin(np.abs(angle - np.pi / 2))
    assert modulus[0] == pytest.approx(framework.e_y_gpa) and modulus[quarter] == pytest.approx(framework.e_z_gpa)
    assert angle[-1] == pytest.approx(2 * np.pi) and modulus[-1] == modulus[0]
    # Re-entrant: the ratio is negative along the axes, and drawn with dashes.
    axes = framework.plot(quantity="nu")
    positive, negative = axes.lines
    assert negative.get_linestyle() == "--" and legend(axes) == ["ν", "-ν"]
    assert np.isnan(positive.get_ydata()[0]) and negative.get_ydata()[0] == pytest.approx(-framework.nu_yz)
    with pytest.raises(ValueError, match="not polar"):
        framework.plot(ax=pm.VoxelizeResult({"samples": 1, "excluded": []}).plot())
    with pytest.raises(ValueError, match="three dimensions"):
        pm.FrameworkResult({"polar": []}).plot()


def test_potentials_at_points():
    potential = pm.PotentialResult({"potentials_kT_per_e": [1.0, None, -2.0, 0.5]})
    axes = potential.plot()
    assert labels(axes) == ("potential (kT/e)", "points") and sum(bar.get_height() for bar in axes.patches) == 3
    axes = potential.plot(kind="line")
    np.testing.assert_array_equal(axes.lines[0].get_xydata()[[0, 2, 3]], [[1, 1.0], [3, -2.0], [4, 0.5]])
    with pytest.raises(ValueError, match="points="):
        pm.PotentialResult({}).plot()


def test_counts_of_structures():
    excluded = [{"reason": "too-large"}, {"reason": "truncated"}, {"reason": "too-large"}]
    axes = pm.VoxelizeResult({"samples": 4, "excluded": excluded}).plot()
    assert [label.get_text() for label in axes.get_xticklabels()] == ["samples", "too-large", "truncated"]
    assert [bar.get_height() for bar in axes.patches] == [4, 2, 1] and axes.get_ylabel() == "structures"


def test_phases_that_coexist():
    ties = [
        {"phases": ["fluid", "fcc"], "packing_fractions": [0.49, 0.54], "reservoir_packing_fraction": 0.0},
        {
            "phases": ["fluid", "fcc"],
            "packing_fractions": [0.48, 0.57],
            "packing_fractions_error": [0.01, 0.02],
            "reservoir_packing_fraction": 0.1,
        },
        {"phases": ["gas", "liquid"], "packing_fractions": [0.1, 0.3], "reservoir_packing_fraction": 0.2},
    ]
    phases = pm.PhaseDiagramResult({"coexistences": ties})
    np.testing.assert_array_equal(phases.packing_fraction_errors[1], [0.01, 0.02])
    assert np.isnan(phases.packing_fraction_errors[0]).all()
    axes = phases.plot()
    assert legend(axes) == ["fluid, fcc", "gas, liquid"]
    np.testing.assert_array_equal(axes.lines[0].get_xydata(), [[0.49, 0.0], [0.54, 0.0]])
    without = pm.PhaseDiagramResult({"coexistences": []})
    with pytest.raises(ValueError, match="no coexistence"):
        without.plot()


def test_equations_of_state():
    points = [
        {"packing_fraction": 0.1, "compressibility_factor": 1.5, "compressibility_factor_error": 0.1},
        {"packing_fraction": 0.2, "compressibility_factor": 2.5, "compressibility_factor_error": None},
    ]
    sweep = pm.HardBodySweepResult({"points": points})
    assert np.isnan(sweep.free_volume_fraction).all() and np.isnan(sweep.compressibility_factor_error[1])
    axes = sweep.plot()
    assert labels(axes) == ("packing fraction", "compressibility factor")


def test_an_equation_of_state_is_read_from_its_directory(tmp_path):
    (tmp_path / "equation.json").write_text('{"points": [{"packing_fraction": 0.1}]}')
    (tmp_path / "run.json").write_text('{"kind": "hard bodies sweep"}')
    assert pm.HardBodySweepResult.read(tmp_path).packing_fraction == [0.1]
    (tmp_path / "run.json").write_text('{"kind": "sweep"}')
    with pytest.raises(pm.ProtomerError, match="holds a sweep"):
        pm.HardBodySweepResult.read(tmp_path)


def test_speeds():
    rows = [
        {"charges": charges, "energy": energy, "moves_per_cpu_second": 1e6 / charges * factor}
        for energy, factor in [("direct", 1.0), ("calibrated", 10.0)]
        for charges in [100, 1000]
    ]
    axes = pm.BenchResult({"charges": rows}).plot()
    assert legend(axes) == ["direct", "calibrated"] and labels(axes)[1] == "trial moves per CPU-second"
    np.testing.assert_allclose(axes.lines[1].get_xydata(), [[100, 1e5], [1000, 1e4]])
    with pytest.raises(ValueError, match="without an assembly"):
        pm.BenchResult({"moves": 10}).plot()


def test_results_without_a_directory_say_so():
    with pytest.raises(ValueError, match="call the verb with output="):
        pm.LatticeResult({"time": 1.0}).plot()


def test_an_answer_without_a_plot_of_its_own_draws_the_panels_of_its_figure():
    axis = {"log": False, "range": None}
    series = {"name": "D_4", "line": True, "replicas": [[1.0, 2.0]], "spans": [{"x": 1.5, "y": 0.5, "from": 1.0, "to": 2.5}]}
    points = [{"x": 1.0, "y": 2.0, "error": 0.5}, {"x": 2.0, "y": None}]
    panels = [
        {"y": {"label": "charge (e)", **axis}, "series": [{**series, "points": points}]},
        {"y": {"label": "groups", **axis, "range": [0.0, 1.05]}, "series": [{**series, "points": points[:1]}]},
    ]
    figure = {"title": "", "caption": "", "x": {"label": "pH", **axis, "log": True}, "panels": panels}
    answer = pm.Result({"ph": [7.0]}, figure=figure)
    axes = answer.plot()
    assert labels(axes) == ("pH", "charge (e)") and axes.get_xscale() == "log"
    curve, span = axes.containers
    np.testing.assert_array_equal(curve[0].get_xydata(), [[1.0, 2.0], [2.0, np.nan]])
    np.testing.assert_array_equal(span[0].get_xydata(), [[1.5, 0.5]])
    assert legend(axes) == ["D_4"]
    axes = answer.plot(quantity="groups")
    assert labels(axes) == ("pH", "groups") and axes.get_ylim() == (0.0, 1.05)
    with pytest.raises(KeyError, match="no panel 'mass'; there are charge \\(e\\), groups"):
        answer.plot(quantity="mass")
    with pytest.raises(ValueError, match="this Result has no figure"):
        pm.Result({"ph": [7.0]}).plot()


def test_an_answer_carries_its_figure():
    titrated = pm.titrate(BPTI, salt="100mM")
    label = "net charge (e)"
    axes = titrated.plot()
    assert axes.get_xlabel() == "pH" and axes.get_ylabel() == label
    assert axes.get_legend_handles_labels()[0]
