"""A Parzen estimator of the trials of one kind, good or bad."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from optuna.distributions import BaseDistribution, CategoricalDistribution, FloatDistribution

from mobo_core.jit.normal import CENTRAL, TAIL
from mobo_core.search.samplers.tpe import density

Floats = NDArray[np.float64]
Codes = NDArray[np.int16]
Bandwidth = Literal["scott", "neighbours"]

PRIOR_WEIGHT = 1.0


def supported(space: dict[str, BaseDistribution]) -> bool:
    """Return whether the estimator knows all distributions: categorical ones, and floats without step or log."""
    return all(
        isinstance(d, CategoricalDistribution) or (isinstance(d, FloatDistribution) and d.step is None and not d.log)
        for d in space.values()
    )


class Space:
    """Parameters in the order in which random numbers go to them: categorical ones, then real ones.

    Args:
        space: distributions by name, :func:`supported`.
    """

    def __init__(self, space: dict[str, BaseDistribution]) -> None:
        self.distributions = space
        categorical = {name: d for name, d in space.items() if isinstance(d, CategoricalDistribution)}
        real = {name: d for name, d in space.items() if isinstance(d, FloatDistribution)}
        self.categorical, self.real = list(categorical), list(real)
        self.choices = np.array([len(d.choices) for d in categorical.values()], np.int64)
        self.low = np.array([d.low for d in real.values()], np.float64)
        self.high = np.array([d.high for d in real.values()], np.float64)

    def __len__(self) -> int:
        """Return the number of parameters."""
        return len(self.distributions)

    def external(self, x: Floats, c: Floats, point: int) -> dict[str, object]:
        """Return one drawn point as Optuna's parameters."""
        values = {name: float(c[i, point]) for i, name in enumerate(self.categorical)}
        values |= {name: float(x[i, point]) for i, name in enumerate(self.real)}
        return {name: d.to_external_repr(values[name]) for name, d in self.distributions.items()}


class Estimator:
    """The density of some trials' parameters, a prior mixed in.

    Args:
        space: the parameters.
        codes: choices of the trials, shape (categorical parameters, trials + 1); the last column is free.
        mu: real values, shape (real parameters, trials + 1), likewise; with fewer than WIDTH parameters so many rows,
            the first ones zero.
        weight: of the trials, shape (trials,).
        bandwidth: ``scott``: one for all trials, which narrows as their number grows; ``neighbours``: for each
            trial the wider gap to the next values.
        volumes: returns for ``scott``, from its bandwidths, the trials' :func:`density.volumes`, or None if it
            cannot.
    """

    def __init__(
        self,
        space: Space,
        codes: Codes,
        mu: Floats,
        weight: Floats,
        bandwidth: Bandwidth,
        volumes: Callable[[Floats], Floats | None] = lambda sigma: None,
    ) -> None:
        self._space, self._codes, self._mu = space, codes, mu
        n, reals = len(weight), len(space.real)
        self._weight = np.append(weight, PRIOR_WEIGHT) if n else np.ones(1)
        codes[:, n], mu[len(mu) - reals :, n] = -1, 0.5 * (space.low + space.high)
        volume, self._offset = np.empty(n + 1), np.zeros(n + 1)
        known: Floats | None = None
        if bandwidth == "scott":
            self._sigma, scott = np.empty((reals, 2)), np.empty(reals)
            density.scott_bandwidths(n, len(space), space.low, space.high, scott)
            self._sigma[:, 0] = scott
            known = volumes(scott)
        else:
            self._sigma = np.empty((reals, n + 1))
            density.neighbour_bandwidths(mu, n, space.low, space.high, self._sigma)
        self._sigma[:, -1] = space.high - space.low
        if known is not None:
            volume[:n] = known
        first = 0 if known is None else n
        density.volumes(mu, self._sigma, first, space.low, space.high, CENTRAL, TAIL, volume, self._offset)
        least = PRIOR_WEIGHT / (n + 1)
        norm = 1.0 + least * space.choices
        self._categorical = np.stack([(1.0 + least) / norm, least / norm], axis=1)
        self._factor, self._inverse = volume, np.empty((len(mu), self._sigma.shape[1]))
        density.fit(self._weight, volume, self._sigma, self._factor, self._inverse)

    def draw(self, u: Floats) -> tuple[Floats, Floats]:
        """Return points as (real values, choices), shapes (parameters of the kind, points).

        ``u`` holds uniform numbers, shape (1 + parameters, points).
        """
        space = self._space
        x, c = np.empty((len(space.real), u.shape[1])), np.empty((len(space.categorical), u.shape[1]))
        density.draw(
            u, self._weight, self._mu, self._sigma, self._codes, space.choices, self._categorical,
            space.low, space.high, CENTRAL, TAIL, x, c,
        )  # fmt: skip
        return x, c

    def log_density(self, x: Floats, c: Floats) -> Floats:
        """Return the log density at points, which are given as :meth:`draw` returns them."""
        out = np.empty(x.shape[1])
        density.log_density(
            x, c, self._mu, self._inverse, self._factor, self._offset, self._codes, self._space.choices,
            self._categorical, out,
        )  # fmt: skip
        return out
