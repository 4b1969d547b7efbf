"""What an arm is worth: the question, the chain, the compiled kernel and its oracle."""

from mobo_core.evaluation.spec import DEFAULT_PRESET, PRESETS, EvaluationSpec, load_spec, with_ik

__all__ = ["DEFAULT_PRESET", "PRESETS", "EvaluationSpec", "load_spec", "with_ik"]
