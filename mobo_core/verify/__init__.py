"""Whether a bag says the truth."""
