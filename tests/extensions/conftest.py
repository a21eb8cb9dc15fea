"""Laws that a test adds are known to everything that is made from the registries."""

import pytest

from latolato.app import forms
from latolato.app.analyse import forms as analysis_forms
from latolato.scenario.options import law_options

# Files of an analysis, which its test puts in their places.
collect_ignore = ["analysis", "figures"]

# What is made once, from the laws that are registered then.
MADE_ONCE = (
    law_options,
    forms._registry,
    analysis_forms.forms,
)


@pytest.fixture
def forget():
    """Return a function that makes options and forms anew; it is called at the end, too."""

    def clear():
        for made in MADE_ONCE:
            made.cache_clear()

    yield clear
    clear()
