"""Print the share of lines that the tests ran, by room of mobo_core, from the file .coverage."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

from coverage import Coverage

measured = Coverage()
measured.load()
lines: Counter[str] = Counter()
missed: Counter[str] = Counter()
package = Path("mobo_core").resolve()
for file in sorted(package.rglob("*.py")):
    room = file.relative_to(package).parts[0].removesuffix(".py")
    _, statements, _, missing, _ = measured.analysis2(str(file))
    for name in (room, "all"):
        lines[name] += len(statements)
        missed[name] += len(missing)
for room, count in sorted(lines.items(), key=lambda item: (item[0] == "all", item[0])):
    if count:
        print(f"{room:14} {count:6} lines {100 * (1 - missed[room] / count):6.1f} %")
print("What Numba compiled was not watched: its lines count as not run (evaluation/kernel, jit, search/samplers/tpe).")
