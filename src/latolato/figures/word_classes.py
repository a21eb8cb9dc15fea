"""Contact words as classes of a map: which words there are, their places and their colours."""

from __future__ import annotations

from collections import Counter
from typing import Any

import numpy as np

from latolato.figures import style
from latolato.observables import contact_words

# Words whose colour is the same in every map.
KNOWN: dict[float, tuple[str, str]] = {
    code: (str(contact_words(code)), colour)
    for code, colour in {
        1.0: style.PALE_GREY, 6.0: style.PALE_BLUE, 4.0: style.BLUE, 17.0: style.ORANGE,
        0.0: style.RED,
    }.items()
}  # fmt: skip
# The commonest of the others have these, the rest share one.
FURTHER = (style.GREEN, style.SKY, style.INK, style.PALE_RED)
REST = ("other words", style.FAINT)
# The classes without those of one map.
USUAL = dict([*KNOWN.values(), REST])


def classes_of(codes: Any) -> tuple[dict[str, str], Any]:
    """Return the words of a map with their colours, and the place of each cell's word among them.

    All words that have a colour of their own in every map come first, then the commonest of the
    others, of equally common ones that with the least code, then all further ones together.

    Parameters
    ----------
    codes : ndarray
        Of words; NaN without any.

    Returns
    -------
    classes : dict
        Words and colours.
    places : ndarray
        In the shape of the codes, NaN where they are.
    """
    found = Counter(code for code in codes[~np.isnan(codes)].tolist() if code not in KNOWN)
    common = sorted(found, key=lambda code: (-found[code], code))
    classes = {code: entry for code, entry in KNOWN.items() if (codes == code).any()}
    for code, colour in zip(common, FURTHER, strict=False):
        classes[code] = str(contact_words(code)), colour
    place = {code: float(number) for number, code in enumerate(classes)}
    shown = dict(classes.values())
    if len(common) > len(FURTHER):
        shown[REST[0]] = REST[1]
    last = float(len(classes))
    places = [np.nan if code != code else place.get(code, last) for code in codes.ravel().tolist()]
    return shown, np.reshape(places, codes.shape)
