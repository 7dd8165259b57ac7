"""The JSON Schemas (draft 2020-12) of everything that is written for programs.

They are strict: every key is named and required, so that a document with a key too many or too few is told. New keys
come with a new version of the schema's name.
"""

from __future__ import annotations

from typing import Any, Final

_DRAFT: Final = "https://json-schema.org/draft/2020-12/schema"

Schema = dict[str, Any]


def _object(properties: Schema, *, optional: tuple[str, ...] = ()) -> Schema:
    required = [name for name in properties if name not in optional]
    return {"type": "object", "properties": properties, "required": required, "additionalProperties": False}


def _list(items: Schema) -> Schema:
    return {"type": "array", "items": items}


def _or_null(schema: Schema) -> Schema:
    return {"anyOf": [schema, {"type": "null"}]}


def _one_of(*values: str) -> Schema:
    return {"enum": list(values)}


TEXT: Final[Schema] = {"type": "string"}
NUMBER: Final[Schema] = {"type": "integer", "minimum": 0}
SECONDS: Final[Schema] = {"type": "number", "minimum": 0}
FLAG: Final[Schema] = {"type": "boolean"}
TEXTS: Final = _list(TEXT)
MAYBE_TEXT: Final = _or_null(TEXT)
MAYBE_TEXTS: Final = _or_null(TEXTS)
MAYBE_NUMBER: Final = _or_null(NUMBER)
VERDICT: Final = _one_of("pass", "fail", "unknown", "error")
TEXTS_BY_NAME: Final[Schema] = {"type": "object", "additionalProperties": TEXT}
LINES: Final = _list(_object({"line": NUMBER, "text": TEXT}))

COMPONENT: Final = _object(
    {
        "name": TEXT,
        "trace": _list(MAYBE_TEXT),
        "state": TEXT,
        "line": MAYBE_NUMBER,
        "offers": TEXTS,
        "waiting_for": TEXTS,
        "variables": _or_null(TEXTS_BY_NAME),
        "changes": _or_null(_list(_or_null(TEXTS_BY_NAME))),
    }
)
OBLIGATION: Final = _object(
    {
        "name": TEXT,
        "subject": TEXT,
        "operation": MAYBE_TEXT,
        "message": TEXT,
        "line": MAYBE_NUMBER,
        "failing": MAYBE_TEXT,
        "lines": LINES,
        "others": TEXTS,
    }
)
COUNTEREXAMPLE: Final = _object(
    {
        "kind": _one_of("trace", "refusal", "deadlock", "divergence", "nondeterminism", "obligation"),
        "trace": TEXTS,
        "event": MAYBE_TEXT,
        "refusal": MAYBE_TEXTS,
        "allowed": _or_null(_list(TEXTS)),
        "loop": MAYBE_TEXTS,
        "components": _list(COMPONENT),
        "values": _or_null(TEXTS_BY_NAME),
        "obligation": _or_null(OBLIGATION),
        "causes": _list(MAYBE_TEXT),
        "offered": MAYBE_TEXTS,
        "refusals": _or_null(_list(MAYBE_TEXTS)),
        "waiting_cycle": MAYBE_TEXTS,
        "specification": _or_null(_object({"trace": TEXTS, "causes": _list(MAYBE_TEXT), "states": TEXTS})),
    }
)
COVERAGE: Final = _object(
    {
        "prefixes": NUMBER,
        "performed": NUMBER,
        "never": _list(
            _object(
                {
                    "kind": TEXT,
                    "text": TEXT,
                    "why": MAYBE_TEXT,
                    "file": MAYBE_TEXT,
                    "line": MAYBE_NUMBER,
                    "column": MAYBE_NUMBER,
                }
            )
        ),
    }
)
EVERY_SIZE: Final = _object(
    {
        "type": TEXT,
        "size": NUMBER,
        "sufficient": NUMBER,
        "same_from": MAYBE_NUMBER,
        "compared": FLAG,
        "held": MAYBE_NUMBER,
        "new": MAYBE_NUMBER,
    }
)
_RESULT: Final[Schema] = {
    "file": TEXT,
    "line": NUMBER,
    "assertion": TEXT,
    "kind": TEXT,
    "model": _or_null(_one_of("T", "F", "FD", "V", "VD", "R", "RD")),
    "verdict": VERDICT,
    "expected": VERDICT,
    "reason": MAYBE_TEXT,
    "states": NUMBER,
    "transitions": NUMBER,
    "seconds": SECONDS,
    "peak_memory_bytes": NUMBER,
    "counterexample": _or_null(COUNTEREXAMPLE),
    "readings": TEXTS,
    "view": _one_of("control"),
    "every_size": _list(EVERY_SIZE),
    "reduction": _one_of("partial order"),
    "coverage": COVERAGE,
}
_DIAGNOSTIC: Final[Schema] = {
    "severity": _one_of("error", "warning"),
    "code": {"type": "string", "pattern": "^CSP[0-9]{3}$"},
    "message": TEXT,
    "file": MAYBE_TEXT,
    "line": MAYBE_NUMBER,
    "column": MAYBE_NUMBER,
    "end_line": MAYBE_NUMBER,
    "end_column": MAYBE_NUMBER,
    "help": MAYBE_TEXT,
}
_CONDITIONS: Final = ("readings", "view", "every_size", "reduction", "coverage")
RESULT: Final = _object(_RESULT, optional=_CONDITIONS)
DIAGNOSTIC: Final = _object(_DIAGNOSTIC)
SUMMARY: Final = _object({"pass": NUMBER, "fail": NUMBER, "unknown": NUMBER, "error": NUMBER})


