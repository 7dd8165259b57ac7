"""The types of CSPm: what an expression can be, before it is evaluated.

Beside the usual ones (sets, sequences, tuples, maps, functions with argument lists) there are three for the dot:

* ``a.b`` (:class:`Dot`), a plain pair of values joined by a dot;
* ``a => b`` (:class:`Dotable`), something that needs an ``a`` behind a dot to become a ``b``. A channel declared
  ``channel c : A.B`` has the type ``A => B => Event``, a constructor ``C.A`` of ``T`` has ``A => T``;
* ``a =>* b`` (:class:`Extendable`), a ``b`` or something that can be extended to a ``b`` by fields not yet known.

Variables are cells: unification writes what they stand for into ``binding``. :func:`resolve` looks through them.
A field list that is still open (the ``a`` of ``a =>* b``) is a variable too; it is bound to :data:`NOTHING` or
to a :class:`Row`, never to an ordinary type.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from cspcheck.cspm.source import Span

Constraints = int
"""A set of constraints on a type variable, as a bit mask of the constants below."""

EQ: Constraints = 1
ORD: Constraints = 2
SET: Constraints = 4
COMPLETE: Constraints = 8
YIELDABLE: Constraints = 16

CONSTRAINT_NAMES: dict[Constraints, str] = {
    EQ: "Eq",
    ORD: "Ord",
    SET: "Set",
    COMPLETE: "Complete",
    YIELDABLE: "Yieldable",
}


def implied(constraints: Constraints) -> Constraints:
    """The constraints that hold for every type that satisfies *constraints*, these included."""
    if constraints & ORD:
        constraints |= EQ
    if constraints & YIELDABLE:
        constraints |= COMPLETE | SET
    if constraints & EQ:
        constraints |= SET
    return constraints


def essential(constraints: Constraints) -> Constraints:
    """The least set of constraints that implies the same ones: what a user would write."""
    kept = constraints
    for single in CONSTRAINT_NAMES:
        if kept & single and implied(kept & ~single) & single:
            kept &= ~single
    return kept


class Type:
    """A type. Subclasses compare by identity; unification is what relates them."""

    __slots__ = ()


class Variable(Type):
    """A type not known yet, or the alias of one.

    ``level`` is the depth of the definition it belongs to: a variable deeper than the definition that is being
    generalised occurs nowhere outside it (Rémy's levels, which replace a search of the environment).
    """

    __slots__ = ("binding", "constraints", "level")

    def __init__(self, level: int, constraints: Constraints = 0) -> None:
        self.binding: Type | None = None
        self.constraints = constraints
        self.level = level


class Rigid(Type):
    """A variable of an annotation, inside the definition that is annotated: some type, nobody knows which."""

    __slots__ = ("constraints", "level", "name", "span")

    def __init__(self, name: str, level: int, constraints: Constraints = 0, span: Span | None = None) -> None:
        self.name = name
        self.level = level
        self.constraints = constraints
        self.span = span


class Atom(Type):
    """A type without parts: ``Int``, ``Bool``, ``Char``, ``Proc``, ``Event``."""

    __slots__ = ("name",)

    def __init__(self, name: str) -> None:
        self.name = name


INT = Atom("Int")
BOOL = Atom("Bool")
CHAR = Atom("Char")
PROC = Atom("Proc")
EVENT = Atom("Event")
REAL = Atom("Real")
"""Of values that classes make; no annotation names it."""
NOTHING = Atom("")
"""The empty list of fields, at the end of a row."""

ATOMS: dict[str, Atom] = {atom.name: atom for atom in (INT, BOOL, CHAR, PROC, EVENT)}


class Datatype(Type):
    """A declared datatype, or the copy of one in an instance of a module.

    ``fields`` has the field types of each constructor once they are known. ``comparable`` says whether values have
    equality; None as long as the declarations that decide it are being inferred.
    """

    __slots__ = ("comparable", "fields", "name", "span")

    def __init__(self, name: str, span: Span | None = None) -> None:
        self.name = name
        self.span = span
        self.fields: dict[str, tuple[Type, ...]] = {}
        self.comparable: bool | None = None


class SetOf(Type):
    """``{a}``."""

    __slots__ = ("element",)

    def __init__(self, element: Type) -> None:
        self.element = element


class SequenceOf(Type):
    """``<a>``."""

    __slots__ = ("element",)

    def __init__(self, element: Type) -> None:
        self.element = element


class MapOf(Type):
    """``(| k => v |)``."""

    __slots__ = ("key", "value")

    def __init__(self, key: Type, value: Type) -> None:
        self.key = key
        self.value = value


class TupleOf(Type):
    """``(a, b)``."""

    __slots__ = ("items",)

    def __init__(self, items: Sequence[Type]) -> None:
        self.items = tuple(items)


class Function(Type):
    """``(a, b) -> c``."""

    __slots__ = ("parameters", "result")

    def __init__(self, parameters: Sequence[Type], result: Type) -> None:
        self.parameters = tuple(parameters)
        self.result = result


class Dot(Type):
    """``a.b``; the dots of one type may be nested on either side, :func:`parts` gives the flat list."""

    __slots__ = ("left", "right")

    def __init__(self, left: Type, right: Type) -> None:
        self.left = left
        self.right = right


class Dotable(Type):
    """``a => b``; an argument that is a dot stands for several fields."""

    __slots__ = ("argument", "result")

    def __init__(self, argument: Type, result: Type) -> None:
        self.argument = argument
        self.result = result


class Row(Type):
    """A field and the fields behind it: how the open end of an :class:`Extendable` gets known bit by bit."""

    __slots__ = ("field", "rest")

    def __init__(self, field: Type, rest: Type) -> None:
        self.field = field
        self.rest = rest


class Extendable(Type):
    """``a =>* b``; ``row`` is a variable, a :class:`Rigid`, a :class:`Row` or :data:`NOTHING`."""

    __slots__ = ("result", "row")

    def __init__(self, row: Type, result: Type) -> None:
        self.row = row
        self.result = result


@dataclass(frozen=True, slots=True, eq=False)
class Scheme:
    """A type that holds for every choice of ``variables``."""

    variables: tuple[Variable | Rigid, ...]
    type: Type

    def __str__(self) -> str:
        return show_scheme(self)


# --- looking at types ----------------------------------------------------------------------------------------


def resolve(type_: Type) -> Type:
    """What *type_* stands for at its head: never a bound variable, never an extendable whose fields are known."""
    while True:
        if type(type_) is Variable:
            if type_.binding is None:
                return type_
            type_ = type_.binding
        elif type(type_) is Extendable:
            row = type_.row
            while type(row) is Variable and row.binding is not None:
                row = row.binding
            if row is NOTHING:
                type_ = type_.result
            elif type(row) is Row:
                return Dotable(row.field, Extendable(row.rest, type_.result))
            elif row is type_.row:
                return type_
            else:
                return Extendable(row, type_.result)
        else:
            return type_


def parts(type_: Type) -> list[Type]:
    """The components of a dotted type, in order, each resolved; a single one for any other type."""
    found: list[Type] = []
    waiting = [type_]
    while waiting:
        head = resolve(waiting.pop())
        if type(head) is Dot:
            waiting.append(head.right)
            waiting.append(head.left)
        else:
            found.append(head)
    return found


def dotted(types: Sequence[Type]) -> Type:
    """The dot of *types* (at least one), nested to the right."""
    whole = types[-1]
    for part in reversed(types[:-1]):
        whole = Dot(part, whole)
    return whole


def dotable(arguments: Sequence[Type], result: Type) -> Type:
    """``a1 => a2 => ... => result``."""
    for argument in reversed(arguments):
        result = Dotable(argument, result)
    return result


def spread(type_: Type) -> tuple[list[Type], Type]:
    """The fields that *type_* still needs, one by one, and what it is when it has them."""
    arguments: list[Type] = []
    head = resolve(type_)
    while type(head) is Dotable:
        arguments.extend(parts(head.argument))
        head = resolve(head.result)
    return arguments, head


def components(type_: Type) -> tuple[Type, ...]:
    """The types right below the head of a resolved type."""
    match type_:
        case SetOf() | SequenceOf():
            return (type_.element,)
        case MapOf():
            return (type_.key, type_.value)
        case TupleOf():
            return type_.items
        case Function():
            return (*type_.parameters, type_.result)
        case Dot():
            return (type_.left, type_.right)
        case Dotable():
            return (type_.argument, type_.result)
        case Row():
            return (type_.field, type_.rest)
        case Extendable():
            return (type_.row, type_.result)
    return ()


def subtypes(*types: Type) -> Iterator[Type]:
    """All parts of *types*, themselves included, resolved, left to right, outer ones first.

    A part that is shared comes once: types of exponential size are small graphs.
    """
    seen: dict[int, Type] = {}  # keeps its values alive, so that an identity means one part only
    waiting = list(reversed(types))
    while waiting:
        part = waiting.pop()
        if id(part) in seen:
            continue
        seen[id(part)] = part
        head = resolve(part)
        yield head
        waiting.extend(reversed(components(head)))


def free_variables(*types: Type) -> list[Variable]:
    """The unbound variables that occur in *types*, each once, in the order of their first occurrence."""
    return list(dict.fromkeys([part for part in subtypes(*types) if type(part) is Variable]))


def larger_than(type_: Type, limit: int) -> bool:
    """Whether *type_*, written out, has more than *limit* parts."""
    waiting = [type_]
    count = 0
    while waiting:
        count += 1
        if count > limit:
            return True
        waiting.extend(components(resolve(waiting.pop())))
    return False


def substitute(type_: Type, replace: Callable[[Type], Type | None]) -> Type:
    """A copy of *type_* in which each part for which *replace* gives something is that.

    *replace* sees resolved types, outer ones first. Parts in which nothing is replaced are shared with *type_*.
    """
    head = resolve(type_)
    replacement = replace(head)
    if replacement is not None:
        return replacement
    below = components(head)
    if not below:
        return head
    copies = [substitute(part, replace) for part in below]
    for old, new in zip(below, copies, strict=True):
        if old is not new:
            return rebuilt(head, copies)
    return head


def rebuilt(head: Type, below: list[Type]) -> Type:
    """A type like *head* with other components, in the order of :func:`components`."""
    match head:
        case SetOf():
            return SetOf(below[0])
        case SequenceOf():
            return SequenceOf(below[0])
        case MapOf():
            return MapOf(below[0], below[1])
        case TupleOf():
            return TupleOf(below)
        case Function():
            return Function(below[:-1], below[-1])
        case Dot():
            return Dot(below[0], below[1])
        case Dotable():
            return Dotable(below[0], below[1])
        case Row():
            return Row(below[0], below[1])
        case Extendable():
            return Extendable(below[0], below[1])
    raise AssertionError(head)


# --- types as users write them -------------------------------------------------------------------------------


LONGEST = 2_000
"""Parts that one writer writes before it is content with dots."""


class TypeWriter:
    """Writes types; the same variable has the same letter in everything that one writer writes."""

    def __init__(self, avoid: Sequence[str] = ()) -> None:
        self._left = LONGEST
        self._names: dict[Type, str] = {}
        self._taken = set(avoid)
        self._letters = _letters()

    def name(self, variable: Variable | Rigid) -> str:
        """The name of a variable: its own for a rigid one, the next free letter otherwise."""
        name = self._names.get(variable)
        if name is None:
            if type(variable) is Rigid:
                name = variable.name
                self._taken.add(name)
            else:
                name = next(letter for letter in self._letters if letter not in self._taken)
            self._names[variable] = name
        return name

    def write(self, type_: Type) -> str:
        """*type_* in the syntax of annotations."""
        self._left -= 1
        if self._left < 0:
            return "..."
        head = resolve(type_)
        match head:
            case Variable() | Rigid():
                return self.name(head)
            case Atom() | Datatype():
                return head.name
            case SetOf():
                return f"{{{self.write(head.element)}}}"
            case SequenceOf():
                return f"<{self.write(head.element)}>"
            case MapOf():
                return f"(| {self._arm(head.key)} => {self.write(head.value)} |)"
            case TupleOf():
                return f"({', '.join([self.write(item) for item in head.items])})"
            case Function():
                parameters = ", ".join([self.write(parameter) for parameter in head.parameters])
                return f"({parameters}) -> {self.write(head.result)}"
            case Dot():
                return ".".join([self._part(part) for part in parts(head)])
            case Dotable():
                return f"{self._arm(head.argument)} => {self._tail(head.result)}"
            case Extendable():
                return f"{self.write(head.row)} =>* {self._tail(head.result)}"
            case Row():
                rest = self.write(head.rest)
                return f"{self._part(head.field)}.{rest}" if rest else self._part(head.field)
        raise AssertionError(head)

    def _part(self, type_: Type) -> str:
        """*type_* between two dots."""
        text = self.write(type_)
        return f"({text})" if type(resolve(type_)) in (Function, Dotable, Extendable) else text

    def _arm(self, type_: Type) -> str:
        """*type_* left of ``=>``; several fields are written as such, ``Int => Bool =>``."""
        return " => ".join([self._part(part) for part in parts(type_)])

    def _tail(self, type_: Type) -> str:
        """*type_* right of ``=>``."""
        text = self.write(type_)
        return f"({text})" if type(resolve(type_)) is Function else text

    def constraints(self, variables: Sequence[Variable | Rigid]) -> str:
        """``Eq a => `` or ``(Eq a, Set b) => ``; empty without constraints."""
        written = [
            f"{CONSTRAINT_NAMES[single]} {self.name(variable)}"
            for variable in variables
            for single in CONSTRAINT_NAMES
            if essential(variable.constraints) & single
        ]
        if not written:
            return ""
        return f"{written[0]} => " if len(written) == 1 else f"({', '.join(written)}) => "


def show(*types: Type) -> tuple[str, ...]:
    """The types in the syntax of annotations, with shared names for shared variables."""
    writer = TypeWriter(_rigid_names(types))
    return tuple([writer.write(type_) for type_ in types])


def show_scheme(scheme: Scheme) -> str:
    """The scheme in the syntax of annotations: ``Eq a => (a, {a}) -> Bool``."""
    writer = TypeWriter(_rigid_names([scheme.type]))
    body = writer.write(scheme.type)
    return writer.constraints(scheme.variables) + body


def _rigid_names(types: Sequence[Type]) -> list[str]:
    return [part.name for part in subtypes(*types) if type(part) is Rigid]


def _letters() -> Iterator[str]:
    """``a`` to ``z``, then ``a1``, ``b1`` and so on."""
    round_ = 0
    while True:
        for code in range(ord("a"), ord("z") + 1):
            yield chr(code) + (str(round_) if round_ else "")
        round_ += 1
