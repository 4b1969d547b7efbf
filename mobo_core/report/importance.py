"""Which of the sampler's parameters matter for which objective: Optuna's own measure."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING

from mobo_core.bag.record import StudyRecord
from mobo_core.report.once import once
from mobo_core.report.optuna_trials import optuna_trials
from mobo_core.report.table import StudyTable

if TYPE_CHECKING:
    from collections.abc import Container

    from optuna.storages import InMemoryStorage
    from optuna.trial import FrozenTrial, TrialState

_MOST_TRIALS = 3000  # evenly chosen; Optuna's trials take time and memory
_FEWEST_TRIALS = 20


@once
def importances(study: StudyRecord, table: StudyTable) -> dict[str, dict[str, float]]:
    """Return objective -> parameter -> importance, a share of 1, the most important first; {} of a few trials.

    PED-ANOVA (Watanabe, Bansal and Hutter, IJCAI 2023) as Optuna has it: how far the distribution of a parameter among
    the best tenth of trials is from that among all. Parameters whose range depends on others are left out.
    """
    import optuna
    from optuna.importance import PedAnovaImportanceEvaluator, get_param_importances

    trials = optuna_trials(study, table.complete[:: max(1, -(-len(table.complete) // _MOST_TRIALS))])
    if len(trials) < _FEWEST_TRIALS:
        return {}
    found: dict[str, dict[str, float]] = {}
    before = optuna.logging.get_verbosity()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # experimental, says Optuna
        optuna.logging.set_verbosity(optuna.logging.ERROR)
        try:
            made = optuna.create_study(storage=_held(trials), directions=["minimize"] * len(table.aims))
            for k, (name, aim) in enumerate(zip(study.settings.objectives, table.aims, strict=True)):
                sign = -1.0 if aim.maximize else 1.0

                def loss(trial: FrozenTrial, k: int = k, sign: float = sign) -> float:
                    return sign * float(trial.values[k])

                measure = PedAnovaImportanceEvaluator()
                try:
                    found[name] = dict(get_param_importances(made, evaluator=measure, target=loss))
                except (ValueError, RuntimeError):  # no parameter that all trials share, say
                    continue
        finally:
            optuna.logging.set_verbosity(before)
    return {name: values for name, values in found.items() if values}


def _held(trials: list[FrozenTrial]) -> InMemoryStorage:
    """Return a storage of these trials as they are: Optuna's own would copy each, which takes longer than all else."""
    from optuna.storages import InMemoryStorage

    class Held(InMemoryStorage):
        def get_all_trials(
            self, study_id: int, deepcopy: bool = True, states: Container[TrialState] | None = None
        ) -> list[FrozenTrial]:
            return [trial for trial in trials if states is None or trial.state in states]

    for number, trial in enumerate(trials):
        trial.number = number
    return Held()
