"""Results of voxel sets and networks."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ._chart import Axis, Bars, Cells, Chart, Curve, Level, Mark
from ._errors import unknown
from ._log import read_log
from ._result import Result, numbers

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Numbers = NDArray[np.float64]


class VoxelizeResult(Result):
    """A set of voxels made of structures."""

    def _chart(self, quantity: str | None) -> Chart:
        """The number of structures that became samples, and the numbers excluded by reason."""
        reasons = [exclusion["reason"] for exclusion in self._fields["excluded"]]
        counts = {"samples": self._fields["samples"], **{name: reasons.count(name) for name in sorted(set(reasons))}}
        return Chart(Axis(), Axis("structures"), [Bars(list(counts), list(counts.values()))])


class TrainResult(Result):
    """Scores of a training, compared with predictions without voxels."""

    @property
    def history(self) -> dict[str, NDArray[Any]]:
        """The columns of `history.csv`, one entry per epoch, (E,) each; losses in nats."""
        return read_log(self._file("history.csv"))

    def _chart(self, quantity: str | None) -> Chart:
        """Balanced accuracy on the test part with its 95 % interval, next to the baselines and guessing (`accuracy`); or the losses of
        both parts, nats, against the epoch, with the kept epoch (`history`)."""
        if quantity not in (None, "accuracy", "history"):
            unknown("quantity", quantity, ["accuracy", "history"])
        if quantity == "history":
            history = self.history
            curves = [Curve(history["epoch"], history[f"{part}_loss_nats"], part) for part in ("training", "validation")]
            return Chart(Axis("epoch"), Axis("loss (nats)"), [*curves, Level(self._fields["best_epoch"], vertical=True)])
        accuracy = self._fields["balanced_accuracy"]
        interval = self._fields["bootstrap_95"]["balanced_accuracy"]
        reach = [[max(accuracy - interval["low"], 0.0)], [max(interval["high"] - accuracy, 0.0)]]
        baselines = self._fields["baselines"]
        names = [name.replace("_", " ") for name in baselines]
        marks: list[Mark] = [
            Bars(["network"], [accuracy], reach),
            Bars(names, [baselines[name]["balanced_accuracy"] for name in baselines], colour="0.7"),
            Level(1.0 / len(self._fields["classes"])),
        ]
        return Chart(Axis(slanted=True), Axis("balanced accuracy", range=(0.0, 1.0)), marks)

    def plot_history(self, ax: Axes | None = None) -> Axes:
        """The same as `plot(quantity="history")`."""
        return self.plot(ax, quantity="history")


class TuneResult(Result):
    """Trials of a search, best first."""

    @property
    def validation_loss_nats(self) -> Numbers:
        """Smallest loss of each trial on the validation part, nats, (N,); NaN where it diverged."""
        return numbers([trial["validation_loss_nats"] for trial in self._fields["trials"]])

    @property
    def learning_rate(self) -> Numbers:
        """Learning rate of each trial, (N,)."""
        return numbers([trial["settings"]["training"]["learning_rate"] for trial in self._fields["trials"]])

    def _chart(self, quantity: str | None) -> Chart:
        """Smallest loss of each trial on the validation part, nats, against its learning rate."""
        trials = Curve(self.learning_rate, self.validation_loss_nats, marker="o", line="")
        return Chart(Axis("learning rate", log=True), Axis("validation loss (nats)"), [trials])


class PredictResult(Result):
    """Predictions for the samples of a set, one entry per sample that could be read."""

    @property
    def names(self) -> list[str]:
        """Names of the samples, N of them."""
        return [sample["name"] for sample in self._fields["samples"]]

    @property
    def predicted(self) -> list[str]:
        """The most probable class of each sample, N of them."""
        return [sample["predicted"] for sample in self._fields["samples"]]

    @property
    def probabilities(self) -> Numbers:
        """Probability of each class for each sample, (N, C), in the order of `classes`."""
        return np.array([sample["probabilities"] for sample in self._fields["samples"]], dtype=np.float64)

    @property
    def predicted_numbers(self) -> Numbers:
        """The predicted number of each sample, (N,); NaN if the network predicts classes that are not those of a number."""
        return numbers([sample.get("predicted_number") for sample in self._fields["samples"]])

    def _chart(self, quantity: str | None) -> Chart:
        """The confusion matrix, with a separate row for samples of unknown class; of numbers, the predicted against the true ones."""
        if np.isfinite(self.predicted_numbers).any():
            return self._numbers()
        classes: list[str] = self._fields["classes"]
        samples = self._fields["samples"]
        rows = [*classes, "unknown"] if any(sample["class"] is None for sample in samples) else classes
        counts = np.zeros((len(rows), len(classes)))
        for sample in samples:
            counts[rows.index(sample["class"] or "unknown"), classes.index(sample["predicted"])] += 1
        x = Axis("predicted", ticks=(range(len(classes)), classes))
        y = Axis("class", ticks=(range(len(rows)), rows))
        return Chart(x, y, [Cells(counts, written=True)])

    def _numbers(self) -> Chart:
        known = np.array([sample["class"] is not None for sample in self._fields["samples"]])
        true = np.array([float(sample["label"]) for sample in self._fields["samples"] if sample["class"] is not None])
        marks = [Curve(true, self.predicted_numbers[known], marker="o", line="")]
        if true.size:
            ends = [true.min(), true.max()]
            marks.append(Curve(ends, ends, line="--", colour="0.5"))
        return Chart(Axis("true number"), Axis("predicted number"), marks)
