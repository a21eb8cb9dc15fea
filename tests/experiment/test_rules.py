"""Sentences of measurements and tables: each is said somewhere, with what stands in its gaps."""

import ast
import re
from pathlib import Path

import pytest

import latolato
from latolato.experiment.rules import RULES
from latolato.io.tables.rules import RULES as OF_TABLES

FOLDER = Path(latolato.__file__).parent


def nodes_of(*folders):
    """Return what code consists of, without the tables of the rules."""
    paths = [path for part in folders for path in (FOLDER / part).rglob("*.py")]
    parts = [part for path in paths for part in ast.parse(path.read_text("utf-8")).body]
    return [node for part in parts if not is_table(part) for node in ast.walk(part)]


def is_table(part):
    return isinstance(part, ast.Assign) and ast.unparse(part.targets[0]) == "RULES"


# Rules, and the code that says them.
TABLES = {
    "experiment": (RULES, nodes_of("experiment", "app/experiment")),
    "tables": (OF_TABLES, nodes_of("io/tables")),
}
CALLS = [
    (rules, node)
    for rules, nodes in TABLES.values()
    for node in nodes
    if isinstance(node, ast.Call) and getattr(node.func, "id", "") in ("said", "broken")
]


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


@pytest.mark.parametrize("rules, call", CALLS, ids=[ast.unparse(call)[:60] for _, call in CALLS])
def test_a_call_names_a_rule_and_fills_its_gaps(rules, call):
    for name in names_in(call.args[0]):
        assert name in rules
        if (values := values_of(call)) is not None:
            gaps = set(re.findall(r"\{(\w+)", " ".join(rules[name])))
            assert values >= gaps - {"parameter"}


@pytest.mark.parametrize("table", TABLES)
def test_every_rule_is_said(table):
    rules, nodes = TABLES[table]
    texts = [node.value for node in nodes if isinstance(node, ast.Constant)]
    # Names such as f"unsteady_{which}".
    begun = tuple(
        node.values[0].value
        for node in nodes
        if isinstance(node, ast.JoinedStr) and isinstance(node.values[0], ast.Constant)
        if str(node.values[0].value).endswith("_")
    )
    assert [name for name in rules if name not in texts and not name.startswith(begun)] == []


def test_no_sentence_claims_that_somebody_pointed():
    # Pivots and balls may have been found. Only the ends of a stick are always pointed at.
    claims = re.compile(r"\bclick|pointed at|point at .*again")
    said = {name: " ".join(re.sub(r"\{@\w+", "", text) for text in RULES[name]) for name in RULES}
    assert [name for name, text in said.items() if claims.search(text)] == ["short_stick"]
