"""The types of Object-Z, as a document is read: those of ISO Z, and sets of objects that references are of.

A sequence is a set of pairs here, a function a relation, and numbers have one type, as in ISO Z (13568). Types that are
still open are variables, which unification fills in (Robinson 1965). The type of a reference is the set of classes that
its object may be of; two such types go together if some object may be of both, which is the *weak* typing that makes
downcasts by membership possible. Where the type of a reference is open, it becomes the union of what it is compared
with.

That is another system than the one of :mod:`cspcheck.cspm.oz.core`, whose types say how a value is represented.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Final, TypeAlias


@dataclass(frozen=True, slots=True)
class Given:
    """A set whose elements are only told apart: numbers, truth values, given and free types, generic parameters."""

    name: str


@dataclass(frozen=True, slots=True)
class Power:
    """Sets."""

    element: ObjectZType


@dataclass(frozen=True, slots=True)
class Product:
    """Tuples."""

    items: tuple[ObjectZType, ...]


@dataclass(frozen=True, slots=True)
class Bindings:
    """Bindings of a schema: components by their decorated names, in the order of the names."""

    fields: tuple[tuple[str, ObjectZType], ...]


@dataclass(eq=False, slots=True)
class Open:
    """A type that is not known yet; *value* is what it turned out to be. *what* is the generic name it stands in."""

    value: ObjectZType | None = None
    what: str = ""


@dataclass(frozen=True, slots=True)
class ClassReference:
    """A class with actual parameters, and with features under other names: (old, new)."""

    name: str
    arguments: tuple[ObjectZType, ...] = ()
    renaming: tuple[tuple[str, str], ...] = ()


@dataclass(eq=False, slots=True)
class Objects:
    """References to objects.

    Attributes:
        classes: those that the object may be of, by name.
        common: the classes whose common features every such object has.
        every: any object at all may be meant.
        grows: other classes may be added, as the type was open.
        written: as the document says it.
    """

    classes: dict[str, ClassReference] = field(default_factory=dict)
    common: dict[str, ClassReference] = field(default_factory=dict)
    every: bool = False
    grows: bool = False
    written: str = ""


ObjectZType: TypeAlias = Given | Power | Product | Bindings | Open | Objects

NUMBER: Final = Given("int")
TRUTH: Final = Given("bool")

Admits = Callable[[Objects, Objects], bool]
"""Whether two sets of classes have their common features in the same types."""


def known(type_: ObjectZType) -> ObjectZType:
    """A type without the variables around it."""
    while isinstance(type_, Open) and type_.value is not None:
        type_ = type_.value
    return type_


def pairs(left: ObjectZType, right: ObjectZType) -> Power:
    """Relations."""
    return Power(Product((left, right)))


def sequence(element: ObjectZType) -> Power:
    """Sequences: functions from numbers."""
    return pairs(NUMBER, element)


def bindings(fields: Mapping[str, ObjectZType]) -> Bindings:
    """Bindings with some components."""
    return Bindings(tuple(sorted(fields.items())))


def parts(type_: ObjectZType) -> Iterator[ObjectZType]:
    """What a type is made of, immediately."""
    match known(type_):
        case Power(element):
            yield element
        case Product(items):
            yield from items
        case Bindings(fields):
            yield from (part for _, part in fields)
        case Objects(classes=classes):
            yield from (argument for reference in classes.values() for argument in reference.arguments)


def is_open(type_: ObjectZType) -> bool:
    """Whether something in a type is not known."""
    type_ = known(type_)
    return isinstance(type_, Open) or any(is_open(part) for part in parts(type_))


def _occurs(variable: Open, type_: ObjectZType) -> bool:
    type_ = known(type_)
    return type_ is variable or any(_occurs(variable, part) for part in parts(type_))


class Unification:
    """Makes types the same.

    Args:
        admits: whether classes may stand in one union.
    """

    def __init__(self, admits: Admits) -> None:
        self._admits = admits

    def same(self, left: ObjectZType, right: ObjectZType) -> bool:
        """Whether two types can be the same; what is open in them is filled in."""
        left, right = known(left), known(right)
        if left is right:
            return True
        match left, right:
            case Open(), Open() if left.what and not right.what:
                return self._fill(right, left)  # so that the parameter of a generic name stays one
            case Open(), _:
                return self._fill(left, right)
            case _, Open():
                return self._fill(right, left)
            case Given(), Given():
                return left == right
            case Power(), Power():
                return self.same(left.element, right.element)
            case Product(), Product():
                return len(left.items) == len(right.items) and all(map(self.same, left.items, right.items))
            case Bindings(), Bindings():
                names = [[name for name, _ in b.fields] for b in (left, right)]
                types = [[type_ for _, type_ in b.fields] for b in (left, right)]
                return names[0] == names[1] and all(map(self.same, *types))
            case Objects(), Objects():
                return self._meet(left, right)
        return False

    def _fill(self, variable: Open, type_: ObjectZType) -> bool:
        if _occurs(variable, type_):
            return False
        if isinstance(type_, Objects) and not type_.grows and variable.what:
            # The union of what it is compared with.
            type_ = Objects(dict(type_.classes), dict(type_.common), type_.every, grows=True)
        variable.value = type_
        return True

    def _meet(self, left: Objects, right: Objects) -> bool:
        """Whether some object may be of both; a union that grows takes in what it does not have."""
        if left.every or right.every:
            return True
        if left.grows and right.grows:
            return self.grown(left, right) and self.grown(right, left)
        if left.grows or right.grows:
            growing, other = (left, right) if left.grows else (right, left)
            return self.grown(growing, other)
        shared = [name for name in left.classes if name in right.classes]
        return any(all(map(self.same, left.classes[name].arguments, right.classes[name].arguments)) for name in shared)

    def grown(self, target: Objects, other: Objects) -> bool:
        """Add the classes of *other*; whether their features go together."""
        if all(name in target.classes for name in other.classes):
            return all(
                self.same(a, b)
                for name in other.classes
                for a, b in zip(target.classes[name].arguments, other.classes[name].arguments, strict=False)
            )
        if not self._admits(target, other):
            return False
        target.classes.update(other.classes)
        target.common.update(other.common)
        return True

    def joined(self, left: ObjectZType, right: ObjectZType) -> ObjectZType | None:
        """The type of what may be one or the other; None if there is none."""
        one, other = known(left), known(right)
        if isinstance(one, Objects) and isinstance(other, Objects) and not (one.every or other.every):
            if one.classes.keys() == other.classes.keys():
                return left if self.same(one, other) else None
            return self.union(one, other)
        return left if self.same(left, right) else None

    def union(self, left: Objects, right: Objects) -> Objects | None:
        """The union of classes; None if it has features of different types."""
        shared = [name for name in left.classes if name in right.classes]
        for name in shared:
            if not all(map(self.same, left.classes[name].arguments, right.classes[name].arguments)):
                return None
        if not self._admits(left, right):
            return None
        return Objects(left.classes | right.classes, left.common | right.common, left.every or right.every)


def substituted(type_: ObjectZType, actual: Mapping[str, ObjectZType]) -> ObjectZType:
    """A type with others in place of generic parameters."""
    type_ = known(type_)
    match type_:
        case Given(name):
            return actual.get(name, type_)
        case Power(element):
            return Power(substituted(element, actual))
        case Product(items):
            return Product(tuple([substituted(item, actual) for item in items]))
        case Bindings(fields):
            return Bindings(tuple([(name, substituted(part, actual)) for name, part in fields]))
        case Objects() if any(r.arguments for r in (*type_.classes.values(), *type_.common.values())):
            tables = [
                {
                    name: ClassReference(
                        r.name, tuple([substituted(argument, actual) for argument in r.arguments]), r.renaming
                    )
                    for name, r in table.items()
                }
                for table in (type_.classes, type_.common)
            ]
            return Objects(tables[0], tables[1], type_.every, type_.grows, type_.written)
    return type_


def shown_apart(left: ObjectZType, right: ObjectZType) -> tuple[str, str]:
    """Two types that differ, so that it can be seen."""
    if shown(left) != shown(right):
        return shown(left), shown(right)
    return shown(left, whole=True), shown(right, whole=True)


def shown(type_: ObjectZType, *, whole: bool = False) -> str:
    """A type as a message has it; *whole* with the classes that given types are declared in."""
    type_ = known(type_)
    match type_:
        case Given(name):
            return name if whole else name.rpartition(".")[2]
        case Power(element):
            inner = known(element)
            if isinstance(inner, Product) and len(inner.items) == 2:
                return f"({shown(inner.items[0], whole=whole)} <-> {shown(inner.items[1], whole=whole)})"
            return f"power {shown(element, whole=whole)}"
        case Product(items):
            return f"({' cross '.join(shown(item, whole=whole) for item in items)})"
        case Bindings(fields):
            return f"[{'; '.join(f'{name} : {shown(part, whole=whole)}' for name, part in fields)}]"
        case Objects():
            return _shown_objects(type_)
    return "an open type"


def _shown_objects(type_: Objects) -> str:
    if type_.written:
        return type_.written
    if type_.every:
        return "oid"
    names = [
        r.name + (f"[{', '.join(map(shown, r.arguments))}]" if r.arguments else "") for r in type_.classes.values()
    ]
    return " union ".join(names) or "an object"
