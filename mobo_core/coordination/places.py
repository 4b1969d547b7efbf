"""Which evaluator a trial goes to, and when to a second one: by how fast they are.

The fastest come first, by a factor of two, then those where most places are free.

**Stragglers.** An ordered study soon waits for its oldest open trial, and at its end for the last one. So when nothing
waits and a place is free (whoever calls has then opened all the trials it may), a trial that has been out for longer
than 1 s and twice what an idle evaluator typically takes (the median of its latest answers) goes to that one too, the
oldest trial first.

**Evaluators that never answer.** Who was sent much and answered nothing comes last. While nobody has answered, a
trial that has been out for two minutes is a straggler too, or for 5 s if many evaluators are idle. If two have it of
whom neither ever answered, a third takes the place of the first: one that has answered, or else the one that was sent
the fewest, and joined first or last in turn. So two hundred names with nothing behind them do not stop a study.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from statistics import median

from mobo_core.coordination.leases import LiveEvaluator, OpenTrial

# A trial is with so many evaluators at a time, at most.
_MAX_LEASES = 2
# Evaluations faster than this do not differ: messages take as long.
_JITTER_S = 0.05
# A straggler has been out for so many times what an idle evaluator takes, and for so many seconds.
_STRAGGLER_FACTOR = 2.0
_STRAGGLER_S = 1.0
# So long those are waited for of whom nobody knows whether they answer; so many sendings make no difference yet.
_UNPROVEN_S, _UNPROVEN_OF_MANY_S, _MANY = 120.0, 5.0, 8
_FEW_UNANSWERED = 8


def best_place(fit: list[str], free: Mapping[str, int], evaluators: Mapping[str, LiveEvaluator]) -> str:
    """Return which of the evaluators ``fit``, with so many places ``free``, gets a trial."""
    times = {name: max(_JITTER_S, _typical_s(name, evaluators)) for name in fit}
    fastest = min(times.values())
    slower = {name: int(math.log2(times[name] / fastest)) if math.isfinite(fastest) else 0 for name in fit}
    late = {name: evaluators[name].unanswered // _FEW_UNANSWERED for name in fit}
    return min(fit, key=lambda name: (late[name], slower[name], -free[name], name))


def best_probe(trial: int, fit: list[str], evaluators: Mapping[str, LiveEvaluator]) -> str:
    """Return which of the evaluators ``fit`` gets a trial that only such have as never answered."""
    last_first = -1 if trial % 2 else 1

    def rank(name: str) -> tuple[bool, int, int]:
        known = evaluators[name]
        return not known.is_proven, known.unanswered, last_first * known.joined

    return min(fit, key=rank)


def is_held_in_vain(trial: OpenTrial, evaluators: Mapping[str, LiveEvaluator]) -> bool:
    """Return whether all evaluators that have a trial never answered anything."""
    return not any(evaluators[lease.dispatch.evaluator].is_proven for lease in trial.leases.values())


def is_straggler(
    trial: OpenTrial, idle: str, evaluators: Mapping[str, LiveEvaluator], now: float, n_idle: int = 1
) -> bool:
    """Return whether a trial shall go to an idle evaluator too, one of ``n_idle``."""
    unproven_s = _UNPROVEN_OF_MANY_S if n_idle >= _MANY else _UNPROVEN_S
    if not trial.leases:
        return False
    if len(trial.leases) >= _MAX_LEASES:
        last = max(lease.since for lease in trial.leases.values())
        waited = now - last > (_STRAGGLER_S if evaluators[idle].is_proven else unproven_s)
        if not waited or not is_held_in_vain(trial, evaluators):
            return False
    asked = {lease.dispatch.evaluator for lease in trial.leases.values()} | trial.failed_on() | trial.unable
    since = min(lease.since for lease in trial.leases.values())
    typical_s = _typical_s(idle, evaluators)
    patience_s = max(_STRAGGLER_S, _STRAGGLER_FACTOR * typical_s) if math.isfinite(typical_s) else unproven_s
    return idle not in asked and now - since > patience_s


def _typical_s(name: str, evaluators: Mapping[str, LiveEvaluator]) -> float:
    """Return what an evaluation takes on an evaluator, or on the median one if it has not answered yet."""
    own = evaluators[name].typical_s
    if not math.isnan(own):
        return own
    known = [e.typical_s for e in evaluators.values() if not math.isnan(e.typical_s)]
    return median(known) if known else math.inf
