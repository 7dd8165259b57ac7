"""From a clash of types to the message about it: which mistake it is, and what might have been meant."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress

from cspcheck.cspm.diagnostics import Diagnostic, Label
from cspcheck.cspm.syntax import tree as syntax
from cspcheck.cspm.typing import messages as messages
from cspcheck.cspm.typing.constraints import Unsatisfied, lacks_equality
from cspcheck.cspm.typing.inference.fields import field_mistake, head_name, missing
from cspcheck.cspm.typing.types import (
    BOOL,
    COMPLETE,
    CONSTRAINT_NAMES,
    EQ,
    EVENT,
    INT,
    NOTHING,
    ORD,
    PROC,
    SET,
    YIELDABLE,
    Constraints,
    Datatype,
    Dot,
    Dotable,
    Function,
    MapOf,
    Rigid,
    Row,
    SequenceOf,
    SetOf,
    Type,
    TypeWriter,
    Variable,
    resolve,
    show,
    spread,
)
from cspcheck.cspm.typing.unification import CannotUnify, Clash, InfiniteType, TypeClash, TypeTooLarge, Unifier

LACKS = {
    EQ: "has no equality (Eq)",
    ORD: "has no order (Ord)",
    SET: "cannot be an element of a set (Set)",
    COMPLETE: "is not a complete value (Complete)",
    YIELDABLE: "is neither an event nor a datatype value (Yieldable)",
}


def explain(
    clash: Exception, expected: Type, actual: Type, node: syntax.Node, role: str, label: Label | None
) -> Diagnostic:
    """What is wrong at *node*, whose type *actual* should be *expected*."""
    labels = () if label is None else (label,)
    writer = TypeWriter()
    match clash:
        case Unsatisfied():
            return _unsatisfied(clash, node, role, labels, writer)
        case InfiniteType():
            return messages.infinite_type(
                node.span, writer.write(clash.variable), writer.write(clash.type), role, labels
            )
        case CannotUnify(clash=Clash.SPLITS):
            return messages.splits_value(
                node.span, writer.write(clash.expected), writer.write(clash.actual), role, labels
            )
        case TypeTooLarge():
            return messages.type_too_large(node.span)
        case CannotUnify():
            pass
        case _:
            raise clash
    rigid = _rigid_side(clash)
    if rigid is not None:
        return _too_general(*rigid, clash, expected, actual, node, role, labels, writer)
    if type(resolve(actual)) is Dot:
        diagnostic = field_mistake(node, expected, actual, role, labels, writer)
        if diagnostic is not None:
            return diagnostic
    fields, result = spread(clash.actual)
    if fields and result is resolve(clash.expected):
        in_set = any(type(resolve(inner)) is SetOf for _, inner in clash.trail)
        return missing(node, result, fields, role, labels, writer, in_set=in_set)
    pairs = [(clash.expected, clash.actual), *clash.trail]
    if pairs[-1] != (expected, actual):
        pairs.append((expected, actual))
    texts = _texts(pairs, writer)
    return messages.mismatch(node.span, texts, role, labels, _hint(resolve(expected), resolve(actual), node, role))


def _texts(pairs: Sequence[tuple[Type, Type]], writer: TypeWriter) -> list[tuple[str, str]]:
    """The pairs as texts, their dots settled where that is possible; the steps that change nothing are left out."""
    scratch = Unifier()

    def text(type_: Type) -> str:
        with suppress(*TypeClash):
            type_ = scratch.settle(type_)
        return writer.write(type_)

    found: list[tuple[str, str]] = []
    for expected, actual in pairs:
        pair = (text(expected), text(actual))
        if not found or found[-1] != pair:
            found.append(pair)
    scratch.rollback(0)
    return found


# --- constraints ---------------------------------------------------------------------------------------------


def _unsatisfied(
    clash: Unsatisfied, node: syntax.Node, role: str, labels: Sequence[Label], writer: TypeWriter
) -> Diagnostic:
    blamed = resolve(clash.type)
    whole = resolve(clash.trail[-1][1]) if clash.trail else blamed
    if type(blamed) is Rigid:
        if blamed.span is not None:
            labels = (*labels, Label(blamed.span, f"`{blamed.name}` is a variable of this annotation"))
        name = CONSTRAINT_NAMES[clash.constraint]
        return messages.unconstrained_variable(node.span, blamed.name, name, role, labels)
    reasons = [
        f"`{writer.write(type_)}` needs it of `{writer.write(inner)}`"
        for (_, type_), inner in zip(clash.trail, [blamed, *[t for _, t in clash.trail]], strict=False)
    ]
    if whole is not blamed:
        reasons.insert(0, f"`{writer.write(blamed)}` {LACKS[clash.constraint]}")
    constraint = clash.trail[-1][0] if clash.trail else clash.constraint
    return messages.lacks_constraint(
        node.span,
        writer.write(whole),
        LACKS[constraint],
        role,
        reasons,
        labels,
        _constraint_hint(clash.constraint, blamed),
    )


def _constraint_hint(constraint: Constraints, type_: Type) -> str | None:
    if constraint is EQ:
        if type_ is PROC:
            return "processes cannot be compared; compare them in an assertion, with `[T=`, `[F=` or `[FD=`"
        if type(type_) is Function:
            return "functions cannot be compared; compare their results"
        if type(type_) is Datatype:
            for constructor, fields in type_.fields.items():
                for field in fields:
                    if lacks_equality(field) is not None:
                        return f"the constructor `{constructor}` carries a `{show(field)[0]}`, which has none"
    if constraint is ORD:
        if type_ in (BOOL, EVENT) or type(type_) is Datatype:
            return "integers, characters, sequences, sets, and tuples and maps of these can be ordered"
        return None
    if constraint is COMPLETE and type(type_) is Dotable:
        return "give the constructor all its fields"
    if constraint is YIELDABLE:
        return "start with a channel or a constructor"
    return None


# --- annotations ---------------------------------------------------------------------------------------------


def _rigid_side(clash: CannotUnify) -> tuple[Rigid, Type] | None:
    """The annotation's variable in a clash, and what it would have to be."""
    expected, actual = resolve(clash.expected), resolve(clash.actual)
    if type(expected) is Rigid:
        return expected, actual
    if type(actual) is Rigid:
        return actual, expected
    return None


