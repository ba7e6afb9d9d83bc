"""How well probabilities of classes, and numbers, fit the truth; rankings compare samples of one fold only."""

import numpy as np
from plan import FOLDS
from scipy.stats import rankdata


def auc(score, positive, fold):
    """The share of pairs of a positive and a negative that the score puts in order; ties count half.

    Pairs are of one fold, because each fold has its own network, and because the prior of a fold falls as its share of
    positives rises, which would push the value of any weak predictor below one half.
    """
    right = pairs = 0.0
    for held in range(FOLDS):
        own, values = positive[fold == held], score[fold == held]
        n, m = own.sum(), (~own).sum()
        right += rankdata(values)[own].sum() - n * (n + 1) / 2
        pairs += n * m
    return right / pairs


def rank_correlation(score, truth, fold):
    """Spearman's correlation within each fold, weighted by the number of samples."""
    total = 0.0
    for held in range(FOLDS):
        a, b = rankdata(score[fold == held]), rankdata(truth[fold == held])
        if len(a) > 1 and a.std() > 0 and b.std() > 0:
            total += len(a) * np.corrcoef(a, b)[0, 1]
    return total / len(fold)


def scores(p, y, fold, ratio):
    """Balanced accuracy, ranking and log-loss of probabilities."""
    named, classes = p.argmax(axis=1), p.shape[1]
    present = [c for c in range(classes) if (y == c).any()]
    expected = p @ np.arange(classes)
    result = {"balanced accuracy": np.mean([(named[y == c] == c).mean() for c in present])}
    if classes == 2:
        result["AUC"] = auc(expected, y == 1, fold)
    if ratio is not None:
        result["rank correlation"] = rank_correlation(expected, ratio, fold)
    result["log-loss"] = -np.log(np.maximum(p[np.arange(len(y)), y], 1e-6)).mean()
    return result


def scores_of_numbers(predicted, truth, fold, prior):
    """Error, ranking, and the share of the variance about the prior that is explained."""
    square = np.mean((predicted - truth) ** 2)
    return {
        "rms error": np.sqrt(square),
        "rank correlation": rank_correlation(predicted, truth, fold),
        "variance explained": 1 - square / np.mean((prior - truth) ** 2),
    }
