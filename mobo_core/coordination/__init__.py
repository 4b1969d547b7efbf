"""Who does what: the optimizer, dispatch to evaluators, their answers, and the workers behind them."""
