"""Verdicts follow from numbers and limits, on either side of each limit of each statement."""

import math

import pytest

from latolato.paper import catalogue
from latolato.paper.claim import Limit, Statement, Verdict, read_statements

STATEMENTS = {s.name: s for each in catalogue.evidence().values() for s in each.statements}


PRINTED = [s for s in STATEMENTS.values() if s.printed]
ASSUMED = [s for s in STATEMENTS.values() if s.assumed and not s.is_method_check]
METHOD = [s for s in STATEMENTS.values() if s.is_method_check]


def each(statements):
    """A test for each statement, called by its name."""
    return pytest.mark.parametrize("statement", statements, ids=lambda s: s.name)


def inside(limits):
    """A value for each number that keeps all limits on it."""
    values = {}
    for name in {limit.number for limit in limits}:
        low = max(limit.low for limit in limits if limit.number == name)
        high = min(limit.high for limit in limits if limit.number == name)
        assert low <= high, f"the limits on {name} contradict each other"
        if low == -math.inf:
            values[name] = high
        elif high == math.inf:
            values[name] = low
        else:
            values[name] = 0.5 * (low + high)
    return values


def outside(limit):
    """Values just beyond each finite end of a limit."""
    ends = []
    if limit.low > -math.inf:
        ends.append(math.nextafter(limit.low, -math.inf))
    if limit.high < math.inf:
        ends.append(math.nextafter(limit.high, math.inf))
    return ends


@each(STATEMENTS.values())
def test_each_limit_has_two_sides(statement):
    for limit in statement.limits:
        assert outside(limit), f"{limit.number} is not limited"
        for value in outside(limit):
            assert not limit.holds({limit.number: value})
        for end in (limit.low, limit.high):
            if math.isfinite(end):
                assert limit.holds({limit.number: end})
        assert not limit.holds({limit.number: math.nan})


@each(PRINTED)
def test_a_statement_is_reproduced_only_if_all_printed_limits_hold(statement):
    numbers = inside(statement.printed)
    others = {limit.number: math.nan for limit in statement.assumed} | numbers
    assert statement.verdict(others) is Verdict.REPRODUCED
    for limit in statement.printed:
        for value in outside(limit):
            assert statement.verdict(others | {limit.number: value}) is Verdict.NOT_AS_PRINTED


@each(ASSUMED)
def test_a_statement_needs_its_assumption_if_only_the_assumed_limits_hold(statement):
    numbers = {limit.number: math.nan for limit in statement.printed} | inside(statement.assumed)
    assert statement.verdict(numbers) is Verdict.ASSUMED
    for limit in statement.assumed:
        for value in outside(limit):
            assert statement.verdict(numbers | {limit.number: value}) is Verdict.NOT_AS_PRINTED


def test_what_the_paper_does_not_print_is_never_counted_as_reproduced():
    chain = {f"fig{number}-chain" for number in (7, 8, 9, 10, 11, 12)}
    assert {s.name for s in METHOD} == chain | {"threshold-of-fig-8"}
    for statement in METHOD:
        held = inside(statement.assumed)
        assert statement.verdict(held) is Verdict.METHOD_CHECK
        assert statement.verdict(dict.fromkeys(held, math.nan)) is Verdict.METHOD_CHECK
        assert "measured" not in statement.finding.replace("{measured", "")


@each(STATEMENTS.values())
def test_a_finding_is_a_sentence_that_stands_alone(statement):
    first = statement.finding.split()[0]
    assert first[0].isupper() or first.startswith("{")
    assert first not in ("It", "They", "This", "These", "Those", "Both", "Pushed,", "Up")
    assert statement.finding.count(". ") - statement.finding.count("Fig. ") == (
        statement.finding.count("Figs. ")
    )
    assert statement.finding.endswith(".")


