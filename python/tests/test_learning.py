"""Train, tune and predict on a small set, with what they draw."""

import numpy as np
import pytest

import protomer as pm
from conftest import BPTI

SMALL = {"least_samples": 1, "fractions": [0.5, 0.25, 0.25]}
PROTEASE = BPTI.with_name("4e43.pdb.gz")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """With `set.zarr`: two structures, four orientations each."""
    folder = tmp_path_factory.mktemp("learning")
    rows = [f"{BPTI},inhibitor,i{n},inhibitor{n}\n{PROTEASE},protease,p{n},protease{n}\n" for n in range(4)]
    (folder / "set.csv").write_text("file,label,cluster,name\n" + "".join(rows))
    made = {"size": 32, "spacing": 2, "potential": "debye-hueckel"}
    pm.voxelize(manifest=folder / "set.csv", output=folder / "set.zarr", **made)
    return folder


@pytest.fixture(scope="module")
def trained(folder):
    return pm.train(folder / "set.zarr", **SMALL, widths="4", groups=0, epochs=3, output=folder / "run")


def axes_of(result, plot="plot"):
    matplotlib = pytest.importorskip("matplotlib", reason="matplotlib is not installed")
    matplotlib.use("Agg")
    return getattr(result, plot)()


def test_a_training_draws_scores_beside_baselines(trained):
    axes = axes_of(trained)
    names = [label.get_text() for label in axes.get_xticklabels()]
    assert names[0] == "network" and set(names[1:]) == {name.replace("_", " ") for name in trained.baselines}
    heights = dict(zip(names, (bar.get_height() for bar in axes.patches)))
    assert heights["network"] == trained.balanced_accuracy and heights["prior"] == trained.baselines.prior.balanced_accuracy
    assert axes.get_ylabel() == "balanced accuracy" and axes.lines[-1].get_ydata()[0] == 0.5


def test_a_training_draws_its_learning_curve(trained):
    history = trained.history
    assert history["epoch"].tolist() == [1, 2, 3]
    axes = axes_of(trained, "plot_history")
    training, validation, best = axes.lines
    np.testing.assert_array_equal(training.get_ydata(), history["training_loss_nats"])
    np.testing.assert_array_equal(validation.get_ydata(), history["validation_loss_nats"])
    assert best.get_xdata()[0] == trained.best_epoch == 1 + np.argmin(history["validation_loss_nats"])
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("epoch", "loss (nats)")


def test_a_search_draws_its_trials(folder):
    search = pm.tune(folder / "set.zarr", **SMALL, trials=3, epochs=1, channels=["shape"], output=folder / "search")
    axes = axes_of(search)
    assert search.validation_loss_nats.shape == (3,) and np.all(np.diff(search.validation_loss_nats) >= 0)
    drawn = axes.lines[0].get_xydata()
    np.testing.assert_array_equal(drawn, np.column_stack([search.learning_rate, search.validation_loss_nats]))
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("learning rate", "validation loss (nats)")


def test_a_prediction_has_a_row_per_sample(folder, trained):
    prediction = pm.predict(folder / "run", folder / "set.zarr", output=folder / "predictions.csv")
    assert prediction.names[:2] == ["inhibitor0", "protease0"] and prediction.probabilities.shape == (8, 2)
    np.testing.assert_allclose(prediction.probabilities.sum(axis=1), 1.0)
    most = prediction.probabilities.argmax(axis=1)
    assert prediction.predicted == [prediction.classes[place] for place in most]
    assert prediction.scores.log_loss_nats == trained.log_loss_nats
    table = pm.read_log(folder / "predictions.csv")
    np.testing.assert_array_equal(table["p_protease"], prediction.probabilities[:, 1])
    axes = axes_of(prediction)
    counts = np.array(axes.images[0].get_array())
    assert counts.sum() == 8 and counts.sum(axis=1).tolist() == [4, 4]
    assert counts[1, 0] == prediction.predicted[1::2].count("inhibitor")
    assert [label.get_text() for label in axes.get_yticklabels()] == ["inhibitor", "protease"]
    with pytest.raises(pm.ProtomerError, match="--force"):
        pm.predict(folder / "run", folder / "set.zarr", output=folder / "predictions.csv")
    with pytest.raises(pm.ProtomerError, match="such as .*run"):
        pm.predict(folder, folder / "set.zarr")


def test_numbers_are_predicted_and_drawn_against_the_true_ones(folder):
    rows = [f"{BPTI},{n / 4},i{n},inhibitor{n}\n{PROTEASE},{2 + n / 4},p{n},protease{n}\n" for n in range(4)]
    (folder / "numbers.csv").write_text("file,label,cluster,name\n" + "".join(rows))
    made = {"size": 32, "spacing": 2, "potential": "debye-hueckel", "channels": ["shape"]}
    pm.voxelize(manifest=folder / "numbers.csv", output=folder / "numbers.zarr", **made)
    small = SMALL | {"widths": "4", "groups": 0, "epochs": 1}
    trained = pm.train(folder / "numbers.zarr", target="number", number_classes=2, **small, output=folder / "of-numbers")
    assert trained.classes == ["below 1", "from 1"] and trained.numbers.classes.bounds == [1.0]
    prediction = pm.predict(folder / "of-numbers", folder / "numbers.zarr")
    expected = prediction.probabilities @ np.array(trained.numbers.classes.means)
    np.testing.assert_allclose(prediction.predicted_numbers, expected)
    axes = axes_of(prediction)
    true, drawn = axes.lines[0].get_xydata().T
    np.testing.assert_array_equal(drawn, prediction.predicted_numbers)
    assert true[:2].tolist() == [0.0, 2.0] and axes.get_ylabel() == "predicted number"
