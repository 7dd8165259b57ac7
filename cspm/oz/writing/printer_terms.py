"""Terms as documents, with brackets where the tree needs them and has none.

For every tree that the parser makes, what is printed gives the same tree: its ``Grouped`` nodes are the brackets, and
no others are needed. A term is printed knowing how tightly it must bind (``least``), the sign that follows it, for
what extends to the right (quantifiers, ``if``, ``not``) must not swallow that, and whether a bare ``>`` would close a
sequence around it.

Lines are broken behind operators, and before logical ones, where the reader goes on in any case.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Final

from cspcheck.cspm.oz import syntax as z
from cspcheck.cspm.oz.reading.lexer import BINDERS, INFIX, PREFIX
from cspcheck.cspm.oz.reading.operators import (
    APPLICATION,
    BY_NAME,
    IFF,
    INREL,
    NUMBER_SETS,
    POSTFIX,
    PREFIX as PREFIX_LEVEL,
    RELATION,
    Spelling,
    relation,
)
from cspcheck.cspm.printing.layout import HARD, LINE, SOFT, Doc, cat, first_text, group, join, nest
from cspcheck.cspm.syntax.tree import NameDeclaration, Node

LOGICAL: Final = frozenset(["iff", "implies", "or", "and"])
_KEPT: Final = frozenset(["-", "*", "~", ".."])
"""Signs whose symbols look no better."""

_BEFORE_SIGN: Final = 96
_ARGUMENT: Final = 100
"""Levels of what stands before a postfix operator, and of an argument without brackets."""

_WORD_NAMES: Final = frozenset(word for word in PREFIX if word.isalnum())


@dataclass(frozen=True, slots=True)
class TermPlace:
    """Where a term is printed: see the module.

    ``follow`` is the kind of the sign behind it, empty for none; ``behind`` tells that it stands directly behind an
    operand, where ``<`` would compare and ``[[`` would give generic parameters.
    """

    least: int = 0
    follow: str = ""
    in_sequence: bool = False
    behind: bool = False


ANYWHERE: Final = TermPlace()


class TermPrinter:
    """Prints terms.

    Args:
        symbols: whether mathematical symbols are written where there are any.
        broken: whether the layout should break between two nodes because the source does.
        separate: whether two conjuncts stand on lines of their own in the source instead of being joined by ``and``.
    """

    def __init__(
        self,
        symbols: bool = False,
        broken: Callable[[Node, Node], bool] = lambda first, second: False,
        separate: Callable[[Node, Node], bool] = lambda first, second: False,
    ) -> None:
        self.symbols = symbols
        self.broken = broken
        self.separate = separate

    from_source = False
    """Whether spans are places in a source that is printed anew: what has two forms is written as it stands there."""

    def written(self, spelling: Spelling) -> str:
        """How an operator is written."""
        text = spelling.text[0]
        return spelling.symbol[0] if self.symbols and spelling.symbol and text not in _KEPT else text

    def sign(self, ascii_sign: str, symbol: str) -> str:
        """A sign in the notation that is asked for."""
        return symbol if self.symbols else ascii_sign

    def term(self, node: z.Term, place: TermPlace = ANYWHERE) -> Doc:
        """The document of a term."""
        match node:
            case z.Reference():
                return self._reference(node, place)
            case z.Number():
                return _number(node, place)
            case z.Truth():
                return "true" if node.value else "false"
            case z.Grouped():
                return bracketed(self.term(node.inner))
            case z.Operator():
                return self._operator(node, place)
            case z.Chain():
                return self._chain(node, place)
            case z.Application():
                return self._application(node, place)
            case z.Selection():
                record = self.term(node.record, TermPlace(_BEFORE_SIGN, behind=place.behind))
                if isinstance(node.record, z.Number) and node.field.isdigit():
                    record = bracketed(record)
                return cat(record, f".{node.field}{node.decoration}")
            case z.Display():
                return self._display(node, place)
            case z.BindingDisplay():
                fields = [cat(f"{name.name} == ", self.term(value)) for name, value in node.fields]
                return enclosed("(| ", fields, " |)")
            case z.Binding(kind="set"):
                return self._comprehension(node)
            case z.Binding():
                return self._binding(node, place)
            case z.Quantified():
                return self._quantified(node, place)
            case z.Conditional():
                return self._conditional(node, place)
            case z.Local():
                return self._local(node, place)
            case z.SchemaText():
                return self._schema_text(node)
            case z.Renamed():
                renamings = [f"{new.name}{new.decoration}/{old.name}{old.decoration}" for new, old in node.renamings]
                inner = self.term(node.term, TermPlace(_BEFORE_SIGN, behind=place.behind))
                return cat(inner, enclosed("[", list(renamings), "]"))
        raise AssertionError(node)

    # --- operands --------------------------------------------------------------------------------------------

    def _reference(self, node: z.Reference, place: TermPlace) -> Doc:
        name = node.name
        if self.symbols and name in NUMBER_SETS and not node.decoration:
            name = NUMBER_SETS[name][0]
        doc: Doc = f"{name}{node.decoration}"
        if node.arguments:
            return cat(doc, enclosed("[", [self.term(argument) for argument in node.arguments], "]"))
        # A word such as `id` is a name only where nothing follows that it could be applied to.
        is_word = node.name in _WORD_NAMES and not node.decoration
        applies = place.least in (APPLICATION, POSTFIX, _ARGUMENT) or place.follow == "<"
        return cat("(", doc, ")") if is_word and applies else doc

    def _display(self, node: z.Display, place: TermPlace) -> Doc:
        match node.kind:
            case "tuple":
                return enclosed("(", [self.term(item) for item in node.items], ")")
            case "set":
                return self._set(node)
            case "sequence":
                opening, closing = ("⟨", "⟩") if self.symbols or place.behind else ("<", ">")
                return enclosed(opening, [self.term(item, TermPlace(in_sequence=True)) for item in node.items], closing)
            case "bag":
                opening, closing = ("⟦", "⟧") if self.symbols or place.behind else ("[[", "]]")
                return enclosed(opening, [self.term(item) for item in node.items], closing)

    def _set(self, node: z.Display) -> Doc:
        if not node.items:
            as_written = self.from_source and node.span.text == "∅"
            return "∅" if as_written else "{}" if self.from_source else self.sign("{}", "∅")
        items = [self.term(item) for item in node.items]
        # `{-` opens a comment unless a number and then `,`, `..` or `}` follow.
        first: z.Term = node.items[0]
        if isinstance(first, z.Operator) and first.name == "range":
            first = first.operands[0]
        harmless = isinstance(first, z.Operator) and first.name == "negate" and isinstance(first.operands[0], z.Number)
        blank = first_text(items[0]).startswith("-") and not harmless
        return enclosed("{ " if blank else "{", items, "}")

    # --- operators -------------------------------------------------------------------------------------------

    def _operator(self, node: z.Operator, place: TermPlace) -> Doc:
        if node.name == "image":
            relation = self.term(node.operands[0], TermPlace(POSTFIX, behind=place.behind))
            return group(relation, "(| ", nest(self.term(node.operands[1])), " |)")
        if len(node.operands) == 1:
            postfix = BY_NAME.get((node.name, "postfix"))
            if postfix is not None:
                operand = self.term(node.operands[0], TermPlace(_BEFORE_SIGN, behind=place.behind))
                return cat(operand, self.written(postfix))
            return self._prefix(BY_NAME[node.name, "prefix"], node.operands[0], place)
        spelling = BY_NAME[node.name, "infix"]
        if node.name == "cross":
            return self._row(node, node.operands, [spelling] * (len(node.operands) - 1), spelling.precedence, place)
        return self._infix(node, spelling, place)

    def _prefix(self, spelling: Spelling, operand: z.Term, place: TermPlace) -> Doc:
        least = spelling.precedence + (spelling.precedence == RELATION)
        brackets = place.least >= APPLICATION or precedence_of(place.follow) >= least
        inside = ANYWHERE if brackets else place
        doc = self.term(operand, replace(inside, least=least))
        word = self.written(spelling)
        clash = False
        if first_text(doc).startswith("-"):
            # Two signs would open a comment; behind a word the sign would be infix.
            clash = word == "-"
            if spelling.text[0] in _WORD_NAMES:
                doc = bracketed(doc)
        doc = cat(word, " " if word[0].isalpha() or clash else "", doc)
        return bracketed(doc) if brackets else doc

    def _infix(self, node: z.Operator, spelling: Spelling, place: TermPlace) -> Doc:
        """An operator that associates, with all the operands that its side of association shares."""
        level = spelling.precedence
        brackets = level < place.least or (place.in_sequence and spelling.text[0].startswith(">"))
        inside = ANYWHERE if brackets else place
        left_first = spelling.associativity == "left"
        operands: list[z.Term] = []
        spellings: list[Spelling] = []
        rest: z.Term = node
        while isinstance(rest, z.Operator) and _infix_level(rest) == level and rest.name != "cross":
            found = BY_NAME[rest.name, "infix"]
            if inside.in_sequence and found.text[0].startswith(">"):
                break
            spellings.append(found)
            left, right = rest.operands
            operands.append(right if left_first else left)
            rest = left if left_first else right
        operands.append(rest)
        if left_first:
            operands.reverse()
            spellings.reverse()
        doc = self._joined(operands, spellings, inside, level, at_end=None if left_first else level)
        return bracketed(doc) if brackets else doc

    def _chain(self, node: z.Chain, place: TermPlace) -> Doc:
        spellings = [relation(name) for name in node.relations]
        return self._row(node, node.operands, spellings, RELATION, place)

    def _row(
        self, node: z.Term, operands: Sequence[z.Term], spellings: Sequence[Spelling], level: int, place: TermPlace
    ) -> Doc:
        """Operands none of which may have an operator of the same level."""
        closes = place.in_sequence and any(spelling.text[0].startswith(">") for spelling in spellings)
        brackets = level < place.least or closes
        doc = self._joined(operands, spellings, ANYWHERE if brackets else place, level + 1, at_end=level + 1)
        return bracketed(doc) if brackets else doc

    def _joined(
        self,
        operands: Sequence[z.Term],
        spellings: Sequence[Spelling],
        place: TermPlace,
        first: int,
        at_end: int | None,
    ) -> Doc:
        """Operands with operators between them.

        The leftmost operand must bind as tightly as *first*, the last as *at_end*, the others more tightly than
        their operators. With *at_end* None the operators associate to the left, else to the right or not at all.
        """
        level = spellings[0].precedence
        parts: list[Doc] = []
        broken = False
        for number, operand in enumerate(operands):
            last = number == len(operands) - 1
            if at_end is None:
                least = first if number == 0 else level + 1
            else:
                least = at_end if last else level + 1
            # A relation with a name is known by its first word.
            follow = place.follow if last else spellings[number].text[0].split()[0]
            doc = self.term(operand, replace(place, least=least, follow=follow))
            if number:
                parts += self._sign(spellings[number - 1], operands[number - 1], operand)
                if spellings[number - 1].name in LOGICAL:
                    broken = broken or self.broken(operands[number - 1], operand)
            parts.append(doc)
        return group(parts[0], nest(cat(*parts[1:])), broken=broken)

    def _sign(self, spelling: Spelling, left: z.Term, right: z.Term) -> list[Doc]:
        word = self.written(spelling)
        if spelling.name == "range":
            return [word]
        if spelling.name in LOGICAL:
            if spelling.name == "and" and self.separate(left, right):
                return [HARD]
            return [LINE, word, " "]
        if word.startswith("--"):  # at the end of a line it would be a comment
            return [" ", word, " "]
        return [" ", word, LINE]

    def _application(self, node: z.Application, place: TermPlace) -> Doc:
        if node.bracketed:
            function = self.term(node.function, TermPlace(POSTFIX, behind=place.behind))
            argument = node.argument
            if isinstance(argument, z.Display) and argument.kind == "tuple":
                return cat(function, enclosed("(", [self.term(item) for item in argument.items], ")"))
            return cat(function, enclosed("(", [self.term(argument)], ")"))
        brackets = place.least > APPLICATION
        juxtaposed = isinstance(node.function, z.Application) and not node.function.bracketed
        number = isinstance(node.function, z.Number | z.Truth)
        function = self.term(node.function, TermPlace(APPLICATION if juxtaposed else POSTFIX))
        if number:
            function = cat("(", function, ")")
        doc = cat(function, " ", self.term(node.argument, TermPlace(_ARGUMENT, behind=True)))
        return bracketed(doc) if brackets else doc

    # --- what extends to the right ---------------------------------------------------------------------------

    def _schema_text(self, node: z.SchemaText) -> Doc:
        last = TermPlace(follow="|" if node.predicates else "")
        parts = [self.bound(node.declarations, last)]
        if node.predicates:
            predicates = [self.term(p, TermPlace(follow=";")) for p in node.predicates]
            parts += [" |", LINE, join(cat(";", LINE), predicates)]
        return group("[", nest(cat(*parts)), "]")

    def bound(self, declarations: Sequence[z.Declare], place: TermPlace) -> Doc:
        """Declarations of a binder; *place* says what is behind them."""
        last = len(declarations) - 1
        docs = [
            self.declare(declaration, place if number == last else replace(place, follow=";"))
            for number, declaration in enumerate(declarations)
        ]
        return join(cat(";", LINE), docs)

    def declare(self, node: z.Declare, place: TermPlace = ANYWHERE) -> Doc:
        """``x, y : T``, or the schema that is included."""
        if not node.names:
            return self.term(node.carrier, place)
        names = ", ".join(f"{name.name}{name.decoration}" for name in node.names)
        sign = ":"
        if self.from_source:
            between = node.span.source.text[node.names[-1].span.end : node.carrier.span.start]
            # In a quantifier it may be written `x in T`.
            sign = ":" if ":" in between else "in"
        return group(names, f" {sign} ", nest(self.term(node.carrier, place)))

    def _parts(self, node: z.Binding | z.Quantified, place: TermPlace) -> list[Doc]:
        """Declarations, condition and body with the signs between them; *place* is that of the end."""
        after = "|" if node.condition is not None else "@" if node.body is not None else place.follow
        place = replace(place, least=0)
        parts: list[Doc] = [self.bound(node.declarations, replace(place, follow=after))]
        if node.condition is not None:
            end = replace(place, follow="@") if node.body is not None else place
            parts += [" |", LINE, self.term(node.condition, end)]
        if node.body is not None:
            parts += [self.sign(" @", " •"), LINE, self.term(node.body, place)]
        return parts

    def _comprehension(self, node: z.Binding) -> Doc:
        return group("{", nest(cat(*self._parts(node, ANYWHERE))), "}")

    def _binding(self, node: z.Binding, place: TermPlace) -> Doc:
        captures = node.body is None and (
            place.follow == "@" or (node.condition is None and place.follow in ("|", ";"))
        )
        brackets = captures or _needs_end(place)
        inside = ANYWHERE if brackets else place
        doc = self._opened(node.kind, self._parts(node, inside))
        return bracketed(doc) if brackets else doc

    def _opened(self, word: str, parts: Iterable[Doc]) -> Doc:
        return group(BINDERS[word] if self.symbols else word, " ", nest(cat(*parts)))

    def _quantified(self, node: z.Quantified, place: TermPlace) -> Doc:
        brackets = _needs_end(place)
        doc = self._opened(node.kind, self._parts(node, ANYWHERE if brackets else place))
        return bracketed(doc) if brackets else doc

    def _conditional(self, node: z.Conditional, place: TermPlace) -> Doc:
        brackets = _needs_end(place)
        inside = replace(ANYWHERE if brackets else place, least=0)
        test = self.term(node.test, replace(inside, follow="then"))
        then = self.term(node.then, replace(inside, follow="else"))
        otherwise = self.term(node.otherwise, inside)
        broken = self.broken(node.test, node.then) or self.broken(node.then, node.otherwise)
        # Conjuncts on lines of their own stand under the first one.
        branches = cat(LINE, "then ", nest(then, 3), LINE, "else ", nest(otherwise, 3))
        doc = group("if ", nest(test), nest(branches), broken=broken)
        return bracketed(doc) if brackets else doc

    def _local(self, node: z.Local, place: TermPlace) -> Doc:
        brackets = _needs_end(place)
        inside = replace(ANYWHERE if brackets else place, least=0)
        last = len(node.definitions) - 1
        definitions = [
            cat(f"{name.name} == ", self.term(value, replace(inside, follow="@" if number == last else ";")))
            for number, (name, value) in enumerate(node.definitions)
        ]
        body = self.term(node.body, inside)
        sign = self.sign(" @", " •")
        doc = group("let ", nest(cat(join(cat(";", LINE), definitions), sign, LINE, body)))
        return bracketed(doc) if brackets else doc


def _needs_end(place: TermPlace) -> bool:
    """Whether what extends to the right needs brackets to end."""
    return place.least >= APPLICATION or precedence_of(place.follow) >= IFF


def precedence_of(sign: str) -> int:
    """How tightly the infix operator binds that a sign is; -1 for any other sign."""
    if sign == INREL.strip():
        return RELATION
    spelling = INFIX.get(sign)
    return -1 if spelling is None else spelling.precedence


def _infix_level(node: z.Operator) -> int:
    spelling = BY_NAME.get((node.name, "infix")) if len(node.operands) > 1 else None
    return -1 if spelling is None else spelling.precedence


def _number(node: z.Number, place: TermPlace) -> Doc:
    value = node.value
    text = str(value) if isinstance(value, int) else decimal(value)
    return bracketed(text) if value < 0 and place.least > PREFIX_LEVEL else text


def decimal(value: Fraction) -> str:
    """A fraction with a decimal point; as a quotient if its digits would not end."""
    denominator, places = value.denominator, 0
    while denominator % 10 == 0 or denominator % 2 == 0 or denominator % 5 == 0:
        denominator //= 10 if denominator % 10 == 0 else 2 if denominator % 2 == 0 else 5
        places += 1
    if denominator != 1:
        return f"({value.numerator}.0 / {value.denominator}.0)"
    digits = str(abs(value.numerator) * 10**places // value.denominator).rjust(places + 1, "0")
    whole, part = (digits[:-places], digits[-places:]) if places else (digits, "0")
    sign = "-" if value < 0 else ""
    return f"{sign}{whole}.{part.rstrip('0') or '0'}"


def bracketed(doc: Doc) -> Doc:
    """The document in round brackets."""
    return group("(", nest(cat(SOFT, doc)), SOFT, ")")


def enclosed(opening: str, docs: Sequence[Doc], closing: str) -> Doc:
    """Items in brackets: on one line, or each on its own."""
    if not docs:
        return opening.rstrip() + closing.lstrip()
    return group(opening, nest(join(cat(",", LINE), docs)), closing)


def names(declarations: Sequence[NameDeclaration]) -> str:
    """Names with commas."""
    return ", ".join(name.name for name in declarations)
