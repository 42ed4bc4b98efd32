"""Synergies of many people: modules (columns of W) that are alike, by k-means."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from warpmuscle.core.array_types import Floats, Integers
from warpmuscle.core.errors import SignalError
from warpmuscle.core.extras import imported
from warpmuscle.core.plain_text import number_of

STARTS = 50  # of k-means
PER_PERSON = 2  # most clusters, in parts of the most modules that a person has


@dataclass(frozen=True)
class Clusters:
    """S modules of P people, in K clusters; clusters stand in the order of how many people have them."""

    muscles: tuple[str, ...]  # (M,)
    modules: Floats  # (M, S), the greatest weight of each 1
    person: Integers  # (S,) number of the person
    number: Integers  # (S,) number of the module among its person's, from 0
    label: Integers  # (S,) number of the cluster
    centre: Floats  # (M, K) mean module, the greatest weight 1
    cosine: Floats  # (S,) of a module with its cluster's centre
    silhouette: dict[int, float]  # by K, of those that were tried: -1..1, the greater the better

    @property
    def count(self) -> int:
        return int(self.centre.shape[1])

    def people(self, cluster: int) -> int:
        """How many people have a module in a cluster."""
        return len(set(self.person[self.label == cluster].tolist()))


def cluster_modules(
    weights: Sequence[Floats], muscles: Sequence[Sequence[str]], count: int | None = None, seed: int = 0
) -> Clusters:
    """Clusters of the modules of several people, by k-means on modules of length 1, whose angles so decide.

    Args:
        weights: (M, N) of each person. muscles: names (M,) of each, in any order.
        count: K; by default as many as have the highest mean silhouette (Rousseeuw 1987), at least as many as the most
            common number of modules of a person.

    Raises:
        SignalError: fewer than two people, not of the same muscles, or more clusters than modules.
        Error: scikit-learn is not installed.
    """
    names, modules, person, number = _joined(weights, muscles)
    total = modules.shape[1]
    lengths = np.linalg.norm(modules, axis=0)
    unit = (modules / np.where(lengths > 0.0, lengths, 1.0)).T
    if count is not None and not 1 <= count <= total:
        raise SignalError(f"{number_of(count, 'cluster', 'are')} not to be had of {number_of(total, 'module')}")
    distinct = len(np.unique(unit, axis=0))
    tried = [min(count, distinct)] if count is not None else _numbers([w.shape[1] for w in weights], distinct)
    cluster = imported("sklearn.cluster", "clusters need")
    from sklearn.metrics import silhouette_score

    labels, silhouette = dict[int, Integers](), dict[int, float]()
    for k in tried:
        labels[k] = cluster.KMeans(k, n_init=STARTS, random_state=seed).fit_predict(unit)
        held = len(np.unique(labels[k]))
        silhouette[k] = float(silhouette_score(unit, labels[k])) if 1 < held < total else 0.0
    best = max(tried, key=lambda k: silhouette[k])
    return _described(names, modules, unit, person, number, labels[best], silhouette)


def _joined(
    weights: Sequence[Floats], muscles: Sequence[Sequence[str]]
) -> tuple[tuple[str, ...], Floats, Integers, Integers]:
    """Names of the muscles, and all modules with the numbers of their person and within it."""
    if len(weights) < 2:
        raise SignalError("synergies of at least two people are needed to find what they have in common")
    names = tuple(muscles[0])
    parts = []
    for index, (own, table) in enumerate(zip(muscles, weights, strict=True), 1):
        if sorted(own) != sorted(names):
            odd = sorted(set(own) ^ set(names))
            raise SignalError(f"person {index} does not have the same muscles as the first: {', '.join(odd)}")
        parts.append(table[[list(own).index(name) for name in names]])
    counts = [part.shape[1] for part in parts]
    number = np.concatenate([np.arange(count) for count in counts])
    return names, np.concatenate(parts, axis=1), np.repeat(np.arange(len(parts)), counts), number


def _numbers(counts: Sequence[int], total: int) -> list[int]:
    """Numbers of clusters to try."""
    usual = int(np.bincount(counts).argmax())
    return list(range(min(max(usual, 2), total), min(PER_PERSON * max(counts), total) + 1))


def _described(
    names: tuple[str, ...], modules: Floats, unit: Floats, person: Integers, number: Integers, label: Integers,
    silhouette: dict[int, float],
) -> Clusters:  # fmt: skip
    """The clusters in their order."""
    kinds = np.unique(label)
    people = [len(set(person[label == k].tolist())) for k in kinds]
    order = sorted(range(len(kinds)), key=lambda i: (-people[i], -int((label == kinds[i]).sum())))
    mean = np.array([unit[label == kinds[i]].mean(axis=0) for i in order])
    found = np.array([order.index(int(np.searchsorted(kinds, k))) for k in label])
    cosine = np.sum(unit * mean[found], axis=1) / np.maximum(np.linalg.norm(mean[found], axis=1), 1e-12)
    centre = (mean / np.maximum(mean.max(axis=1, keepdims=True), 1e-12)).T
    return Clusters(names, modules, person, number, found, centre, cosine, silhouette)
