"""Data independence of the data part of a class.

A class is data independent in a type where no constant has values of it and where the whole type occurs only as what a
variable is taken from: what it does with some values then does not depend on which others there are. It *tests* values
where an equality, a set or a function on the type is looked at; an equation that says what a variable becomes, or of
which parts a known value consists, is no test.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from cspcheck.checker.independence.uses import DataUse, Dependent, Use, total
from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.core import Apply, ClassModel, Comprehension, Quantifier, Term, Variable
from cspcheck.cspm.oz.processes.context import ClassContext
from cspcheck.cspm.oz.values.readings import COLLECTIONS
from cspcheck.cspm.oz.values.terms import conjuncts, free_variables

Key = tuple[str, core.Role]

_NO_TEST: Final = frozenset(
    {
        *("and", "or", "not", "implies", "iff", "tuple", "item", "sequence", "concat", "head", "tail", "front", "last"),
        *("length", "rev", "apply", "function", "override", "dom", "dom_restrict", "dom_subtract"),
        *("sequence_to_function", "cross", "seq", "seq1"),
    }
)
"""Operators that move values and do not look at them, where the types of their operands are no sets of them."""
_EVERY: Final = frozenset(
    {"cross", "seq", "seq1", "power", "power1", "finset", "finset1", "bag", "rel", "pfun", "ffun"}
)
"""Carriers over a type that have, of each larger type, the elements that consist of some values, and more."""
_DISTINCT: Final = frozenset({"iseq", "pinj", "finj", "inj"})
"""Carriers that compare: of what is distinct."""


class Carried:
    """Where values of one given set, or of one type of constants, are in the types and terms of a specification."""

    def __init__(self, name: str, context: ClassContext) -> None:
        self.name = name
        self.context = context
        self._known: dict[core.Type, bool] = {}

    def touches(self, type_: core.Type) -> bool:
        """Whether values of a type have values of the one in question inside."""
        known = self._known.get(type_)
        if known is None:
            self._known[type_] = False  # of a recursive type the other branches tell
            known = self._known[type_] = self._touches(type_)
        return known

    def _touches(self, type_: core.Type) -> bool:
        match type_:
            case core.GivenType(name) | core.FreeType(name) if name == self.name:
                return True
            case core.FreeType(name):
                branches = self.context.specification.frees[name].branches
                return any(a is not None and self.touches(_element(a)) for _, a in branches)
            case core.TupleType(items):
                return any(map(self.touches, items))
            case core.SetType(element) | core.SequenceType(element) | core.BagType(element):
                return self.touches(element)
            case core.FunctionType(domain, range_):
                return self.touches(domain) or self.touches(range_)
            case core.RecordType(_, fields):
                return any(self.touches(item) for _, item in fields)
        return False

    def compares(self, type_: core.Type) -> bool:
        """Whether values of a type are kept apart by equality: sets, bags, functions from it."""
        match type_:
            case core.SetType(element) | core.BagType(element):
                return self.touches(element)
            case core.FunctionType(domain, range_):
                return self.touches(domain) or self.compares(range_)
            case core.SequenceType(element):
                return self.compares(element)
            case core.TupleType(items):
                return any(map(self.compares, items))
            case core.RecordType(_, fields):
                return any(self.compares(item) for _, item in fields)
        return False

    def slots(self, type_: core.Type, carrier: Term | None = None) -> int | None:
        """The most values of the type in question inside one of another; None: no bound is known."""
        if not self.touches(type_):
            return 0
        match type_:
            case core.GivenType(name) | core.FreeType(name) if name == self.name:
                return 1
            case core.TupleType(items):
                operands: Sequence[Term | None] = [None] * len(items)
                if isinstance(carrier, Apply) and carrier.operator == "cross":
                    operands = carrier.operands
                return total([self.slots(item, operand) for item, operand in zip(items, operands, strict=True)])
            case core.RecordType(_, fields):
                return total([self.slots(item) for _, item in fields])
        if isinstance(carrier, Apply) and carrier.operator in COLLECTIONS:
            reading = self.context.evaluator(None).readings.of(carrier)
            if reading is not None and reading.bound is not None:
                each = total([self.slots(_element(operand), operand) for operand in carrier.operands])
                return None if each is None else reading.bound * each
        return None


def _element(carrier: Term) -> core.Type:
    assert isinstance(carrier.type, core.SetType)
    return carrier.type.element


class ClassReader:
    """Looks at one class; :meth:`use` says how it treats the values."""

    def __init__(self, carried: Carried, model: ClassModel) -> None:
        self.carried = carried
        self.model = model
        self.use_ = Use()
        self._seen: set[core.Type] = set()
        """Free types and schemas that have been looked at."""

    def use(self) -> DataUse:
        """How the data part of the class treats the values.

        Raises:
            Dependent: it may depend on the size of the type.
        """
        model, specification = self.model, self.carried.context.specification
        for constant in (*specification.constants, *model.constants):
            if self.carried.touches(constant.type):
                raise Dependent(f"the constant `{constant.name}` has values of it")
            self.walk(constant.carrier)
        for axiom in (*specification.axioms, *model.axioms):
            self.walk(axiom)
        variables = (*model.primary, *model.secondary)
        for declared in variables:
            self.carrier(declared.carrier)
        for conjunct in conjuncts(model.invariant):
            self.walk(conjunct)
        known = self.settled(model.initial or (), {(v.name, "before") for v in variables})
        normal = all((v.name, "before") in known for v in variables)
        held = [self.carried.slots(v.type, v.carrier) for v in variables]
        widest: list[int | None] = [0]
        outputs: set[str] = set()
        for operation in model.operations.values():
            normal &= self._operation(operation, held, widest, outputs)
        most = None if None in widest else max(count for count in widest if count is not None)
        return DataUse(self.use_.tests, self.use_.chosen, total([*held, most]), frozenset(outputs), normal)

    def _operation(
        self, operation: core.Operation, held: list[int | None], widest: list[int | None], outputs: set[str]
    ) -> bool:
        """Look at an operation; whether what it does is determined by what is known of its event."""
        carried = self.carried
        channel = self.model.channels[operation.name]
        for parameter in (*channel.parameters, *operation.parameters):
            self.carrier(parameter.carrier)
        kinds = {p.name: p.kind for p in channel.parameters} | {p.name: p.kind for p in operation.parameters}
        told = [p for p in channel.parameters if kinds[p.name] == "output"]
        asked = [p for p in channel.parameters if kinds[p.name] != "output"]
        by_name = {v.name: v for v in (*self.model.primary, *self.model.secondary)}
        changed = [by_name[name] for name in (*operation.delta, *[v.name for v in self.model.secondary])]
        unknown: set[Key] = {(v.name, "after") for v in changed} | {(p.name, "output") for p in told}
        for conjunct in conjuncts(operation.guard):
            self.walk(conjunct)
        known = self.settled(operation.effect, unknown)
        open_outputs = [p for p in told if (p.name, "output") not in known]
        if open_outputs and any(carried.touches(p.type) for p in asked):
            # For each value of the input another output may have been chosen: as many choices as values.
            raise Dependent(f"`{operation.name}` chooses an output for each value of its input")
        # What was chosen for one operation stays while the environment waits.
        held += [carried.slots(p.type, p.carrier) for p in open_outputs]
        self.use_.choose(total([carried.slots(p.type, p.carrier) for p in open_outputs]))
        open_ends = [v for v in changed if (v.name, "after") not in known]
        if open_ends:
            widest.append(total([carried.slots(p.type, p.carrier) for p in channel.parameters]))
        self.use_.choose(total([carried.slots(v.type, v.carrier) for v in open_ends]))
        if any(carried.touches(p.type) for p in told):
            outputs.add(operation.name)
        return not open_outputs and not open_ends

    # --- predicates that say what variables are ---------------------------------------------------------------------

    def settled(self, predicates: Sequence[Term], unknown: set[Key]) -> set[Key]:
        """Look at predicates that hold together; which of the unknown variables they determine."""
        return self._settled(predicates, unknown, set())[0]

    def _settled(self, predicates: Sequence[Term], unknown: set[Key], said: set[Key]) -> tuple[set[Key], set[Key]]:
        """The variables that are determined for certain, and those of which something has been said."""
        certain: set[Key] = set()
        said = set(said)
        for predicate in conjuncts(tuple(predicates)):
            match predicate:
                case Apply(operator="equal", operands=(left, right)):
                    found = self._equation(left, right, unknown, said, certain)
                    certain |= found
                    said |= found
                case Apply(operator="or", operands=operands):
                    branches = [self._settled([operand], unknown, said) for operand in operands]
                    said = said.union(*[branch[1] for branch in branches])
                case Apply(operator="implies", operands=(condition, consequence)):
                    self.walk(condition)
                    said |= self._settled([consequence], unknown, said)[1]
                case core.If(test=test, then=then, otherwise=otherwise):
                    self.walk(test)
                    first = self._settled([then], unknown, said)
                    second = self._settled([otherwise], unknown, said)
                    certain |= first[0] & second[0]
                    said |= first[1] | second[1]
                case _:
                    self.walk(predicate)
        return certain, said

    def _equation(self, left: Term, right: Term, unknown: set[Key], said: set[Key], certain: set[Key]) -> set[Key]:
        """The unknowns that an equation determines; one that determines none is a comparison."""
        for pattern, value in ((left, right), (right, left)):
            found = _pattern(pattern, unknown)
            if found and len(set(found)) == len(found) and not said & set(found):
                keys = set(free_variables(value))
                if not keys & (unknown - certain):
                    self.walk(value)
                    return set(found)
        self.walk(Apply(type=core.BOOL, operator="equal", operands=(left, right)))
        return set()

    # --- terms -------------------------------------------------------------------------------------------------------

    def carrier(self, term: Term) -> None:
        """Look at what a variable is taken from."""
        element = _element(term)
        if not self.carried.touches(element):
            self.walk(term)
            return
        if self.carried.compares(element):
            self.use_.tests = True
        match term:
            case Apply(operator="All"):
                if isinstance(element, core.FreeType) and element.name != self.carried.name:
                    self._free(element)
            case Apply(operator="Records"):
                assert isinstance(element, core.RecordType)
                self._record(element)
            case Apply(operator=operator, operands=operands) if operator in _EVERY or operator in _DISTINCT:
                self.use_.tests |= operator in _DISTINCT
                if operator == "inj" and self.carried.touches(_element(operands[0])):
                    raise Dependent("a variable is a function on all of it")
                for operand in operands:
                    self.carrier(operand)
            case Apply(operator="fun", operands=(domain, range_)) if not self.carried.touches(_element(domain)):
                self.walk(domain)
                self.carrier(range_)
            case Comprehension(kind="set", binders=(binder,), body=Variable(name=name)) if name == binder.name:
                self.carrier(binder.carrier)
                self.walk(term.condition)
            case _:
                self.walk(term)

    def _free(self, free: core.FreeType) -> None:
        if free not in self._seen:
            self._seen.add(free)
            for _, argument in self.carried.context.specification.frees[free.name].branches:
                if argument is not None:
                    self._argument(argument, free)

    def _record(self, type_: core.RecordType) -> None:
        if type_ not in self._seen:
            self._seen.add(type_)
            record = self.carried.context.specification.records[type_.name]
            for field in record.fields:
                self.carrier(field.carrier)
            for predicate in (*record.predicates, *(record.initial or ())):
                self.walk(predicate)

    def _argument(self, argument: Term, free: core.FreeType) -> None:
        if free in _types_in(_element(argument)):
            if not isinstance(argument, Apply) or argument.operator not in _EVERY:
                raise Dependent("a recursive type has values of it")
            for operand in argument.operands:
                if _element(operand) != free:
                    self._argument(operand, free)
        else:
            self.carrier(argument)

    def walk(self, term: Term) -> None:
        """Look at a term wherever it may stand."""
        carried = self.carried
        if carried.compares(term.type):
            self.use_.tests = True
        match term:
            case core.Construct(constructor=name) if isinstance(term.type, core.FreeType):
                if term.type.name == carried.name:
                    raise Dependent(f"its value `{name}` is named")
            case Apply(operator="in", operands=(value, set_)) if _is_every(set_):
                self.walk(value)
                self.carrier(set_)
                return
            case Apply(operator="All" | "Records") if carried.touches(term.type):
                raise Dependent("all of its values are gone through")
            case Apply(operator="init", operands=(record,)) if isinstance(record.type, core.RecordType):
                self.use_.tests |= carried.touches(record.type)
                self._record(record.type)
            case Apply(operator="equal", operands=(left, right)) if carried.touches(left.type):
                self.use_.tests |= not (_is_empty(left) or _is_empty(right))
            case Apply(operator=operator, operands=operands) if operator not in _NO_TEST:
                self.use_.tests |= any(carried.touches(operand.type) for operand in operands)
            case Quantifier() | Comprehension():
                for binder in term.binders:
                    if carried.compares(binder.type):
                        self.use_.tests = True
        for part in core.parts(term):
            self.walk(part)


def _is_every(term: Term) -> bool:
    return isinstance(term, Apply) and (
        term.operator in _EVERY or term.operator in _DISTINCT or term.operator in ("All", "Records")
    )


def _is_empty(term: Term) -> bool:
    return isinstance(term, Apply) and term.operator in ("sequence", "function") and not term.operands


def _types_in(type_: core.Type) -> set[core.Type]:
    found = {type_}
    match type_:
        case core.TupleType(items):
            parts: Sequence[core.Type] = items
        case core.SetType(element) | core.SequenceType(element) | core.BagType(element):
            parts = (element,)
        case core.FunctionType(domain, range_):
            parts = (domain, range_)
        case core.RecordType(_, fields):
            parts = [item for _, item in fields]
        case _:
            parts = ()
    return found.union(*map(_types_in, parts))


def _pattern(term: Term, unknown: set[Key]) -> list[Key]:
    """The unknowns that a known value of this form would determine; none where it does not have the form."""
    match term:
        case Variable() if (term.name, term.role) in unknown:
            return [(term.name, term.role)]
        case Apply(operator="tuple" | "sequence", operands=operands) if operands:
            return _all(operands, unknown)
        case Apply(operator="concat", operands=operands):
            open_ = [
                operand for operand in operands if not (isinstance(operand, Apply) and operand.operator == "sequence")
            ]
            return _all(operands, unknown) if len(open_) <= 1 else []
    return []


def _all(terms: Sequence[Term], unknown: set[Key]) -> list[Key]:
    found: list[Key] = []
    for term in terms:
        inner = _pattern(term, unknown)
        if not inner:
            return []
        found += inner
    return found
