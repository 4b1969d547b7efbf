"""Arms that exist: their files read as they are found, a catalogue of them, and where they stand."""
