"""Analyses as questions: in whose words they are asked, what their picture tells, and the verdict.

Each function of these modules says in one sentence what an analysis found; the decorator `asked`
gives the words in which the page asks for it. A test holds that every analysis has them.
"""

from __future__ import annotations

import importlib
from functools import lru_cache

from latolato.app.questions.asked import GROUPS, Question, questions
from latolato.app.questions.words import OPTION_WORDS

_MODULES = ("long_run", "beginning", "rest", "disturbance")


@lru_cache(maxsize=1)
def all_questions() -> dict[str, Question]:
    """Return the question of each analysis by its name, in the order in which a page lists them."""
    for name in _MODULES:
        importlib.import_module(f"{__name__}.{name}")
    return {
        name: question
        for group in GROUPS
        for name, question in questions.items()
        if question.group == group
    }


__all__ = ["GROUPS", "OPTION_WORDS", "Question", "all_questions", "questions"]
