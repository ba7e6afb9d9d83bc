"""A voxel set opened by zarr-python: the same arrays, and voxels that agree with the structure they come from."""

import json

import gemmi
import numpy as np
import pytest
import zarr

from conftest import ROOT, rotation_matrix

STRUCTURE = ROOT / "data" / "structures" / "5pti.cif.gz"


def dense(group, sample):
    """(channel, z, y, x) of a sample, as the guide says."""
    known = group.attrs
    size, channels = known["size"], known["channels"]
    begin, end = group["offsets"][sample], group["offsets"][sample + 1]
    index = group["index"][begin:end]
    assert (np.diff(index.astype(np.int64)) > 0).all() and index[-1] < size**3
    out = np.zeros((len(channels), size**3), np.float32)
    for row, channel in zip(out, channels):
        row[index] = 1 if channel in known["implied_channels"] else group[channel][begin:end]
    return out.reshape(-1, size, size, size)


def make(tmp_path, protomer, *options):
    manifest = tmp_path / "set.csv"
    manifest.write_text(f'file,label,cluster,name\n{STRUCTURE},"a, b",c,one\n{STRUCTURE},d,c,two\nmissing.pdb,d,e,three\n')
    report = protomer("voxelize", "--manifest", manifest, "-o", tmp_path / "set.zarr", "--json", "--force", *options)
    return report, zarr.open_group(tmp_path / "set.zarr", mode="r")


def test_arrays_and_attributes(tmp_path, protomer):
    report, group = make(tmp_path, protomer, "--seed", 3)
    assert sorted(group.array_keys()) == ["hydropathy", "index", "offsets", "potential", "properties"]
    types = {name: str(array.dtype) for name, array in group.arrays()}
    assert types == {
        "hydropathy": "float16", "index": "uint32", "offsets": "int64", "potential": "float16", "properties": "float64",
    }
    known = dict(group.attrs)
    assert known["samples"]["name"] == ["one", "two"] and known["samples"]["label"] == ["a, b", "d"]
    assert [excluded["name"] for excluded in known["excluded"]] == ["three"]
    assert report["samples"] == 2 and report["voxels"] == group["offsets"][-1] == group["index"].shape[0]
    json.dumps(known)
    for sample in range(2):
        shape, potential, hydropathy = dense(group, sample)
        assert np.isfinite(potential).all() and np.abs(hydropathy).max() <= 4.5
        assert set(np.unique(shape)) == {0, 1} and not potential[shape == 0].any() and not hydropathy[shape == 0].any()
    assert not np.array_equal(dense(group, 0), dense(group, 1)), "two random orientations are one"


def require_voxels_at_atoms(solid, posed, spacing):
    """Atoms (Å) lie in voxels of the solid, whose axes are z, y, x, and no voxel is far from all atoms."""
    size = len(solid)
    at = np.rint(posed / spacing + (size - 1) / 2).astype(int)
    assert (at >= 0).all() and (at < size).all()
    assert solid[at[:, 2], at[:, 1], at[:, 0]].mean() > 0.999
    filled = (np.argwhere(solid)[:, ::-1] - (size - 1) / 2) * spacing
    nearest = np.sqrt(((filled[:, None] - posed[None]) ** 2).sum(-1)).min(1)
    assert nearest.max() < 4.0


def test_voxels_lie_where_the_atoms_are(tmp_path, protomer):
    """Every atom, turned as the properties say, lies in the solid, and no solid voxel is far from all atoms."""
    _, group = make(tmp_path, protomer, "--channels", "solid,shape", "--spacing", "0.9")
    columns = group["properties"].attrs["columns"]
    row = dict(zip(columns, group["properties"][0]))
    rotation = rotation_matrix([row[f"rotation_{axis}"] for axis in "wxyz"])
    structure = gemmi.read_structure(str(STRUCTURE))
    structure.setup_entities()
    structure.remove_alternative_conformations()
    structure.remove_hydrogens()
    structure.remove_ligands_and_waters()
    places = np.array([atom.pos.tolist() for chain in structure[0] for residue in chain for atom in residue])
    middle = np.array([row[f"middle_{axis}_angstrom"] for axis in "xyz"])
    posed, spacing = places @ rotation.T - middle, row["spacing_angstrom"]
    solid = dense(group, 0)[0]
    require_voxels_at_atoms(solid, posed, spacing)
    # The comparison must notice exchanged axes, the inverse rotation, nm for Å, and another spacing.
    with pytest.raises(AssertionError):
        require_voxels_at_atoms(solid.transpose(2, 1, 0), posed, spacing)
    for wrong in (places @ rotation - middle, posed / 10):
        with pytest.raises(AssertionError):
            require_voxels_at_atoms(solid, wrong, spacing)
    with pytest.raises(AssertionError):
        require_voxels_at_atoms(solid, posed, 1.0)


