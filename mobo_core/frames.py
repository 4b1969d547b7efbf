"""Tables as pandas' data frames, where pandas is installed."""

from __future__ import annotations

import importlib
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from mobo_core.errors import InputError

if TYPE_CHECKING:
    from pandas import DataFrame


def data_frame(columns: Mapping[str, Sequence[object]], index: str) -> DataFrame:
    """Return columns as a data frame; a value that is None is missing.

    Args:
        columns: name -> values, all of one length.
        index: name of the column that the rows are named by.

    Raises:
        InputError: pandas is not installed.
    """
    try:
        pandas = importlib.import_module("pandas")
    except ImportError:
        raise InputError("needs pandas", where="to_pandas", expected="pip install pandas, or to_dict") from None
    frame: DataFrame = pandas.DataFrame(dict(columns)).set_index(index)
    return frame
