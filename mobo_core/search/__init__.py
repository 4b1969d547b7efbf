"""Which arm comes next: samplers, the ordered study, dispatch to evaluators."""
