"""Constants of a class that are objects of generic classes: ``const a : Stack[nat]``.

Such a constant names one object for ever, as an attribute of the state does; so it is taken for one, and what the
axioms say of it holds of every state.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from cspcheck.cspm.oz import syntax as s
from cspcheck.cspm.oz.typing.scopes import mentioned
from cspcheck.cspm.syntax.tree import Declaration


def with_constant_objects(declarations: Iterable[Declaration]) -> list[Declaration]:
    """The declarations of a script, with such constants of classes of plain Object-Z as attributes."""
    found = list(declarations)
    generic = {d.name for d in found if isinstance(d, s.Class) and d.generics and not d.interface and not d.equations}
    return [_moved(d, generic) if isinstance(d, s.Class) and generic else d for d in found]


def _moved(tree: s.Class, generic: set[str]) -> s.Class:
    objects: list[s.Declare] = []
    said: list[s.Term] = []
    paragraphs = []
    for paragraph in tree.paragraphs:
        if not isinstance(paragraph, s.Axiom) or paragraph.generics:
            paragraphs.append(paragraph)
            continue
        own = [d for d in paragraph.declarations if _is_object(d, generic)]
        names = {name.name for d in own for name in d.names}
        about = [p for p in paragraph.predicates if any(r.name in names for r in mentioned([p]))]
        objects += own
        said += about
        rest = replace(
            paragraph,
            declarations=tuple([d for d in paragraph.declarations if d not in own]),
            predicates=tuple([p for p in paragraph.predicates if p not in about]),
        )
        if rest.declarations or rest.predicates:
            paragraphs.append(rest)
    if not objects:
        return tree
    state = tree.state or s.State(span=objects[0].span, primary=())
    state = replace(state, primary=(*objects, *state.primary), predicates=(*state.predicates, *said))
    return replace(tree, paragraphs=tuple(paragraphs), state=state)


def _is_object(declaration: s.Declare, generic: set[str]) -> bool:
    carrier = declaration.carrier
    carrier = s.bare(carrier)
    return isinstance(carrier, s.Reference) and carrier.name in generic and bool(carrier.arguments)
