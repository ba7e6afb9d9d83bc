"""A potential written as MRC, CCP4, OpenDX and NumPy, opened by mrcfile, gemmi, GridDataFormats and NumPy: the same values."""

import gemmi
import gridData
import mrcfile
import numpy as np
import pytest

# Three ions along x: the grid is longer than high, and the potential is unlike itself under any exchange of axes.
IONS = """ATOM 1 I ION 1 0.0 0.0 0.0 1.0 3.0
ATOM 2 I ION 1 14.0 1.0 0.0 -1.0 2.0
ATOM 3 I ION 1 28.0 2.0 5.0 0.5 2.0
"""
CONDITIONS = ["--salt", "100mM", "--spacing", "1.0", "--margin", "7", "--no-error-estimate"]


@pytest.fixture(scope="module")
def written(tmp_path_factory, protomer):
    """The folder of the files, and what the binary says of the grid."""
    folder = tmp_path_factory.mktemp("volumes")
    (folder / "ions.pqr").write_text(IONS)
    for suffix in ("ccp4", "map", "mrc", "dx", "npz"):
        outcome = protomer(
            "potential", folder / "ions.pqr", *CONDITIONS, "-o", folder / f"p.{suffix}", "--json",
        )
    assert len(set(outcome["grid"]["shape"])) > 1, "a cubic grid hides exchanged axes"
    return folder, outcome["grid"]


def by_mrcfile(path):
    """Values with axes x, y, z, the origin and the spacing, Å."""
    with mrcfile.open(path, permissive=False) as file:
        header = file.header
        assert (header.mapc, header.mapr, header.maps) == (1, 2, 3)
        assert (header.nxstart, header.nystart, header.nzstart) == (0, 0, 0)
        origin, spacing = (np.array([float(of[axis]) for axis in "xyz"]) for of in (header.origin, file.voxel_size))
        return file.data.transpose(2, 1, 0).copy(), origin, spacing


def by_numpy(path):
    with np.load(path) as file:
        assert sorted(file.files) == ["origin_angstrom", "potential_kt_per_e", "spacing_angstrom"]
        spacing = np.broadcast_to(file["spacing_angstrom"], 3)
        return file["potential_kt_per_e"].transpose(2, 1, 0), file["origin_angstrom"], spacing


def by_grid_data(path):
    grid = gridData.Grid(str(path))
    return grid.grid, np.array(grid.origin), np.array(grid.delta)


def require_equal(ours, theirs, tolerance):
    """Two readings: shape, origin, spacing (Å) and every value (kT/e, in parts of the largest)."""
    values, origin, spacing = ours
    other_values, other_origin, other_spacing = theirs
    assert values.shape == other_values.shape
    assert np.allclose(origin, other_origin, rtol=0, atol=1e-5) and np.allclose(spacing, other_spacing, rtol=1e-6)
    assert np.abs(values - other_values).max() <= tolerance * np.abs(values).max()


def test_three_files_hold_one_potential(written):
    folder, grid = written
    exact = by_numpy(folder / "p.npz")
    values, origin, spacing = exact
    assert list(values.shape) == grid["shape"] and values.dtype == np.float64
    assert np.array_equal(origin, grid["origin_angstrom"]) and (spacing == grid["spacing_angstrom"]).all()
    mrc, dx = by_mrcfile(folder / "p.mrc"), by_grid_data(folder / "p.dx")
    require_equal(exact, mrc, 1e-7)  # 32 bits
    require_equal(exact, dx, 1e-6)  # seven digits
    assert np.array_equal(mrc[0], values.astype(np.float32))
    # The comparison must notice exchanged axes, nm for Å, a shift of half a voxel, and a flipped sign.
    values, origin, spacing = mrc
    wrong = [
        (values.transpose(2, 1, 0), origin, spacing),
        (values[:, ::-1], origin, spacing),
        (values, origin / 10, spacing),
        (values, origin, spacing / 10),
        (values, origin + 0.5 * spacing, spacing),
        (-values, origin, spacing),
    ]
    for reading in wrong:
        with pytest.raises(AssertionError):
            require_equal(exact, reading, 1e-7)


