"""Write the API reference of mobo_core into build/docs/; what pdoc warns of is an error."""

from __future__ import annotations

import sys
import warnings
from pathlib import Path

import pdoc

import mobo_core

# Each room by name: of the package itself pdoc shows the public face alone, two rooms among it.
package = Path("mobo_core")
found = {path.stem for path in (*package.glob("*.py"), *(file.parent for file in package.glob("*/__init__.py")))}
rooms = [f"{package}.{name}" for name in sorted(found - {"__init__", *mobo_core.__all__})]
pdoc.render.configure(docformat="google", footer_text="mobo")
with warnings.catch_warnings(record=True) as caught:
    warnings.simplefilter("always")
    pdoc.pdoc(str(package), *rooms, output_directory=Path("build/docs"))
here = Path(pdoc.__file__).parent
told = [str(warning.message) for warning in caught if here in Path(warning.filename).parents]
print(*told, f"build/docs/index.html: {len(told)} warnings", sep="\n")
sys.exit(1 if told else 0)
