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
        mu: real values, shape (real parameters, trials + 1), likewise.
        weight: of the trials, shape (trials,).
        bandwidth: ``scott``: one for all trials, which narrows as their number grows; ``neighbours``: for each
            trial the wider gap to the next values.
        masses: writes for ``scott``, from its bandwidths and into an array like ``mu``, how much of the trials'
            normal distributions lies within the bounds; returns False if it cannot.
    """

    def __init__(
        self,
        space: Space,
        codes: Floats,
        mu: Floats,
        weight: Floats,
        bandwidth: Bandwidth,
        masses: Callable[[Floats, Floats], bool] = lambda sigma, mass: False,
    ) -> None:
        self._space, self._codes, self._mu = space, codes, mu
        n = len(weight)
        self._weight = np.append(weight, PRIOR_WEIGHT) if n else np.ones(1)
        codes[:, n], mu[:, n] = -1, 0.5 * (space.low + space.high)
        self._sigma, mass, offset = np.empty_like(mu), np.empty_like(mu), np.zeros(n + 1)
        known = 0
        if bandwidth == "scott":
            one = np.empty(len(mu))
            density.scott_bandwidths(n, len(space), space.low, space.high, one)
            self._sigma[:] = one[:, None]
            known = n if masses(one, mass) else 0
        else:
            density.neighbour_bandwidths(mu, n, space.low, space.high, self._sigma)
        self._sigma[:, n] = space.high - space.low
        density.masses(mu, self._sigma, known, space.low, space.high, CENTRAL, TAIL, mass, offset)
        least = PRIOR_WEIGHT / (n + 1)
        norm = 1.0 + least * space.choices
        self._categorical = np.stack([(1.0 + least) / norm, least / norm], axis=1)
        rows = max(len(mu), density.WIDTH)
        self._inverse, self._scaled = np.zeros((rows, n + 1)), np.zeros((rows, n + 1))
        self._factor, self._offset = np.empty(n + 1), offset
        density.fit(mu, self._sigma, mass, self._weight, self._inverse, self._scaled, self._factor, self._offset)

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
            x, c, self._inverse, self._scaled, self._factor, self._offset, self._codes, self._space.choices,
            self._categorical, out,
        )  # fmt: skip
        return out