def test_a_method_check_has_no_printed_limits():
    limit = (Limit("x", "x", low=0.0),)
    with pytest.raises(ValueError, match="is a method check: no limit can be printed"):
        Statement(
            name="half",
            where="",
            words="",
            finding="",
            why="",
            printed=limit,
            assumed=limit,
            assumption="so",
            is_method_check=True,
        )


def test_a_statement_without_limits_is_refused():
    with pytest.raises(ValueError, match="needs at least one limit"):
        Statement(name="empty", where="", words="", finding="", why="")


@pytest.mark.parametrize("assumption, assumed", [("so", ()), ("", (Limit("x", "x", low=0.0),))])
def test_assumption_and_assumed_limits_come_together(assumption, assumed):
    with pytest.raises(ValueError, match="both assumed limits and an assumption"):
        Statement(
            name="half",
            where="",
            words="",
            finding="",
            why="",
            printed=(Limit("x", "x", low=0.0),),
            assumed=assumed,
            assumption=assumption,
        )


@pytest.mark.parametrize(
    "limit, text",
    [
        (Limit("x", "size", high=0.01), "size: 0.5 (at most 0.01)"),
        (Limit("x", "size", low=3.0, unit="rad"), "size: 0.5 rad (at least 3 rad)"),
        (Limit("x", "size", 1.0, 2.0, "m/s^2"), "size: 0.5 m/s² (1 to 2 m/s²)"),
    ],
)
def test_a_limit_is_reported_beside_its_number(limit, text):
    assert limit.report({"x": 0.5}) == text


CLAIM = """
[fig14.never-far]
where = "Fig. 14"
words = '''
two lines
of text'''
printed.largest = { meaning = "largest angle", high = 0.1, unit = "rad" }
finding = "It reaches {largest:.3f} rad."
why = "So."
"""


@pytest.fixture
def claims(tmp_path):
    """Write a file of claims and return its path."""

    def write(text):
        path = tmp_path / "claims.toml"
        path.write_text(text, encoding="utf-8")
        return path

    return write


def test_a_claim_is_read_from_its_table(claims):
    ((statement,),) = read_statements(claims(CLAIM)).values()
    assert statement == Statement(
        name="never-far",
        where="Fig. 14",
        words="two lines of text",
        printed=(Limit("largest", "largest angle", high=0.1, unit="rad"),),
        finding="It reaches {largest:.3f} rad.",
        why="So.",
    )


@pytest.mark.parametrize(
    "line, other, message",
    [
        ("why =", "wy =", r"fig14\.never-far has no key 'wy'.*'why'"),
        ('why = "So."', "", r"fig14\.never-far lacks the key 'why'"),
        ("high =", "most =", r"fig14\.never-far\.printed\.largest has no key 'most'"),
        ("high = 0.1", 'high = "0.1"', r"printed\.largest: high must be a float, got '0\.1'"),
        ("high = 0.1, ", "", "limit on 'largest' needs a low or a high end"),
        ("high = 0.1", "high = 0.1, low = 0.2", "limit on 'largest' needs a low or a high end"),
        ('meaning = "largest angle", ', "", r"printed\.largest lacks the key 'meaning'"),
        ("printed.largest", "# printed.largest", "'never-far' needs at least one limit"),
        ("printed.largest", "assumed.largest", "both assumed limits and an assumption"),
        ("why =", "is_method_check = true\nwhy =", "is a method check"),
    ],
)
def test_a_claim_that_is_incomplete_or_unknown_is_refused(claims, line, other, message):
    assert CLAIM.count(line) == 1
    with pytest.raises(ValueError, match=message):
        read_statements(claims(CLAIM.replace(line, other)))


def test_claims_of_a_figure_that_does_not_exist_are_refused(claims, monkeypatch):
    path = claims(CLAIM.replace("fig14", "fig1"))
    monkeypatch.setattr(catalogue, "claims_of", lambda paper: path)
    with pytest.raises(ValueError, match="no figure 'fig1', did you mean 'fig01'"):
        catalogue.evidence()
