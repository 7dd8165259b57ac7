"""What classes say of the channels that they share: types, order, ends, and partners that are not there."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace

from cspcheck.cspm.diagnostics import DiagnosticSink
from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.typing import messages as messages
from cspcheck.cspm.oz.typing.equations import defined_name, names_in
from cspcheck.cspm.spelling import suggestions
from cspcheck.cspm.syntax import tree as syntax


def compare_interfaces(
    models: Mapping[str, core.ClassModel],
    outside: Sequence[syntax.Declaration],
    unclear: Collection[str],
    report: DiagnosticSink,
) -> None:
    """Compare the channels of all classes of a script.

    Types must agree wherever a channel is declared. Who writes, who reads, and who is alone with a channel is looked
    at among the classes that the script composes.

    Args:
        models: the classes.
        outside: the CSPm declarations of the script, whose processes may be partners too.
        unclear: channels that cannot be compared, as something is wrong with them already.
        report: told what does not match.
    """
    agreed = set()
    compositions, mentioned = _compositions(models, outside)
    for name, users in _sharing(list(models.values())).items():
        if name in unclear:
            continue
        if all(channel.kind == "operation" for _, channel in users):
            # Classes of plain Object-Z that do not meet may call different operations the same.
            met = {model for composition in compositions for model in _met(users, composition)}
            users = [(model, channel) for model, channel in users if model.name in met]
        users = _without_ancestors(users, models)
        if all(_compared(users[0], other, report) for other in users[1:]):
            agreed.add(name)
    for composition in compositions:
        composed = _sharing([models[name] for name in composition])
        for name, users in composed.items():
            if name in agreed:
                _ends(name, users, report)
            if len(users) == 1 and name not in mentioned and users[0][1].kind == "chan":
                owner, channel = users[0]
                others = [n for n, found in composed.items() if all(m.name != owner.name for m, _ in found)]
                report(messages.lonely_channel(name, owner.name, channel.span, suggestions(name, others)))


def settled(models: Mapping[str, core.ClassModel]) -> dict[str, core.ClassModel]:
    """The classes, with operations of plain Object-Z as channels that all share if they mean the same by the name."""
    alike = {
        name
        for name, users in _sharing(list(models.values())).items()
        if len({tuple([p.type for p in c.parameters]) for m, c in users if not _depends(m, c)}) <= 1
        or any(channel.kind == "chan" for _, channel in users)
    }

    def channel(found: core.Channel) -> core.Channel:
        joins = found.kind == "operation" and found.name in alike
        return replace(found, kind="chan") if joins else found

    return {
        name: replace(model, channels={n: channel(c) for n, c in model.channels.items()})
        for name, model in models.items()
    }


def _depends(model: core.ClassModel, channel: core.Channel) -> bool:
    """Whether the parameters of a channel depend on the generic parameters of its class."""
    return any(_generic(p.type, model) for p in channel.parameters)


def _met(users: Sequence[tuple[core.ClassModel, core.Channel]], composition: tuple[str, ...]) -> list[str]:
    """The users of an operation that meet another one in a composition."""
    found = [model.name for model, _ in users if model.name in composition]
    return found if len(found) > 1 else []


def _sharing(models: Sequence[core.ClassModel]) -> dict[str, list[tuple[core.ClassModel, core.Channel]]]:
    """The classes that declare each channel."""
    sharing: dict[str, list[tuple[core.ClassModel, core.Channel]]] = {}
    for model in models:
        for channel in model.channels.values():
            if channel.kind in ("chan", "operation"):
                sharing.setdefault(channel.name, []).append((model, channel))
    return sharing


def _compositions(
    models: Mapping[str, core.ClassModel], outside: Sequence[syntax.Declaration]
) -> tuple[list[tuple[str, ...]], set[str]]:
    """The largest sets of classes that definitions of the script speak of together, and all names that it mentions."""
    uses: dict[str, set[str]] = {}
    mentioned: set[str] = set()
    for declaration in outside:
        names = {name.parts[0] for name in names_in(declaration)}
        mentioned |= names
        found = defined_name(declaration)
        if found is not None:
            uses.setdefault(found[0], set()).update(names)
    sets = []
    for start in uses:
        reached, pending = {start}, [start]
        while pending:
            for name in uses.get(pending.pop(), ()):
                if name not in reached:
                    reached.add(name)
                    pending.append(name)
        classes = frozenset(reached & set(models))
        if len(classes) > 1:
            sets.append(classes)
    largest = [found for found in dict.fromkeys(sets) if not any(found < other for other in sets)]
    return [tuple([name for name in models if name in found]) for found in largest], mentioned


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


def _compared(
    first: tuple[core.ClassModel, core.Channel], other: tuple[core.ClassModel, core.Channel], report: DiagnosticSink
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
            if _generic(p.type, a) or _generic(q.type, b):
                continue  # that depends on how the class is instantiated
            ends = ((b.name, str(q.type), q.span), (a.name, str(p.type), p.span))
            report(messages.channel_types(mine.name, q.name, *ends))
            alike = False
        elif p.name != q.name:
            report(messages.parameter_names(mine.name, (b.name, q.name, q.span), (a.name, p.name, p.span)))
    return alike


def _generic(type_: core.Type, model: core.ClassModel) -> bool:
    """Whether a type depends on a generic parameter of its class."""
    match type_:
        case core.GivenType(name):
            return any(name in (generic, f"{model.name}.{generic}") for generic in model.generics)
        case core.SetType(element) | core.SequenceType(element) | core.BagType(element):
            return _generic(element, model)
        case core.FunctionType(domain, range_):
            return _generic(domain, model) or _generic(range_, model)
        case core.TupleType(items):
            return any(_generic(item, model) for item in items)
    return False


def _ends(name: str, users: list[tuple[core.ClassModel, core.Channel]], report: DiagnosticSink) -> None:
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
