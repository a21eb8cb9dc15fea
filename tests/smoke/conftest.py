"""Everything once, as a user would: each case leaves a line in a table of answers."""

from collections.abc import Callable
from typing import Any

import pytest

from app_pages import anchor, browser, page, server, watch

__all__ = ["anchor", "browser", "page", "server", "watch"]

_WIDTH = 110


@pytest.fixture
def answer(record_property: Callable[[str, object], None]) -> Callable[[str], None]:
    """Record what a case answered; a case without an answer fails."""

    def record(text: str) -> None:
        text = " ".join(text.split())
        assert text, "there is neither an answer nor a reason"
        record_property("answer", text)

    return record


def pytest_terminal_summary(terminalreporter: Any) -> None:
    """Print the table of answers."""
    reports = [
        report
        for outcome in ("passed", "failed", "error")
        for report in terminalreporter.stats.get(outcome, [])
        if report.when == "call" and "smoke" in report.nodeid
    ]
    terminalreporter.section("what everything answered")
    for report in sorted(reports, key=lambda report: report.nodeid):
        case = report.nodeid.split("::")[-1].removeprefix("test_")
        said = dict(report.user_properties).get("answer", "")
        mark = "ok  " if report.passed else "FAIL"
        line = f"{mark} {report.duration:6.1f} s  {case:58} {said}"
        terminalreporter.write_line(line[: _WIDTH + 70])