def test_mrc_is_valid_and_its_header_true(written):
    folder, _ = written
    path = folder / "p.mrc"
    assert mrcfile.validate(path)
    with mrcfile.open(path) as file:
        header, data = file.header, file.data.astype(float)
        assert header.mode == 2 and header.nversion == 20140 and header.ispg == 1
        assert np.allclose([header.dmin, header.dmax], [data.min(), data.max()], rtol=1e-6)
        assert np.allclose([header.dmean, header.rms], [data.mean(), data.std()], rtol=1e-4)
        assert "potential" in file.get_labels()[0]
    damaged = bytearray(path.read_bytes())
    damaged[208:212] = b"XXXX"
    (folder / "damaged.mrc").write_bytes(damaged)
    with pytest.warns(RuntimeWarning):
        assert not mrcfile.validate(folder / "damaged.mrc")


def require_values_at(reading, places, potentials):
    """Interpolated between voxels by gemmi, in parts of the largest."""
    found = [reading.grid.interpolate_value(gemmi.Position(*place)) for place in places]
    assert np.abs(np.array(found) - potentials).max() < 1e-5 * np.abs(potentials).max()


def potentials_at(places, folder, protomer):
    """What `--points` prints at places, kT/e."""
    (folder / "points").write_text("\n".join(" ".join(map(repr, map(float, place))) for place in places) + "\n")
    outcome = protomer(
        "potential", folder / "ions.pqr", *CONDITIONS, "--points", folder / "points", "--json",
    )
    return np.array(outcome["potentials_kT_per_e"])


@pytest.mark.parametrize("suffix", ["ccp4", "map"])
def test_gemmi_finds_the_place_of_a_ccp4_map(written, protomer, suffix):
    """gemmi reads NSTART: at the points themselves it finds what `--points` prints there."""
    folder, grid = written
    reading = gemmi.read_ccp4_map(str(folder / f"p.{suffix}"))
    starts = np.array([reading.header_i32(word) for word in (5, 6, 7)])
    assert [reading.header_float(word) for word in (50, 51, 52)] == [0, 0, 0], "some readers add both"
    reading.setup(float("nan"))
    assert (starts != 0).all()
    inner = np.array(grid["shape"]) - 3
    places = (starts + np.random.default_rng(2).integers(2, inner, size=(40, 3))) * grid["spacing_angstrom"]
    potentials = potentials_at(places, folder, protomer)
    require_values_at(reading, places, potentials)
    for wrong in (places + [1, 0, 0], places - starts):
        with pytest.raises(AssertionError):
            require_values_at(reading, wrong, potentials)


def test_the_place_of_an_mrc_map_is_its_origin(written, protomer):
    """mrcfile and GridDataFormats read ORIGIN: at the points of their grids they hold what `--points` prints."""
    folder, _ = written
    for values, origin, spacing in (by_mrcfile(folder / "p.mrc"), by_grid_data(folder / "p.mrc")):
        voxels = np.random.default_rng(3).integers(2, np.array(values.shape) - 2, size=(40, 3))
        potentials = potentials_at(origin + voxels * spacing, folder, protomer)
        scale = np.abs(potentials).max()
        assert np.abs(values[tuple(voxels.T)] - potentials).max() < 1e-5 * scale
        assert np.abs(values[tuple((voxels + [1, 0, 0]).T)] - potentials).max() > 1e-2 * scale


def test_gemmi_reads_the_map(written, protomer):
    """gemmi ignores the origin of an MRC file: at points counted from the first voxel it finds what `--points` prints."""
    folder, grid = written
    reading = gemmi.read_ccp4_map(str(folder / "p.mrc"), setup=True)
    assert reading.grid.axis_order == gemmi.AxisOrder.XYZ
    assert [reading.grid.nu, reading.grid.nv, reading.grid.nw] == grid["shape"]
    assert np.allclose(reading.grid.spacing, grid["spacing_angstrom"], rtol=1e-6)
    assert np.array_equal(reading.grid.array, by_mrcfile(folder / "p.mrc")[0])
    rng = np.random.default_rng(1)
    voxels = rng.integers(2, np.array(grid["shape"]) - 2, size=(40, 3))
    places = grid["origin_angstrom"] + voxels * grid["spacing_angstrom"]
    potentials = potentials_at(places, folder, protomer)
    from_first = places - grid["origin_angstrom"]
    require_values_at(reading, from_first, potentials)
    # The comparison must notice exchanged axes, nm for Å, and a sign.
    for wrong in (from_first[:, [1, 0, 2]], from_first / 10):
        with pytest.raises(AssertionError):
            require_values_at(reading, wrong, potentials)
    with pytest.raises(AssertionError):
        require_values_at(reading, from_first, -potentials)
