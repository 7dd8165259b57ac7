"""Lemmas used for given values: which values stand for the variables of the outermost ``forall``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.core import BagType, FunctionType, GivenType, RecordType, SequenceType, SetType, TupleType, Type
from cspcheck.cspm.oz.typing.fitting import UNKNOWN, Misfit, fit, join


def outermost(term: core.Term) -> tuple[core.Binder, ...]:
    """The variables that a predicate says something of for all values, whatever else it says."""
    if isinstance(term, core.Quantifier) and term.kind == "forall":
        return (*term.binders, *outermost(term.body))
    return ()


class WrongArgument(Exception):
    """A value that a variable of a lemma cannot have.

    Attributes:
        position: of the value.
        wanted: the type of the variable.
    """

    def __init__(self, position: int, wanted: Type) -> None:
        super().__init__(str(wanted))
        self.position = position
        self.wanted = wanted


def fitted(lemma: core.Lemma, arguments: Sequence[core.Term]) -> tuple[dict[str, Type], tuple[core.Term, ...]]:
    """The types that stand for a lemma's generic parameters, by their given sets, and the values with their types.

    Args:
        lemma: that is used.
        arguments: as many as its outermost ``forall`` binds variables.

    Raises:
        WrongArgument: one is of another type, or what a parameter stands for is open.
    """
    binders = outermost(lemma.term)
    types: dict[str, Type] = {}
    for position, (binder, argument) in enumerate(zip(binders, arguments, strict=True)):
        if not _matched(binder.type, argument.type, frozenset(lemma.givens), types):
            raise WrongArgument(position, with_types(binder.type, types))
    found = []
    for position, (binder, argument) in enumerate(zip(binders, arguments, strict=True)):
        wanted = with_types(binder.type, types)
        try:
            found.append(fit(argument, wanted))
        except Misfit:
            raise WrongArgument(position, wanted) from None
    for position, binder in enumerate(binders):
        if any(given not in types for given in _givens(binder.type) if given in lemma.givens):
            raise WrongArgument(position, binder.type)
    return types, tuple(found)


def _matched(wanted: Type, found: Type, givens: frozenset[str], types: dict[str, Type]) -> bool:
    """Find the types that stand for given sets where one type is to be another; whether they may agree.

    What is not looked at here is left to the coercion.
    """
    match wanted, found:
        case GivenType(name=name), _ if name in givens:
            if found == UNKNOWN:
                return True
            joined = join(types.get(name, found), found)
            if joined is not None:
                types[name] = joined
            return joined is not None
        case (SetType(a), SetType(b)) | (SequenceType(a), SequenceType(b)) | (BagType(a), BagType(b)):
            return _matched(a, b, givens, types)
        case FunctionType(a, c), FunctionType(b, d):
            return _matched(a, b, givens, types) and _matched(c, d, givens, types)
        case FunctionType(a, c), SequenceType(d):
            return _matched(a, core.INT, givens, types) and _matched(c, d, givens, types)
        case FunctionType(a, c), SetType(TupleType((b, d))):
            return _matched(a, b, givens, types) and _matched(c, d, givens, types)
        case SetType(TupleType((a, c))), FunctionType(b, d):
            return _matched(a, b, givens, types) and _matched(c, d, givens, types)
        case TupleType(xs), TupleType(ys):
            return len(xs) == len(ys) and all(_matched(x, y, givens, types) for x, y in zip(xs, ys, strict=True))
    return True


def _givens(type_: Type) -> set[str]:
    match type_:
        case GivenType(name=name):
            return {name}
        case SetType(element) | SequenceType(element) | BagType(element):
            return _givens(element)
        case FunctionType(domain, range_):
            return _givens(domain) | _givens(range_)
        case TupleType(items):
            return {name for item in items for name in _givens(item)}
    return set()


def with_types(type_: Type, types: Mapping[str, Type]) -> Type:
    """A type with types in the place of given sets."""
    match type_:
        case GivenType(name=name):
            return types.get(name, type_)
        case TupleType(items):
            return TupleType(tuple(with_types(item, types) for item in items))
        case RecordType(name, fields):
            return RecordType(name, tuple((field, with_types(part, types)) for field, part in fields))
        case SetType(element):
            return SetType(with_types(element, types))
        case SequenceType(element):
            return SequenceType(with_types(element, types))
        case BagType(element):
            return BagType(with_types(element, types))
        case FunctionType(domain, range_):
            return FunctionType(with_types(domain, types), with_types(range_, types))
    return type_
