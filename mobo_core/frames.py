"""Tables as pandas' data frames, where pandas is installed."""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from typing import TYPE_CHECKING

from mobo_core.errors import InputError

if TYPE_CHECKING:
    from pandas import DataFrame


def data_frame(columns: Mapping[str, object], index: str | None = None) -> DataFrame:
    """Return columns as a data frame; a value that is None is missing.

    Args:
        columns: name -> values, all of one length.
        index: name of the column that the rows are named by; None: they are numbered.

    Raises:
        InputError: pandas is not installed.
    """
    try:
        pandas = importlib.import_module("pandas")
    except ImportError:
        raise InputError("pandas is not installed", where="to_pandas()", expected="pip install pandas") from None
    frame: DataFrame = pandas.DataFrame(dict(columns))
    return frame if index is None else frame.set_index(index)
