"""Sentences of measurements: each is said somewhere, with what stands in its gaps."""

import ast
import re
from pathlib import Path

import pytest

import latolato
from latolato.experiment.rules import RULES

FOLDER = Path(latolato.__file__).parent
TREES = [
    ast.parse(path.read_text("utf-8"))
    for part in ("experiment", "app/experiment")
    for path in (FOLDER / part).rglob("*.py")
    if path.name != "rules.py"
]
NODES = [node for tree in TREES for node in ast.walk(tree)]
CALLS = [
    node
    for node in NODES
    if isinstance(node, ast.Call) and getattr(node.func, "id", "") in ("said", "broken")
]


def gaps_of(name):
    return set(re.findall(r"\{(\w+)", " ".join(RULES[name])))


def names_in(node):
    """Return the names that a call may choose from, none where they are made elsewhere."""
    if isinstance(node, ast.IfExp):
        return [*names_in(node.body), *names_in(node.orelse)]
    return [node.value] if isinstance(node, ast.Constant) else []


def values_of(call):
    """Return the gaps that a call fills, None where they are made elsewhere."""
    if call.func.id == "said":
        names = [keyword.arg for keyword in call.keywords]
    elif len(call.args) < 2:
        names = []
    else:
        keys = getattr(call.args[1], "keys", [None])
        names = [key and getattr(key, "value", None) for key in keys]
    return None if None in names else set(names)


@pytest.mark.parametrize("call", CALLS, ids=lambda call: ast.unparse(call)[:60])
def test_a_call_names_a_rule_and_fills_its_gaps(call):
    for name in names_in(call.args[0]):
        assert name in RULES
        if (values := values_of(call)) is not None:
            assert values >= gaps_of(name)


def test_every_rule_is_said():
    texts = [node.value for node in NODES if isinstance(node, ast.Constant)]
    # Names such as f"unsteady_{which}".
    begun = tuple(
        node.values[0].value
        for node in NODES
        if isinstance(node, ast.JoinedStr) and isinstance(node.values[0], ast.Constant)
        if str(node.values[0].value).endswith("_")
    )
    assert [name for name in RULES if name not in texts and not name.startswith(begun)] == []
