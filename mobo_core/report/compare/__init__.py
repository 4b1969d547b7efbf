"""Studies side by side: settings, fronts, hypervolume, structures."""
