"""The verbs of the ``mobo`` command, one module each."""