def _too_general(
    rigid: Rigid,
    needed: Type,
    clash: CannotUnify,
    expected: Type,
    actual: Type,
    node: syntax.Node,
    role: str,
    labels: Sequence[Label],
    writer: TypeWriter,
) -> Diagnostic:
    if needed is NOTHING or type(needed) is Row:
        # The variable stands left of `=>*`, for fields.
        place = () if rigid.span is None else (Label(rigid.span, f"`{rigid.name}` is a variable of this annotation"),)
        return messages.too_definite_fields(node.span, rigid.name, writer.write(needed), role, (*labels, *place))
    text = writer.write(needed)
    if clash.clash is Clash.ESCAPES and type(needed) is Variable:
        text = "a type from outside the definition"
    if rigid.span is not None:
        labels = (*labels, Label(rigid.span, f"`{rigid.name}` is a variable of this annotation"))
    help_line = None
    if type(needed) is Rigid:
        help_line = f"use the same variable for `{rigid.name}` and `{needed.name}`, or make the definition more general"
    elif rigid.name[:1].isupper():
        help_line = f"`{rigid.name}` names no type, so it stands for any; write the type of the elements of a set"
    elif type(needed) is Variable:
        help_line = "leave the annotation out, or make the definition more general"
    return messages.too_general(node.span, rigid.name, text, role, labels, help_line)


# --- what might have been meant --------------------------------------------------------------------------------


_OPERATIONS = {
    "the left operand of `-`": ("the difference of two sets is `diff(A, B)`", ""),
    "the left operand of `+`": ("the union of two sets is `union(A, B)`", "sequences are joined with `s ^ t`"),
    "the left operand of `*`": ("the intersection of two sets is `inter(A, B)`", ""),
}
"""What to write where sets and sequences are calculated with as if they were numbers."""


def _may_be_process(type_: Type) -> bool:
    """Whether a process may come of a type once it has its arguments; of what is being defined it is not known yet."""
    type_ = resolve(type_)
    return type_ is PROC or type(type_) is Variable or (type(type_) is Function and _may_be_process(type_.result))


def _hint(expected: Type, actual: Type, node: syntax.Node, role: str) -> str | None:
    """What to try for a common mix-up; None if the types tell nothing."""
    if expected is INT and type(actual) in (SetOf, SequenceOf) and (known := _OPERATIONS.get(role)) is not None:
        return known[type(actual) is SequenceOf] or None
    if expected is PROC and type(actual) is SetOf and role == "the left operand of `\\`":
        return "`\\` hides events; the difference of two sets is `diff(A, B)`"
    if role == "this element of the set" and spread(expected)[1] is EVENT and spread(actual)[1] is EVENT:
        return "write `{| ... |}` for all events of the channels"
    if expected is PROC:
        if actual is EVENT or spread(actual)[1] is EVENT:
            return "an event is not a process: write `e -> P`"
        if type(actual) is Function and _may_be_process(actual.result):
            name = head_name(node)
            return f"give it its arguments: `{name}(...)`" if name else "give it its arguments"
        if type(actual) is SetOf and resolve(actual.element) is PROC:
            return "combine the processes of a set with a replicated operator, such as `[] p : S @ p`"
    elif expected is EVENT:
        if actual is PROC:
            return "`->` needs an event on its left; to run one process after another, use `;`"
        if type(actual) is SetOf and resolve(actual.element) is EVENT:
            return "to offer every event of a set, write `[] e : S @ e -> P`"
    elif expected is BOOL and actual is INT:
        return "compare it, as in `n == 0`"
    elif type(expected) is SetOf:
        element = resolve(expected.element)
        if type(actual) is SequenceOf:
            return "convert the sequence with `set(...)`"
        if element is EVENT and (actual is EVENT or spread(actual)[1] is EVENT):
            return "put it in brackets: `{| c |}` for all events of a channel, `{e}` for a single event"
        if actual is PROC:
            return None
        if type(actual) in (Datatype, MapOf) or actual in (INT, BOOL):
            return "a set is needed here, such as `{0..3}`"
    elif type(expected) is SequenceOf and type(actual) is SetOf:
        return "convert the set with `seq(...)`"
    elif type(expected) is Dotable and (actual is EVENT or type(actual) is Datatype):
        return "nothing is left to fill in: it has all its fields"
    elif type(actual) is Function and type(expected) is not Function:
        name = head_name(node)
        return f"give it its arguments: `{name}(...)`" if name else "give it its arguments"
    return None
