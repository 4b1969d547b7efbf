"""How fast and how good: evaluation against its oracle, the sampler against Optuna's."""