def _document(result: Schema, diagnostic: Schema) -> Schema:
    return _object(
        {
            "schema": {"const": "cspcheck/1"},
            "version": TEXT,
            "interrupted": FLAG,
            "results": _list(result),
            "diagnostics": _list(diagnostic),
            "summary": SUMMARY,
        }
    )


_SWEPT: Final[Schema] = {"definitions": TEXTS_BY_NAME}
FINDING: Final = _object(
    {
        "file": TEXT,
        "line": MAYBE_NUMBER,
        "subject": TEXT,
        "obligation": TEXT,
        "operation": MAYBE_TEXT,
        "detail": TEXT,
        "severity": _one_of("error", "warning", "info"),
        "status": _one_of("proved", "refuted", "bounded", "unknown"),
        "message": TEXT,
        "values": TEXTS_BY_NAME,
        "failing": MAYBE_TEXT,
        "lines": LINES,
        "vacuous": FLAG,
        "vouched": TEXTS,
        "hypotheses": TEXTS,
        "used": _or_null(_list(_object({"what": TEXT, "line": MAYBE_NUMBER, "text": TEXT}))),
        "missing": TEXTS,
        "scope": MAYBE_NUMBER,
        "seconds": SECONDS,
    }
)
PRECONDITION: Final = _object(
    {"class": TEXT, "operation": TEXT, "guard": MAYBE_TEXTS, "precondition": TEXTS, "exact": FLAG}
)

