"""Pattern files: how the lines of somebody else's log become events of a specification.

A file in TOML::

    format = "log"                       # or "csv" (the first line has the names), or "json" (an object a line)
    time = "t"                           # the field with the time, if there is one
    [[event]]
    match = "DRIVE (?P<who>[a-z]+)"      # a line of a log; its named groups are fields
    event = "drive.{who}"
    [[event]]
    when = { topic = "/cmd", mode = "[0-9]+" }    # fields of a CSV or of JSON, `a.b` inside of JSON
    event = "request.{mode}"
    [values]
    auto = "Autoware"                    # what a value is called in the specification

The first ``[[event]]`` that matches a line counts; a line that none matches is no event.
"""

from __future__ import annotations

import csv
import json
import re
import tomllib
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.messages import cannot_read, wrong_pattern, wrong_record
from cspcheck.runs import RecordedEvent

_FIELD = re.compile(r"\{([A-Za-z_][\w.]*)\}")
FORMATS = ("log", "csv", "json")


@dataclass(frozen=True, slots=True)
class LineRule:
    """Which lines are an event, and which event they are."""

    event: str
    match: re.Pattern[str] | None
    when: Mapping[str, re.Pattern[str]]


@dataclass(frozen=True, slots=True)
class PatternFile:
    """What a pattern file says."""

    name: str
    format: str
    rules: tuple[LineRule, ...]
    values: Mapping[str, str]
    time: str | None

    def records(self, lines: Iterable[str], name: str) -> Iterator[tuple[int, RecordedEvent]]:
        """The events in the lines of a file, with the numbers of their lines.

        Raises:
            ScriptError: a line is not of the format, or an event needs a field that it does not have.
        """
        for number, line, fields in self._rows(lines, name):
            for rule in self.rules:
                found = dict(fields)
                if rule.match is not None:
                    match = rule.match.search(line)
                    if match is None:
                        continue
                    found.update({key: value for key, value in match.groupdict().items() if value is not None})
                if all(key in found and test.fullmatch(found[key]) for key, test in rule.when.items()):
                    yield number, RecordedEvent(self._event(rule, found, name, number), False, self._time(found), None)
                    break

    def _rows(self, lines: Iterable[str], name: str) -> Iterator[tuple[int, str, dict[str, str]]]:
        if self.format == "csv":
            reader = csv.DictReader(lines)
            for row in reader:
                fields = {str(key): value for key, value in row.items() if isinstance(value, str)}
                yield reader.line_num, ",".join(fields.values()), fields
            return
        for number, line in enumerate(lines, 1):
            if not line.strip():
                continue
            if self.format == "log":
                yield number, line, {}
                continue
            try:
                found: Any = json.loads(line)
            except (ValueError, RecursionError):
                raise ScriptError(wrong_record(name, number, "it is no JSON")) from None
            yield number, line, dict(_flat(found, ""))

    def _event(self, rule: LineRule, fields: Mapping[str, str], name: str, number: int) -> str:
        def value(match: re.Match[str]) -> str:
            if match[1] not in fields:
                raise ScriptError(wrong_record(name, number, f"`{rule.event}` needs a field `{match[1]}`"))
            text = fields[match[1]]
            return self.values.get(text, text)

        return _FIELD.sub(value, rule.event)

    def _time(self, fields: Mapping[str, str]) -> float | None:
        try:
            return None if self.time is None else float(fields[self.time])
        except (KeyError, ValueError):
            return None


def _flat(value: Any, prefix: str) -> Iterator[tuple[str, str]]:
    """The fields of a value of JSON, those inside by their path; truth values as the language writes them."""
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from _flat(inner, f"{prefix}.{key}" if prefix else str(key))
    elif isinstance(value, bool):
        yield prefix, "true" if value else "false"
    elif isinstance(value, (str, int, float)):
        yield prefix, str(value)


def read_pattern(path: str) -> PatternFile:
    """The pattern file of this name.

    Raises:
        ScriptError: it cannot be read, or is wrong.
    """
    try:
        with open(path, "rb") as file:
            found = tomllib.load(file)
    except OSError as error:
        raise ScriptError(cannot_read(path, error.strerror or str(error))) from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError, RecursionError) as error:
        raise ScriptError(wrong_pattern(path, f"it is no TOML: {error}")) from None
    form = found.get("format", "log")
    if form not in FORMATS:
        raise ScriptError(wrong_pattern(path, f"`format` is one of {', '.join(FORMATS)}"))
    unknown = found.keys() - {"format", "time", "event", "values"}
    if unknown:
        raise ScriptError(wrong_pattern(path, f"there is no setting `{min(unknown)}`"))
    rows, values = found.get("event", []), found.get("values", {})
    if not isinstance(rows, list) or not rows or not isinstance(values, dict):
        raise ScriptError(wrong_pattern(path, "it has no `[[event]]`"))
    time = found.get("time")
    rules = tuple(_rule(path, row) for row in rows)
    renamed = {str(key): str(value) for key, value in values.items()}
    return PatternFile(path, form, rules, renamed, None if time is None else str(time))


def _rule(path: str, row: Any) -> LineRule:
    if not isinstance(row, dict) or not isinstance(row.get("event"), str):
        raise ScriptError(wrong_pattern(path, "an `[[event]]` has no text `event`"))
    when = row.get("when", {})
    if not isinstance(when, dict) or row.keys() - {"event", "match", "when"}:
        raise ScriptError(wrong_pattern(path, "an `[[event]]` has `event`, `match` and `when`, and nothing else"))
    try:
        match = None if "match" not in row else re.compile(str(row["match"]))
        tests = {str(key): re.compile(str(test)) for key, test in when.items()}
    except re.error as error:
        raise ScriptError(wrong_pattern(path, f"{error.pattern!r} is no regular expression: {error.msg}")) from None
    return LineRule(row["event"], match, tests)
