"""Functions that their axioms define by recursion: there is exactly one such function, and it can be computed.

A constant ``f : seq X -> Y`` with ``f(<>) = e`` and ``forall s : seq X; x : X @ f(s ^ <x>) = E`` (or ``f(<x> ^ s)``),
where E speaks of f only in ``f(s)``; a constant ``f : nat -> Y`` (or ``nat1``) with ``f(0) = e`` and
``forall n : nat @ f(n + 1) = E``, where E speaks of f only in ``f(n)``. That e and E are in Y is for a proof to show.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Literal

from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.core import Apply, Binder, Constant, Declared, Term, Variable
from cspcheck.cspm.oz.values.carriers import Unbounded
from cspcheck.cspm.oz.values.substitution import rebuilt
from cspcheck.cspm.oz.values.terms import Name, shape

if TYPE_CHECKING:
    from cspcheck.cspm.oz.values.evaluation import TermEvaluator

LONGEST = 1 << 16
"""Numbers up to so far from the least are computed."""


@dataclass(frozen=True, slots=True)
class Recursion:
    """A function that is defined by recursion.

    Attributes:
        constant: the function.
        kind: ``front`` and ``back`` of sequences by where the item stands, or ``number``.
        least: the least number.
        base: the value for the empty sequence or the least number.
        binders: the rest (or the number), and the item of a sequence.
        value: stands in *step* for the value for the rest.
        step: the value for one item more, or for the next number.
        axioms: those that say all this.
    """

    constant: Declared
    kind: Literal["front", "back", "number"]
    least: int
    base: Term
    binders: tuple[Binder, ...]
    value: Variable
    step: Term
    axioms: tuple[Term, Term]

    @property
    def domain(self) -> Term:
        """The set of its arguments."""
        return _sides(self.constant.carrier)[0]

    @property
    def range(self) -> Term:
        """The set that its values are in."""
        return _sides(self.constant.carrier)[1]


def _sides(carrier: Term) -> tuple[Term, Term]:
    assert isinstance(carrier, Apply)
    domain, range_ = carrier.operands
    return domain, range_


def recursions(constants: Iterable[Declared], axioms: Sequence[Term]) -> dict[str, Recursion]:
    """The constants that axioms define by recursion, by name."""
    found = {}
    for constant in constants:
        made = _recursion(constant, axioms)
        if made is not None:
            found[constant.name] = made
    return found


def _recursion(constant: Declared, axioms: Sequence[Term]) -> Recursion | None:
    match constant.carrier:
        case Apply(operator="fun", operands=(Apply(operator="seq" | "Nat" | "Nat1" as kind) as domain, _)):
            pass
        case _:
            return None
    assert isinstance(constant.type, core.FunctionType)
    value = Variable(type=constant.type.range, name=f"{constant.name}%value", role="bound")
    bases = [(a, e) for a in axioms for e in _base(a, constant, kind)]
    steps = [(a, s) for a in axioms for s in _step(a, constant, domain, value)]
    if not bases or not steps:
        return None
    (base_axiom, base), (step_axiom, (where, binders, step)) = bases[0], steps[0]
    least = 1 if kind == "Nat1" else 0
    return Recursion(constant, where, least, base, binders, value, step, (base_axiom, step_axiom))


def _applied(term: Term, constant: Declared) -> Iterator[tuple[Term, Term]]:
    """The argument and the value of an equation ``f(a) = e``."""
    if isinstance(term, Apply) and term.operator == "equal":
        for one, other in (term.operands, term.operands[::-1]):
            if isinstance(one, Apply) and one.operator == "apply" and _is(one.operands[0], constant):
                yield one.operands[1], other


def _is(term: Term, constant: Declared) -> bool:
    return isinstance(term, Variable) and (term.name, term.role) == (constant.name, "constant")


def _speaks(term: Term, constant: Declared) -> bool:
    return _is(term, constant) or any(_speaks(part, constant) for part in core.parts(term))


def _base(axiom: Term, constant: Declared, kind: str) -> Iterator[Term]:
    for argument, value in _applied(axiom, constant):
        match kind, argument:
            case "seq", Apply(operator="sequence", operands=()):
                least = True
            case "Nat" | "Nat1", Constant(value=number):
                least = number == (0 if kind == "Nat" else 1)
            case _:
                least = False
        if least and not _speaks(value, constant):
            yield value


_Step = tuple[Literal["front", "back", "number"], tuple[Binder, ...], Term]


def _step(axiom: Term, constant: Declared, domain: Apply, value: Variable) -> Iterator[_Step]:
    if not (isinstance(axiom, core.Quantifier) and axiom.kind == "forall"):
        return
    if axiom.condition != Constant(type=core.BOOL, value=True):
        return
    by_name = {binder.name: binder for binder in axiom.binders}
    for argument, body in _applied(axiom.body, constant):
        where: Literal["front", "back", "number"]
        names: tuple[str, ...]
        match argument:
            case Apply(operator="plus", operands=(Variable(name=n, role="bound"), Constant(value=1))):
                names, where = (n,), "number"
            case Apply(operator="plus", operands=(Constant(value=1), Variable(name=n, role="bound"))):
                names, where = (n,), "number"
            case Apply(
                operator="concat",
                operands=(
                    Variable(name=s, role="bound"),
                    Apply(operator="sequence", operands=(Variable(name=x, role="bound"),)),
                ),
            ):
                names, where = (s, x), "back"
            case Apply(
                operator="concat",
                operands=(
                    Apply(operator="sequence", operands=(Variable(name=x, role="bound"),)),
                    Variable(name=s, role="bound"),
                ),
            ):
                names, where = (s, x), "front"
            case _:
                continue
        if len(set(names)) != len(by_name) or not set(names) <= set(by_name):
            continue
        binders = tuple(by_name[name] for name in names)
        wanted = (domain,) if where == "number" else (domain, domain.operands[0])
        if any(shape(b.carrier) != shape(c) for b, c in zip(binders, wanted, strict=True)):
            continue
        step = _unfolded(body, constant, binders[0], value)
        if not _speaks(step, constant):
            yield where, binders, step


def _unfolded(term: Term, constant: Declared, rest: Binder, value: Variable) -> Term:
    """A term with a variable for the value for the rest."""
    if isinstance(term, Apply) and term.operator == "apply" and _is(term.operands[0], constant):
        argument = term.operands[1]
        if isinstance(argument, Variable) and (argument.name, argument.role) == (rest.name, "bound"):
            return replace(value, span=term.span)
    return rebuilt(term, lambda part: _unfolded(part, constant, rest, value))


class Recursive(Mapping[Any, Any]):
    """The value of a function that is defined by recursion. It is infinite: it can be applied, and nothing else."""

    def __init__(self, evaluator: TermEvaluator, recursion: Recursion) -> None:
        from cspcheck.cspm.oz.values.evaluation import FrameScope

        self._evaluator = evaluator
        self._recursion = recursion
        self._known: dict[Any, Any] = {}
        names = [*[binder.name for binder in recursion.binders], recursion.value.name]
        self._names: list[Name] = [(name, "bound") for name in names]
        self._scope = FrameScope(self._names)
        self._code = evaluator.code(recursion.step, self._scope)

    def __getitem__(self, at: Any) -> Any:
        if at not in self:
            raise KeyError(at)
        found = self._known.get(at)
        if found is None:
            found = self._computed(at)
            self._known[at] = found
        return found

    def _computed(self, at: Any) -> Any:
        recursion = self._recursion
        result = self._evaluator.value(recursion.base)
        if recursion.kind == "number":
            if at - recursion.least > LONGEST:
                raise Unbounded(recursion.domain)
            for number in range(recursion.least, at):
                result = self._stepped(number, result)
        for position in range(len(at)) if recursion.kind == "back" else ():
            result = self._stepped(at[:position], at[position], result)
        for position in reversed(range(len(at))) if recursion.kind == "front" else ():
            result = self._stepped(at[position + 1 :], at[position], result)
        return result

    def _stepped(self, *values: Any) -> Any:
        return self._code(self._scope.frame(dict(zip(self._names, values, strict=True))))

    def __contains__(self, at: object) -> bool:
        return self._evaluator.contains(self._recursion.domain, at)

    def __iter__(self) -> Iterator[Any]:
        raise Unbounded(self._recursion.domain)

    def __len__(self) -> int:
        raise Unbounded(self._recursion.domain)

    def __eq__(self, other: object) -> bool:
        if isinstance(other, Recursive):
            return self is other
        return NotImplemented

    def __hash__(self) -> int:
        return hash(self._recursion.constant.name)