NUMBERS: Final = _list(NUMBER)
_BEHAVIOUR: Final[Schema] = {"machine_name": TEXT, "trace": NUMBERS, "error_event": NUMBER}
BEHAVIOUR: Final = _object(
    {
        **_BEHAVIOUR,
        "type": _one_of("trace", "min_acceptance", "loop"),
        "min_acceptance": NUMBERS,
        "loop_index": NUMBER,
        "child_behaviours": _list(_object({"machine_name": TEXT, "type": {"const": "trace"}, "trace": NUMBERS})),
    },
    optional=("error_event", "min_acceptance", "loop_index", "child_behaviours"),
)
SPECIFICATION_BEHAVIOUR: Final = _object(
    {
        **_BEHAVIOUR,
        "type": _one_of("trace", "min_acceptance"),
        "allowed_events": _list(NUMBERS),
        "acceptances": _list(NUMBERS),
        "states": TEXTS,
    },
    optional=("allowed_events", "acceptances", "states"),
)
_BIT: Final[Schema] = {"enum": [0, 1]}
REFINES: Final = _object(
    {
        "copyright_notice": TEXT,
        "results": _list(
            _object(
                {
                    "assertion_string": TEXT,
                    "errors": TEXTS,
                    "is_negated": _BIT,
                    "result": _BIT,
                    "visited_states": NUMBER,
                    "visited_transitions": NUMBER,
                    "visited_plys": {"type": "null"},
                    "counterexamples": _list(
                        _object(
                            {
                                "type": _one_of("trace", "min_acceptance", "deadlock", "divergence", "determinism"),
                                "implementation_behaviour": BEHAVIOUR,
                                "specification_behaviour": SPECIFICATION_BEHAVIOUR,
                            },
                            optional=("specification_behaviour",),
                        )
                    ),
                }
            )
        ),
        "print_statement_results": TEXTS,
        "file_name": TEXT,
        "event_map": TEXTS_BY_NAME,
        "warnings": TEXTS,
        "errors": TEXTS,
    }
)

SCHEMAS: Final[dict[str, tuple[str, Schema]]] = {
    "check": ("`cspcheck check --format json`, and `typecheck`", _document(RESULT, DIAGNOSTIC)),
    "lines": (
        "a line of `cspcheck check --format jsonl`",
        {"anyOf": [RESULT, DIAGNOSTIC, _object({"interrupted": {"const": True}})]},
    ),
    "sweep": (
        "`cspcheck sweep --format json`",
        _document(_object(_RESULT | _SWEPT, optional=_CONDITIONS), _object(_DIAGNOSTIC | _SWEPT)),
    ),
    "prove": (
        "`cspcheck prove --format json`",
        _object(
            {
                "schema": {"const": "cspcheck/proof/1"},
                "obligations": _list(FINDING),
                "preconditions": _list(PRECONDITION),
            }
        ),
    ),
    "mutate": (
        "`cspcheck mutate --format json`",
        _object(
            {
                "schema": {"const": "cspcheck/mutation/1"},
                "version": TEXT,
                "interrupted": FLAG,
                "mutants": _list(
                    _object(
                        {
                            "file": TEXT,
                            "line": NUMBER,
                            "column": NUMBER,
                            "end_line": NUMBER,
                            "end_column": NUMBER,
                            "kind": TEXT,
                            "change": TEXT,
                            "fate": _one_of("noticed", "unnoticed", "equivalent", "undecided", "invalid"),
                            "noticed_by": MAYBE_TEXT,
                        }
                    )
                ),
            }
        ),
    ),
    "trace": (
        "`cspcheck trace --format json`",
        _object(
            {
                "schema": {"const": "cspcheck-trace/1"},
                "process": TEXT,
                "run": TEXT,
                "verdict": _one_of("pass", "fail"),
                "events": NUMBER,
                "followed": NUMBER,
                "line": MAYBE_NUMBER,
                "event": MAYBE_TEXT,
                "why": MAYBE_TEXT,
                "allowed": MAYBE_TEXTS,
                "before": MAYBE_TEXTS,
            }
        ),
    ),
    "refines": ("`cspcheck refines --format json`, a document for each file, as FDR4 writes them", REFINES),
    "record": (
        "a line of a recorded run, as generated programs write it",
        _object(
            {
                "n": NUMBER,
                "time": SECONDS,
                "event": TEXT,
                "channel": TEXT,
                "values": {"type": "array"},
                "tasks": TEXTS,
                "hidden": FLAG,
                "inner": {"const": True},
                "terminated": {"const": True},
            },
            optional=("inner", "terminated"),
        ),
    ),
}
"""By name: what is written so, and how it looks."""


def schema(name: str) -> Schema:
    """The schema of this name. Raises KeyError if there is none."""
    what, body = SCHEMAS[name]
    return {"$schema": _DRAFT, "title": f"cspcheck: {what}", **body}
