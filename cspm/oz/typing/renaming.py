"""A parent under the names that a subclass gives it: ``inherit Stack[nat][items/contents, add/push]``."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TypeVar

from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.typing.equations import renamed_equations
from cspcheck.cspm.oz.typing.operation_calculus import Box, changed
from cspcheck.cspm.oz.values.substitution import substituted

D = TypeVar("D", bound=core.Declared)


def renamed(
    parent: core.ClassModel, boxes: Mapping[str, Box], names: Mapping[str, str]
) -> tuple[core.ClassModel, dict[str, Box]]:
    """A class and its schemas with channels, operations, variables and constants called otherwise.

    Args:
        names: by old names the new ones.
    """
    states = {d.name for d in (*parent.primary, *parent.secondary)}
    constants = {d.name for d in parent.constants}

    def variable(v: core.Variable) -> core.Term | None:
        own = (v.role in ("before", "after") and v.name in states) or (v.role == "constant" and v.name in constants)
        return replace(v, name=names[v.name]) if own and v.name in names else None

    def term(t: core.Term) -> core.Term:
        return substituted(t, variable)

    def terms(found: tuple[core.Term, ...]) -> tuple[core.Term, ...]:
        return tuple(map(term, found))

    def called(name: str) -> str:
        return names.get(name, name)

    def declared(found: tuple[D, ...]) -> tuple[D, ...]:
        return tuple([replace(d, name=called(d.name), carrier=term(d.carrier)) for d in found])

    def parameters(found: tuple[core.Parameter, ...]) -> tuple[core.Parameter, ...]:
        return tuple([replace(p, carrier=term(p.carrier)) for p in found])

    def operation(o: core.Operation) -> core.Operation:
        return replace(
            o,
            name=called(o.name),
            parameters=parameters(o.parameters),
            delta=tuple(map(called, o.delta)),
            guard=terms(o.guard),
            effect=terms(o.effect),
        )

    def box(found: Box) -> Box:
        inside = changed(found, variable)
        return replace(
            inside,
            delta=tuple(map(called, inside.delta)),
            places=tuple([replace(place, name=called(place.name)) for place in inside.places]),
            framed=frozenset(map(called, inside.framed)),
        )

    model = replace(
        parent,
        channels={
            called(n): replace(c, name=called(n), parameters=parameters(c.parameters))
            for n, c in parent.channels.items()
        },
        constants=declared(parent.constants),
        axioms=terms(parent.axioms),
        primary=declared(parent.primary),
        secondary=declared(parent.secondary),
        invariant=terms(parent.invariant),
        initial=None if parent.initial is None else terms(parent.initial),
        operations={called(n): operation(o) for n, o in parent.operations.items()},
        processes=tuple([renamed_equations(part, names) for part in parent.processes]),
        lemmas={n: replace(lemma, term=term(lemma.term)) for n, lemma in parent.lemmas.items()},
    )
    return model, {called(name): box(found) for name, found in boxes.items()}
