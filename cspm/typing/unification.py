"""Unification of types: the one place that decides whether two types can be the same.

Ordinary constructors unify by structure (Robinson). The dot needs more: ``c.x`` can be a finished event, a channel
that wants further fields, or a plain pair, depending on types that may become known only later. A dotted type is
therefore kept as it was written, a list of components, until something forces it:

* *absorption* applies a component that wants fields to what stands behind it. A component that itself wants fields
  (a constructor inside a channel) is completed first; one that is complete fills exactly one field.
* a variable in the last place takes every field that is left (the longest match), a variable in any other place
  takes one (the shortest); in ``{| c.x |}`` the last one too takes a single field, the rest being extended anyway.
* two lists are matched from the left; a last variable facing several components stands for all of them.

So ``c.x`` for ``channel c : A.B`` makes ``x`` an ``A.B`` where an event is needed, and ``c?x?y`` gives each its own.

Every write into a variable is logged, so a caller can try something and take it back (:meth:`Unifier.rollback`).
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import Enum, auto

from cspcheck.cspm.typing.constraints import Unsatisfied, constrain
from cspcheck.cspm.typing.types import (
    BOOL,
    CHAR,
    EVENT,
    INT,
    NOTHING,
    PROC,
    Atom,
    Constraints,
    Datatype,
    Dot,
    Dotable,
    Extendable,
    Function,
    MapOf,
    Rigid,
    Row,
    SequenceOf,
    SetOf,
    TupleOf,
    Type,
    Variable,
    components,
    dotable,
    dotted,
    parts,
    rebuilt,
    resolve,
    spread,
    subtypes,
)


class Clash(Enum):
    """Why two types cannot be the same."""

    DIFFERENT = auto()
    """Different constructors, lengths or datatypes."""
    ESCAPES = auto()
    """A variable of an annotation would be fixed to something, or leave the definition that it belongs to."""
    SURPLUS = auto()
    """More fields behind a channel or constructor than it takes."""
    SPLITS = auto()
    """A pattern or parameter that is a plain dot, against a single value."""


class CannotUnify(Exception):
    """*expected* and *actual* are the innermost types that clash; ``trail`` has the pairs around them, inside out."""

    def __init__(self, clash: Clash, expected: Type, actual: Type) -> None:
        super().__init__(clash)
        self.clash = clash
        self.expected = expected
        self.actual = actual
        self.trail: list[tuple[Type, Type]] = []


class TypeTooLarge(Exception):
    """The types of a definition have more parts than can be dealt with."""


class InfiniteType(Exception):
    """*variable* would have to be a part of itself."""

    def __init__(self, variable: Variable, type_: Type) -> None:
        super().__init__(variable)
        self.variable = variable
        self.type = type_


TypeClash = (CannotUnify, InfiniteType, Unsatisfied, TypeTooLarge)
"""Everything that unification raises."""

MOST_STEPS = 1_000_000
"""Steps that one group of definitions may take; types that double at each definition would take for ever."""


class Unifier:
    """Makes types equal by binding variables, and remembers what it bound.

    ``undecided`` collects the datatypes whose equality was needed before it was known whether they have any.
    """

    def __init__(self) -> None:
        self._log: list[tuple[Variable, Constraints, int]] = []
        self._whole_dots = False
        self._steps = 0
        self.undecided: list[Datatype] = []

    # --- taking back -----------------------------------------------------------------------------------------

    def mark(self) -> int:
        """A point to which :meth:`rollback` can return."""
        return len(self._log)

    def rollback(self, mark: int) -> None:
        """Undo every binding made since *mark*."""
        log = self._log
        while len(log) > mark:
            variable, constraints, level = log.pop()
            variable.binding = None
            variable.constraints = constraints
            variable.level = level

    def forget(self) -> None:
        """Give up the possibility to roll back to any point before this one, and count steps anew."""
        self._log.clear()
        self._steps = 0

    def save(self, variable: Variable) -> None:
        """Log a variable that is about to change."""
        self._log.append((variable, variable.constraints, variable.level))

    def step(self) -> None:
        """Count some work. Raises TooLarge when there has been too much of it."""
        self._steps += 1
        if self._steps > MOST_STEPS:
            raise TypeTooLarge

    # --- unification -----------------------------------------------------------------------------------------

    def unify(self, expected: Type, actual: Type) -> None:
        """Make the two types the same.

        Raises:
            CannotUnify: they differ; the order of the arguments shows in the message only, except that a dotted
                type among the parameters is not taken apart (see :meth:`argument`).
            InfiniteType: a variable would occur in itself.
            Unsatisfied: a variable's constraints do not hold for what it would stand for.
        """
        expected = resolve(expected)
        actual = resolve(actual)
        if expected is actual:
            return
        self.step()
        try:
            self._unify(expected, actual)
        except CannotUnify as clash:
            if not (clash.expected is expected and clash.actual is actual):
                clash.trail.append((expected, actual))
            raise

    def constrain(self, constraints: Constraints, type_: Type) -> None:
        """Make *type_* satisfy all of *constraints*, see :func:`cspcheck.cspm.typing.constraints.constrain`."""
        constrain(self, constraints, type_)

    def argument(self, expected: Type, actual: Type) -> None:
        """Make the type of an argument (a value matched by a pattern) that of the parameter (the pattern).

        Dots are settled first, by the longest match. A parameter that is then still a plain ``a.b`` takes plain dots
        only: a finished event is one value, and ``f(x.y)`` does not take it apart.
        """
        before = self._whole_dots
        mark = self.mark()
        self._whole_dots = True
        try:
            try:
                actual_settled = self.settle(actual)
                self.unify(self.settle(expected), actual_settled)
            except TypeClash as first:
                # Settling may have been too eager: a field that is a variable took less than it stands for.
                self.rollback(mark)
                if not _has_dots(actual):
                    raise
                try:
                    self.unify(expected, actual)
                    self.settle(actual)
                except TypeClash:
                    self.rollback(mark)
                    raise first from None
        finally:
            self._whole_dots = before

    def _unify(self, expected: Type, actual: Type) -> None:
        """Unify two resolved types."""
        if type(expected) is Variable:
            self._bind(expected, actual)
            return
        if type(actual) is Variable:
            self._bind(actual, expected)
            return
        if type(expected) is Dot or type(actual) is Dot:
            self._unify_dots(expected, actual)
            return
        if type(expected) is Dotable:
            if type(actual) is Dotable:
                self._unify_dotables(expected, actual)
                return
            if type(actual) is Extendable:
                self._extend(actual, expected, extendable_expected=False)
                return
        elif type(expected) is Extendable:
            if type(actual) is Extendable:
                self.unify(expected.result, actual.result)
                self._unify_rows(expected, actual)
            else:
                self._extend(expected, actual, extendable_expected=True)
            return
        elif type(actual) is Extendable:
            self._extend(actual, expected, extendable_expected=False)
            return
        elif type(expected) is type(actual) and type(expected) not in (Atom, Datatype, Rigid):
            left, right = components(expected), components(actual)
            if len(left) == len(right):
                for one, other in zip(left, right, strict=True):
                    self.unify(one, other)
                return
        raise CannotUnify(Clash.DIFFERENT, expected, actual)

    def _bind(self, variable: Variable, type_: Type) -> None:
        """Make *variable* stand for the resolved *type_*."""
        if type(type_) is Variable:
            if type_ is variable:
                return
            self.save(variable)
            self.save(type_)
            type_.constraints |= variable.constraints
            type_.level = min(type_.level, variable.level)
            variable.binding = type_
            return
        if self._occurs(variable, type_):
            type_ = self.settle(type_)
            known = resolve(variable)
            if known is not variable:
                # Reading the dots has said what the variable stands for: `<Exp.(G, x), x>`.
                self.unify(known, type_)
                return
            if type_ is variable:
                return
            if self._occurs(variable, type_):
                raise InfiniteType(variable, type_)
        if variable.constraints:
            constrain(self, variable.constraints, type_)
            if variable.binding is not None:
                # Settling a dot for the sake of a constraint has reached the variable itself.
                self.unify(variable, type_)
                return
        self.save(variable)
        variable.binding = type_

    def _occurs(self, variable: Variable, type_: Type) -> bool:
        """Whether *variable* occurs in *type_*; lowers the levels of what occurs there to that of *variable*."""
        level = variable.level
        for head in subtypes(type_):
            self.step()
            if type(head) is Variable:
                if head is variable:
                    return True
                if head.level > level:
                    self.save(head)
                    head.level = level
            elif type(head) is Rigid and head.level > level:
                raise CannotUnify(Clash.ESCAPES, variable, head)
        return False

    # --- dots ------------------------------------------------------------------------------------------------

    def _unify_dots(self, expected: Type, actual: Type) -> None:
        """Unify two types of which at least one is a dot.

        Against a finished type, the head of the dot must be what turns the rest into it; that is tried first, since
        it knows how many fields are wanted. Against an extendable the dot is shortened first, field by field.
        """
        if type(expected) is Dot and type(actual) is Dot:
            self._match(parts(expected), parts(actual))
            return
        other = actual if type(expected) is Dot else expected
        if type(other) in (SetOf, SequenceOf, MapOf, TupleOf, Function) or other in (INT, BOOL, CHAR, PROC):
            raise CannotUnify(Clash.DIFFERENT, expected, actual)
        if type(expected) is Dot and self._whole_dots:
            self._unify_shortened(expected, actual, Clash.SPLITS)
            return
        attempts = [self._unify_applied, self._unify_shortened]
        if type(other) is Extendable:
            attempts.reverse()
        mark = self.mark()
        try:
            attempts[0](expected, actual, Clash.SURPLUS)
        except TypeClash as first:
            self.rollback(mark)
            try:
                attempts[1](expected, actual, Clash.SURPLUS)
            except TypeClash as second:
                telling = isinstance(second, CannotUnify) and second.clash is Clash.SURPLUS
                raise (second if telling else first) from None

    def _unify_applied(self, expected: Type, actual: Type, _clash: Clash) -> None:
        """Unify a dot with another type by giving its head the type ``rest => other``."""
        whole, other = (expected, actual) if type(expected) is Dot else (actual, expected)
        head, *rest = parts(whole)
        wanted = Dotable(dotted(rest), other)
        if type(head) not in (Variable, Dotable, Extendable):
            raise CannotUnify(Clash.DIFFERENT, expected, actual)
        if whole is expected:
            self.unify(head, wanted)
        else:
            self.unify(wanted, head)

    def _unify_shortened(self, expected: Type, actual: Type, clash: Clash) -> None:
        """Unify a dot with another type by absorbing in it what can be absorbed; raises *clash* if more is left."""
        whole, other = (expected, actual) if type(expected) is Dot else (actual, expected)
        items = parts(whole)
        self._reduce(items, longest=type(other) is not Extendable)
        if len(items) > 1:
            if clash is Clash.SURPLUS and items[0] is not EVENT and type(items[0]) is not Datatype:
                clash = Clash.DIFFERENT
            raise CannotUnify(clash, expected, actual)
        if whole is expected:
            self.unify(items[0], actual)
        else:
            self.unify(expected, items[0])

    def _match(self, left: list[Type], right: list[Type]) -> None:
        """Unify two lists of components, both with at least one item; the lists are used up."""
        while True:
            _flatten_head(left)
            _flatten_head(right)
            if len(left) == 1 or len(right) == 1:
                self.unify(dotted(left), dotted(right))
                return
            if self._absorb(left, longest=True) or self._absorb(right, longest=True):
                continue
            left_waits = type(left[0]) is Dotable
            right_waits = type(right[0]) is Dotable
            if not left_waits and not right_waits:
                self.unify(left.pop(0), right.pop(0))
                continue
            # A last variable stands for the fields that the head still wants and for what is left behind it.
            if left_waits:
                fields, result = spread(left[0])
                self._reduce(right, longest=True)
                self.unify(result, right[0])
                self.unify(left[1], dotted(fields + right[1:]))
            else:
                fields, result = spread(right[0])
                self._reduce(left, longest=True)
                self.unify(left[0], result)
                self.unify(dotted(fields + left[1:]), right[1])
            return

    def _absorb(self, items: list[Type], longest: bool) -> bool:
        """Let the head of *items* take what stands behind it, if what it takes is determined.

        A last variable is not determined here: how much it stands for depends on where the list is used.
        """
        head, second = items[0], resolve(items[1])
        if type(head) is Dotable:
            wanted, rest = _first_field(head)
            if type(second) is Extendable:
                self.unify(wanted, second.result)
                items[0:2] = [Extendable(second.row, rest)]
                return True
            if type(second) is Dot:
                items[1:2] = parts(second)
                return True
            if type(second) is Dotable and type(wanted) is not Dotable:
                fields, result = spread(second)
                self.unify(wanted, result)
                items[0:2] = [dotable(fields, rest)]
                return True
            if type(second) is Variable and len(items) == 2:
                return False
            self.unify(wanted, second)
            items[0:2] = [resolve(rest)]
            return True
        if type(head) is Extendable and type(head.row) is Variable and not longest:
            rest_row = Variable(head.row.level)
            self.close(head, Row(second, rest_row))
            items[0:2] = [Extendable(rest_row, head.result)]
            return True
        return False

    def _reduce(self, items: list[Type], longest: bool) -> None:
        """Absorb as far as possible, in place.

        With *longest*, a last variable takes every field that is left, and an open end is closed. Without, it takes
        one field.
        """
        done = 0
        while done + 1 < len(items):
            tail = items[done:]
            while len(tail) > 1 and self._absorb(tail, longest):
                _flatten_head(tail)
            head = tail[0]
            if len(tail) == 2 and type(head) is Dotable and type(tail[1]) is Variable:
                if longest:
                    fields, result = spread(head)
                    self.unify(dotted(fields), tail[1])
                    tail = [result]
                else:
                    wanted, rest = _first_field(head)
                    self.unify(wanted, tail[1])
                    tail = [resolve(rest)]
            elif len(tail) > 1 and type(head) is Extendable and longest and type(head.row) is Variable:
                behind = tail[1:]
                self._reduce(behind, longest)
                row: Type = NOTHING
                for field in reversed(behind):
                    row = Row(field, row)
                self.close(head, row)
                tail = [resolve(head.result)]
            items[done:] = tail
            done += 1

    def settle(self, type_: Type) -> Type:
        """*type_* with every dot in it that can be absorbed absorbed, by the longest match."""
        return self._settle(type_, {})

    def _settle(self, type_: Type, settled_before: dict[int, Type]) -> Type:
        """Like :meth:`settle`; shared parts, by their identity, are settled once."""
        head = resolve(type_)
        if type(head) in (Variable, Atom, Datatype, Rigid, Dotable, Extendable):
            return head
        if type(head) is Dot:
            items = parts(head)
            self._reduce(items, longest=True)
            return dotted(items)
        before = settled_before.get(id(head))
        if before is not None:
            return before
        self.step()
        below = components(head)
        settled = [self._settle(part, settled_before) for part in below]
        result = head
        for old, new in zip(below, settled, strict=True):
            if old is not new:
                result = rebuilt(head, settled)
                break
        settled_before[id(head)] = result
        return result

    def misfit(self, type_: Type) -> CannotUnify | None:
        """What is wrong with the fields of a dotted type, however long its open parts are. Binds nothing."""
        mark = self.mark()
        try:
            self._reduce(parts(type_), longest=False)
        except CannotUnify as clash:
            return clash
        except (InfiniteType, Unsatisfied, TypeTooLarge):
            # An open part may still turn out to stand for more fields than the one that it was given here.
            return None
        finally:
            self.rollback(mark)
        return None

    # --- channels and constructors that want fields -----------------------------------------------------------

    def _unify_dotables(self, expected: Dotable, actual: Dotable) -> None:
        left, left_result = spread(expected)
        right, right_result = spread(actual)
        left_open = type(left_result) is Extendable
        right_open = type(right_result) is Extendable
        if not left_open and not right_open:
            self.unify(left_result, right_result)
            self._match(left, right)
            return
        self._reduce(left, longest=False)
        self._reduce(right, longest=False)
        left_end = left_result.result if type(left_result) is Extendable else left_result
        right_end = right_result.result if type(right_result) is Extendable else right_result
        self.unify(left_end, right_end)
        # Field by field, as far as both lists are known; what is left over belongs to the open end of the other.
        while left and right:
            if len(left) == 1 and not left_open and type(resolve(left[0])) is Variable and len(right) > 1:
                self.unify(left[0], dotted(right))
                left, right = [], []
                break
            if len(right) == 1 and not right_open and type(resolve(right[0])) is Variable and len(left) > 1:
                self.unify(dotted(left), right[0])
                left, right = [], []
                break
            one, other = left.pop(0), right.pop(0)
            self.unify(spread(one)[1], spread(other)[1])
        if left_open and right_open:
            if left:
                self._give_row(right_result, left, left_result)
            elif right:
                self._give_row(left_result, right, right_result)
            else:
                self._unify_rows(left_result, right_result)
        elif left_open and not left:
            self._give_row(left_result, right, None)
        elif right_open and not right:
            self._give_row(right_result, left, None)
        else:
            raise CannotUnify(Clash.DIFFERENT, expected, actual)

    def _give_row(self, open_end: Type, fields: Sequence[Type], rest: Type | None) -> None:
        """Let the row of *open_end* be *fields*, then the row of *rest* (nothing if it is None)."""
        head = resolve(open_end)
        if type(head) is not Extendable or head is not open_end:
            # Unifying what stood in front has said something of the row meanwhile.
            end = rest if rest is not None else spread(head)[1]
            self.unify(head, dotable(fields, end.result if rest is None and type(end) is Extendable else end))
            return
        row: Type = rest.row if type(rest) is Extendable else NOTHING
        for field in reversed(fields):
            row = Row(field, row)
        self.close(head, row)

    def close(self, open_end: Extendable, row: Type) -> None:
        """Bind the open row of *open_end* to *row*."""
        if type(open_end.row) is not Variable:
            raise CannotUnify(Clash.ESCAPES, open_end.row, row)
        if type(row) is not Atom and self._occurs(open_end.row, row):
            raise InfiniteType(open_end.row, Extendable(row, open_end.result))
        self.save(open_end.row)
        open_end.row.binding = row

    def _unify_rows(self, expected: Type, actual: Type) -> None:
        """Make the open rows of two extendables the same one."""
        expected, actual = resolve(expected), resolve(actual)
        if type(expected) is not Extendable or type(actual) is not Extendable:
            self.unify(expected, actual)
        elif expected.row is not actual.row:
            if type(expected.row) is Variable:
                self.close(expected, actual.row)
            else:
                self.close(actual, expected.row)

    def _extend(self, open_end: Extendable, other: Type, extendable_expected: bool) -> None:
        """Unify an extendable with a dotable or a finished type."""
        fields, result = spread(other)
        if extendable_expected:
            self.unify(open_end.result, result.result if type(result) is Extendable else result)
        else:
            self.unify(result.result if type(result) is Extendable else result, open_end.result)
        self._give_row(open_end, fields, result)


def _has_dots(type_: Type) -> bool:
    return any(type(part) is Dot for part in subtypes(type_))


def _flatten_head(items: list[Type]) -> None:
    """Resolve the first item in place; a dot is replaced by its components."""
    items[0:1] = parts(items[0])


def _first_field(head: Dotable) -> tuple[Type, Type]:
    """The first field that *head* wants, and what it is then."""
    fields = parts(head.argument)
    if len(fields) == 1:
        return fields[0], head.result
    return fields[0], Dotable(dotted(fields[1:]), head.result)
