"""Which evaluator a trial goes to, and when to a second one: by how fast they are.

The fastest come first, by a factor of two, then those where most places are free.

**Stragglers.** An ordered study soon waits for its oldest open trial, and at its end for the last one. So when nothing
waits and a place is free (whoever calls has then opened all the trials it may), a trial that has been out for longer
than 1 s and twice what an idle evaluator typically takes (the median of its latest answers) goes to that one too, the
oldest trial first.
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


def best_place(fit: list[str], free: Mapping[str, int], evaluators: Mapping[str, LiveEvaluator]) -> str:
    """Return which of the evaluators ``fit``, with so many places ``free``, gets a trial."""
    times = {name: max(_JITTER_S, _typical_s(name, evaluators)) for name in fit}
    fastest = min(times.values())
    slower = {name: int(math.log2(times[name] / fastest)) if math.isfinite(fastest) else 0 for name in fit}
    return min(fit, key=lambda name: (slower[name], -free[name], name))


def is_straggler(trial: OpenTrial, idle: str, evaluators: Mapping[str, LiveEvaluator], now: float) -> bool:
    """Return whether a trial shall go to an idle evaluator too."""
    if not 0 < len(trial.leases) < _MAX_LEASES:
        return False
    asked = {lease.dispatch.evaluator for lease in trial.leases.values()} | trial.failed_on() | trial.unable
    since = min(lease.since for lease in trial.leases.values())
    patience_s = max(_STRAGGLER_S, _STRAGGLER_FACTOR * _typical_s(idle, evaluators))
    return idle not in asked and now - since > patience_s


def _typical_s(name: str, evaluators: Mapping[str, LiveEvaluator]) -> float:
    """Return what an evaluation takes on an evaluator, or on the median one if it has not answered yet."""
    own = evaluators[name].typical_s
    if not math.isnan(own):
        return own
    known = [e.typical_s for e in evaluators.values() if not math.isnan(e.typical_s)]
    return median(known) if known else math.inf
