"""Scores of a network and of the baselines, with intervals and a permutation test."""

import collections
import random

import numpy as np

from baselines import features, linear, logistic, surface_summaries
from networks import folder_of, predictions, runs_of
from plan import CLASSES, DRAWS, FOLDS
from samples import blocks, exchanged, folds_of, samples_of
from scores import scores, scores_of_numbers


def judge(output, task, setting):
    """Scores of the network and the baselines on the held-out folds, with intervals over draws of clusters."""
    folder, classes = folder_of(output, task, setting), CLASSES.get(task)
    everything = samples_of(output, task)
    fold_of = dict(zip((s["name"] for s in everything), folds_of(everything)))
    network = predictions(folder / runs_of(setting), classes)
    samples = [sample for sample in everything if sample["name"] in network]
    fold = np.array([fold_of[sample["name"]] for sample in samples])
    ratio = np.array([sample["ratio"] for sample in samples]) if "ratio" in samples[0] else None
    y = np.array([classes.index(sample["label"]) for sample in samples]) if classes else ratio
    # Predictions are probabilities of the classes, or one number.
    predicted = {"network": np.array([network[sample["name"]] for sample in samples])}
    prior = np.zeros((len(y), len(classes or [1])))
    for held in range(FOLDS):
        rest = y[fold != held]
        prior[fold == held] = np.bincount(rest, minlength=len(classes)) / len(rest) if classes else rest.mean()
    predicted["prior"] = prior

    def score(p, chosen, truth):
        """Scores of predictions of some samples, whose truth is that of others where labels are exchanged."""
        if not classes:
            return scores_of_numbers(p[:, 0], y[truth], fold[chosen], prior[chosen, 0])
        return scores(p, y[truth], fold[chosen], None if ratio is None else ratio[truth])

    summaries = surface_summaries(folder)
    mean_potentials = [summaries[sample["name"]]["mean potential"][0] for sample in samples]
    for kind, x in features(task, samples, summaries).items():
        p = np.zeros_like(prior)
        for held in range(FOLDS):
            rest = fold != held
            if classes:
                p[~rest] = logistic(x[rest], y[rest], len(classes), x[~rest])
            else:
                p[~rest, 0] = linear(x[rest], y[rest], x[~rest])
        predicted[kind] = p

    groups = blocks(samples)
    everyone = np.arange(len(y))
    known = {who: score(p, everyone, everyone) for who, p in predicted.items()}
    random_numbers = np.random.default_rng(1)
    drawn = {who: collections.defaultdict(list) for who in predicted}
    for _ in range(DRAWS):
        chosen = np.concatenate([groups[g] for g in random_numbers.integers(len(groups), size=len(groups))])
        for who, p in predicted.items():
            for what, value in score(p[chosen], chosen, chosen).items():
                drawn[who][what].append(value)
    judged = {}
    for who in predicted:
        judged[who] = {}
        for what, value in known[who].items():
            own, best = np.array(drawn[who][what]), np.array(drawn["network"][what])
            judged[who][what] = {
                "value": value,
                "interval": np.nanquantile(own, [0.025, 0.975]).tolist(),
                "network_less_this": known["network"][what] - value,
                "interval_of_difference": np.nanquantile(best - own, [0.025, 0.975]).tolist(),
            }

    draw = random.Random(2)
    least = collections.Counter()
    for _ in range(DRAWS):
        source = np.array(exchanged(groups, draw))
        for what, value in score(predicted["network"], everyone, source).items():
            is_loss = what in ("log-loss", "rms error")
            least[what] += (value <= known["network"][what]) if is_loss else (value >= known["network"][what])
    p_values = {what: (least[what] + 1) / (DRAWS + 1) for what in known["network"]}
    of_classes = {}
    if classes:
        confusion = np.zeros((len(classes), len(classes)), int)
        np.add.at(confusion, (y, predicted["network"].argmax(axis=1)), 1)
        counts = dict(zip(classes, np.bincount(y, minlength=len(classes)).tolist()))
        of_classes = {"classes": counts, "confusion": confusion.tolist()}
    return {
        "samples": len(y),
        "clusters": len(groups),
        "left_out": len(everything) - len(samples),
        "scores": judged,
        "permutation_p": p_values,
        **of_classes,
        "correlation_of_mean_potential_and_charge": np.corrcoef(mean_potentials, [s["charge"] for s in samples])[0, 1],
        "rows": [
            {
                "name": sample["name"],
                "cluster": sample["cluster"],
                "class": sample["label"],
                "charge": sample["charge"],
                "residues": sample["residues"],
                "ratio": sample.get("ratio"),
                "network": predicted["network"][i].tolist(),
                "baseline": predicted[list(predicted)[-1]][i].tolist(),
            }
            for i, sample in enumerate(samples)
        ],
    }
