"""The report as one HTML page with everything in it."""
