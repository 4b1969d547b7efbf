"""The paper's claims, each a check with numbers, margin, interval and verdict."""
