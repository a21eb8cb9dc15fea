"""The status of every point of a sweep: words in memory, numbers with their meanings in files.

`grid.status == "converged"` must mean what it says, so datasets hold words; a million of them take
8 MB, because equal words are one object. In a file a status is a byte, and the attributes
``flag_values`` and ``flag_meanings`` of the CF conventions say what it means.
"""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from latolato.core.errors import InputError
from latolato.numerics.records import EVENT_LIMIT, STATUS_NAMES
from latolato.sweeps.chunk import STATUS

if TYPE_CHECKING:
    import xarray as xr

# The word of a point that is not computed yet, whose number is -1.
MISSING = "missing"
FLAGS = {"flag_values": list(range(len(STATUS_NAMES))), "flag_meanings": " ".join(STATUS_NAMES)}
_CODES = {**{name: code for code, name in enumerate(STATUS_NAMES)}, MISSING: -1}
# As tables of earlier versions have them.
_OLDER = {str(code): code for code in _CODES.values()}


def codes_of(status: Any) -> NDArray[np.int8]:
    """Return the numbers that words stand for, in the shape of the words.

    Raises
    ------
    InputError
        For a word that is no status.
    """
    words = np.asarray(status)
    known = _CODES | _OLDER
    try:
        codes = [known[word] for word in words.ravel().tolist()]
    except KeyError as error:
        raise InputError(
            f"must be one of {', '.join(_CODES)}", parameter=STATUS, value=error.args[0]
        ) from None
    return np.array(codes, dtype=np.int8).reshape(words.shape)


def has_answer(status: Any) -> NDArray[np.bool_]:
    """Return the mask of points that have an answer, in the shape of the statuses."""
    codes = codes_of(status)
    return (codes >= 0) & (codes < EVENT_LIMIT)


def with_words(dataset: xr.Dataset, *, on_use: bool = False) -> xr.Dataset:
    """Return a dataset of numbers with the words of its status; without flags, as it is.

    Parameters
    ----------
    on_use : bool
        Whether the numbers are read from a file only where they are used.
    """
    import xarray as xr
    from xarray.core.indexing import CopyOnWriteArray, LazilyIndexedArray

    variable = dataset.variables.get(STATUS)
    if variable is None or "flag_meanings" not in variable.attrs:
        return dataset
    # One object for each word, whatever the file. The last one is that of -1.
    meanings = map(sys.intern, variable.attrs["flag_meanings"].split())
    words = np.array([*meanings, MISSING], dtype=object)
    attrs = {name: value for name, value in variable.attrs.items() if name not in FLAGS}
    data: Any
    if on_use:
        # xarray's types do not know that its own lazy arrays may be wrapped like this.
        lazy: Any = LazilyIndexedArray(_words_on_use(variable, words))
        data = CopyOnWriteArray(lazy)
    else:
        data = words[variable.values]
    # Else xarray looks through all words for dates, and makes each an object of its own.
    status = xr.Variable(variable.dims, data, attrs, fastpath=True)
    return dataset.assign({STATUS: status})


def with_codes(dataset: xr.Dataset) -> xr.Dataset:
    """Return a dataset of a sweep with the numbers of its status and their meanings."""
    variable = dataset.variables.get(STATUS)
    if "plan" not in dataset.attrs or variable is None or variable.dtype.kind not in "OU":
        return dataset
    codes = codes_of(variable.values)
    return dataset.assign({STATUS: (variable.dims, codes, {**variable.attrs, **FLAGS})})


def _words_on_use(numbers: xr.Variable, words: NDArray[Any]) -> Any:
    """Return an array of xarray's backends that turns numbers into words as they are read."""
    from xarray.backends import BackendArray
    from xarray.core.indexing import IndexingSupport, explicit_indexing_adapter

    class Words(BackendArray):
        shape, dtype = numbers.shape, words.dtype

        def __getitem__(self, key: Any) -> Any:
            return explicit_indexing_adapter(
                key, self.shape, IndexingSupport.OUTER, lambda part: words[numbers[part].values]
            )

    return Words()
