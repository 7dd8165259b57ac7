"""What classes say of the channels that they share: types, order, ends, and partners that are not there."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence

from cspm import syntax
from cspm.diagnostics import Diagnostic
from cspm.messages import classes as messages
from cspm.oz import core
from cspm.oz.equations import names_in
from cspm.spelling import suggestions

Report = Callable[[Diagnostic], None]


def compare_interfaces(
    models: Mapping[str, core.ClassModel], outside: Sequence[syntax.Declaration], report: Report
) -> None:
    """Compare the channels of all classes of a script.

    Args:
        models: the classes.
        outside: the CSPm declarations of the script, whose processes may be partners too.
        report: told what does not match.
    """
    sharing: dict[str, list[tuple[core.ClassModel, core.Channel]]] = {}
    for model in models.values():
        for channel in model.channels.values():
            if channel.kind == "chan":
                sharing.setdefault(channel.name, []).append((model, channel))
    mentioned = {name.parts[0] for name in names_in(tuple(outside))}
    for name, users in sharing.items():
        users = _without_ancestors(users, models)
        first = users[0]
        for other in users[1:]:
            if not _compared(first, other, report):
                break
        else:
            _ends(name, users, report)
        if len(users) == 1 and len(models) > 1 and name not in mentioned:
            owner, channel = users[0]
            if not _related(owner, models):
                others = [n for n, found in sharing.items() if all(m.name != owner.name for m, _ in found)]
                report(messages.lonely_channel(name, owner.name, channel.span, suggestions(name, others)))


def _ancestors(model: core.ClassModel, models: Mapping[str, core.ClassModel]) -> Iterator[str]:
    pending, seen = list(model.parents), set()
    while pending:
        name = pending.pop()
        if name not in seen:
            seen.add(name)
            yield name
            if name in models:
                pending.extend(models[name].parents)


def _without_ancestors(
    users: list[tuple[core.ClassModel, core.Channel]], models: Mapping[str, core.ClassModel]
) -> list[tuple[core.ClassModel, core.Channel]]:
    """Leave out parents of other users: a class and its child stand for each other, they are no partners."""
    parents = {name for model, _ in users for name in _ancestors(model, models)}
    left = [(model, channel) for model, channel in users if model.name not in parents]
    return left or users


def _related(model: core.ClassModel, models: Mapping[str, core.ClassModel]) -> bool:
    """Whether a class is part of an inheritance: then other variants of it may be what is composed."""
    return bool(model.parents) or any(model.name in other.parents for other in models.values())


def _compared(
    first: tuple[core.ClassModel, core.Channel], other: tuple[core.ClassModel, core.Channel], report: Report
) -> bool:
    """Whether two classes declare a channel alike; differences are reported."""
    (a, mine), (b, theirs) = first, other
    if len(mine.parameters) != len(theirs.parameters):
        sizes = ((b.name, len(theirs.parameters), theirs.span), (a.name, len(mine.parameters), mine.span))
        report(messages.channel_sizes(mine.name, *sizes))
        return False
    names = ([p.name for p in mine.parameters], [p.name for p in theirs.parameters])
    if names[0] != names[1] and sorted(names[0]) == sorted(names[1]):
        report(messages.channel_order(mine.name, (b.name, theirs.span), (a.name, mine.span)))
        return False
    alike = True
    for p, q in zip(mine.parameters, theirs.parameters, strict=True):
        if p.type != q.type:
            if _generic(p.type) or _generic(q.type):
                continue
            ends = ((b.name, str(q.type), q.span), (a.name, str(p.type), p.span))
            report(messages.channel_types(mine.name, q.name, *ends))
            alike = False
        elif p.name != q.name:
            report(messages.parameter_names(mine.name, (b.name, q.name, q.span), (a.name, p.name, p.span)))
    return alike


def _generic(type_: core.Type) -> bool:
    """Whether a type depends on a generic parameter, which is not known yet."""
    match type_:
        case core.GivenType(name):
            return "." in name
        case core.SetType(element) | core.SequenceType(element) | core.BagType(element):
            return _generic(element)
        case core.FunctionType(domain, range_):
            return _generic(domain) or _generic(range_)
        case core.TupleType(items):
            return any(map(_generic, items))
    return False


def _ends(name: str, users: list[tuple[core.ClassModel, core.Channel]], report: Report) -> None:
    """Who writes and who reads each parameter."""
    if len(users) < 2:
        return
    for i, parameter in enumerate(users[0][1].parameters):
        ends = [(model, channel.parameters[i]) for model, channel in users]
        writers = [(model.name, p.span) for model, p in ends if p.kind == "output"]
        if len(writers) > 1:
            report(messages.two_writers(name, parameter.name, writers))
        if all(p.kind == "input" for _, p in ends):
            report(messages.no_writer(name, parameter.name, parameter.span))