def require_hydropathy(values, centres, residues, reach=5.0):
    """Values are means over residues with an atom within reach (Å) of the centres; residues: (index, atoms)."""
    near = np.stack([((centres[:, None] - atoms[None]) ** 2).sum(-1).min(1) <= reach**2 for _, atoms in residues], 1)
    known = near.any(1)
    assert known.mean() > 0.99
    expected = (near * [index for index, _ in residues]).sum(1)[known] / near.sum(1)[known]
    assert np.abs(values[known] - expected).max() < 3e-3


def test_hydropathy_is_the_mean_of_the_residues_near_by(tmp_path, protomer):
    """Against the scale as printed by its authors and gemmi's atoms."""
    scale = dict(zip("ARNDCQEGHILKMFPSTWYV", (1.8, -4.5, -3.5, -3.5, 2.5, -3.5, -3.5, -0.4, -3.2, 4.5, 3.8, -3.9, 1.9, 2.8, -1.6,
                                              -0.8, -0.7, -0.9, -1.3, 4.2)))
    _, group = make(tmp_path, protomer)
    row = dict(zip(group["properties"].attrs["columns"], group["properties"][0]))
    rotation = rotation_matrix([row[f"rotation_{axis}"] for axis in "wxyz"])
    middle = np.array([row[f"middle_{axis}_angstrom"] for axis in "xyz"])
    structure = gemmi.read_structure(str(STRUCTURE))
    structure.setup_entities()
    structure.remove_alternative_conformations()
    structure.remove_hydrogens()
    structure.remove_ligands_and_waters()
    letter = lambda residue: gemmi.find_tabulated_residue(residue.name).one_letter_code.upper()
    places = lambda residue: np.array([atom.pos.tolist() for atom in residue]) @ rotation.T - middle
    residues = [(scale[letter(residue)], places(residue)) for chain in structure[0] for residue in chain]
    size = group.attrs["size"]
    begin, end = group["offsets"][0], group["offsets"][1]
    z, y, x = np.unravel_index(group["index"][begin:end].astype(np.int64), (size, size, size))
    centres = (np.stack([x, y, z], 1) - (size - 1) / 2) * row["spacing_angstrom"]
    values = group["hydropathy"][begin:end].astype(float)
    require_hydropathy(values, centres, residues)
    # It must notice the opposite sign, another reach, and axes in the other order.
    for wrong in ((-values, centres, residues), (values, centres, residues, 4.0), (values, centres[:, ::-1], residues)):
        with pytest.raises(AssertionError):
            require_hydropathy(*wrong)


def require_statistics(known, values):
    """The attribute's figures are those of the values."""
    for name, of in values.items():
        found = known["channels"][name]
        middle = np.sort(of)[len(of) // 2]
        deviation = np.sort(np.abs(of - middle))[len(of) // 2]
        expected = {"voxels": len(of), "mean": of.mean(), "standard_deviation": of.std(), "median": middle,
                    "median_deviation": deviation, "minimum": of.min(), "maximum": of.max()}
        assert found == pytest.approx(expected, rel=1e-6, abs=1e-6)


def test_statistics_are_those_of_the_samples_they_name(tmp_path, protomer):
    _, group = make(tmp_path, protomer)
    statistics = group.attrs["statistics"]
    # Two samples of one cluster cannot be split.
    assert statistics["over"] == "all samples" and statistics["samples"] == [0, 1]
    values = {name: group[name][:].astype(float) for name in ("potential", "hydropathy")}
    require_statistics(statistics, values)
    begin, end = group["offsets"][0], group["offsets"][1]
    for wrong in ({"potential": values["hydropathy"]}, {"potential": values["potential"][begin:end]}):
        with pytest.raises(AssertionError):
            require_statistics(statistics, wrong)


def test_a_loader_of_pytorch_gives_batches(tmp_path, protomer):
    torch = pytest.importorskip("torch", reason="torch is not installed; it is not required")
    _, group = make(tmp_path, protomer)

    class Voxels(torch.utils.data.Dataset):
        def __len__(self):
            return len(group["offsets"]) - 1

        def __getitem__(self, sample):
            return torch.from_numpy(dense(group, sample)), sample

    grids, numbers = next(iter(torch.utils.data.DataLoader(Voxels(), batch_size=2)))
    assert grids.dtype == torch.float32 and tuple(grids.shape) == (2, 3, 64, 64, 64) and numbers.tolist() == [0, 1]
    assert np.array_equal(grids[1].numpy(), dense(group, 1))
