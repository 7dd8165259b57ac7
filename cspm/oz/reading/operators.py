"""The operators of Object-Z as scripts write them: one canonical name, and every spelling of it.

The readers of both notations, the printer and the LaTeX writer work from this one table. Precedences are those of
the mathematical toolkit of ISO Z (13568), where it has the operator; larger binds tighter. Prefix operators bind
tighter than infix ones, application tighter than prefix operators, postfix operators tightest.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, Literal

Kind = Literal["infix", "prefix", "postfix", "relation"]
Associativity = Literal["left", "right"]


@dataclass(frozen=True, slots=True)
class Spelling:
    """How an operator is written.

    Attributes:
        name: canonical, as in ``syntax.Operator.name`` and ``syntax.Chain.relations``.
        kind: where it stands. Relations form chains (``0 <= x < 10``) and do not associate.
        precedence: larger binds tighter.
        text: spellings in the text notation; the first is what the printer writes in ASCII.
        symbol: Unicode spellings; the first is what the printer writes when symbols are asked for.
        latex: markup; the first is the tidy form, others are read with a style warning.
        associativity: of infix operators.
    """

    name: str
    kind: Kind
    precedence: int
    text: tuple[str, ...]
    symbol: tuple[str, ...]
    latex: tuple[str, ...]
    associativity: Associativity = "left"


IFF: Final = 1
IMPLIES: Final = 2
OR: Final = 3
AND: Final = 4
NOT: Final = 5
RELATION: Final = 6
PREFIX: Final = 80
APPLICATION: Final = 90
POSTFIX: Final = 95


def _infix(
    name: str, precedence: int, text: str, symbol: str, latex: str, associativity: Associativity = "left"
) -> Spelling:
    return Spelling(
        name, "infix", precedence, tuple(text.split()), tuple(symbol.split()), tuple(latex.split()), associativity
    )


def _relation(name: str, text: str, symbol: str, latex: str) -> Spelling:
    return Spelling(name, "relation", RELATION, tuple(text.split()), tuple(symbol.split()), tuple(latex.split()))


def _prefix(name: str, text: str, symbol: str, latex: str, precedence: int = 80) -> Spelling:
    return Spelling(name, "prefix", precedence, tuple(text.split()), tuple(symbol.split()), tuple(latex.split()))


def _postfix(name: str, text: str, symbol: str, latex: str) -> Spelling:
    return Spelling(name, "postfix", 95, tuple(text.split()), tuple(symbol.split()), tuple(latex.split()))


SPELLINGS: Final = (
    # logic
    _infix("iff", IFF, "<=>", "⇔", r"\iff"),
    _infix("implies", IMPLIES, "=>", "⇒", r"\implies \imp \Rightarrow", "right"),
    _infix("or", OR, r"or \/", "∨", r"\lor \vee"),
    _infix("and", AND, r"and /\ ", "∧", r"\land \wedge"),
    _prefix("not", "not", "¬", r"\lnot \neg", NOT),
    # relations
    _relation("equal", "=", "", "="),
    _relation("not_equal", "!= /=", "≠", r"\neq \ne"),
    _relation("less", "<", "", "<"),
    _relation("at_most", "<=", "≤", r"\leq \le"),
    _relation("greater", ">", "", ">"),
    _relation("at_least", ">=", "≥", r"\geq \ge"),
    _relation("in", "in", "∈", r"\in \mem"),
    _relation("notin", "notin", "∉", r"\notin \nem"),
    _relation("subset", "subseteq", "⊆", r"\subseteq"),
    _relation("proper_subset", "subset", "⊂", r"\subset"),
    _relation("prefix", "prefix", "", r"\prefix"),
    _relation("suffix", "suffix", "", r"\suffix"),
    _relation("infix", "infix", "", r"\infix"),
    _relation("in_bag", "inbag", "", r"\inbag"),
    _relation("partition", "partition", "", r"\partition"),
    _prefix("disjoint", "disjoint", "", r"\disjoint", RELATION),
    # function spaces
    _infix("rel", 8, "<->", "↔", r"\rel", "right"),
    _infix("pfun", 8, "-|->", "⇸", r"\pfun", "right"),
    _infix("fun", 8, "-> -->", "→", r"\fun \tfun \to", "right"),
    _infix("pinj", 8, ">-|->", "⤔", r"\pinj", "right"),
    _infix("inj", 8, ">-->", "↣", r"\inj \tinj", "right"),
    _infix("psurj", 8, "-|->>", "⤀", r"\psurj", "right"),
    _infix("surj", 8, "-->>", "↠", r"\surj \tsur", "right"),
    _infix("bij", 8, ">-->>", "⤖", r"\bij", "right"),
    _infix("ffun", 8, "-||->", "⇻", r"\ffun", "right"),
    _infix("finj", 8, ">-||->", "⤕", r"\finj", "right"),
    _infix("cross", 9, "cross", "×", r"\cross \prod \times"),
    # pairs, numbers, sets, sequences
    _infix("maplet", 10, "|->", "↦", r"\mapsto \map"),
    _infix("range", 20, "..", "‥", r"\upto"),
    _infix("symdiff", 25, "symdiff", "⊖", r"\symdiff"),
    _infix("plus", 30, "+", "", "+"),
    _infix("minus", 30, "-", "−", "-"),
    _infix("union", 30, "union", "∪", r"\cup \uni \classuni"),
    _infix("diff", 30, "\\", "∖", r"\setminus \diff"),
    _infix("concat", 30, "^", "⁀ ⌢", r"\cat \frown"),
    _infix("bag_union", 30, "bag_union", "⊎", r"\buni \uplus"),
    _infix("times", 40, "*", "∗ ·", "*"),
    _infix("divide", 40, "/", "", "/"),
    _infix("div", 40, "div", "", r"\div"),
    _infix("mod", 40, "mod", "", r"\mod"),
    _infix("inter", 40, "inter", "∩", r"\cap \int"),
    _infix("filter", 40, "filter", "↾", r"\filter"),
    _infix("compose", 40, "comp", "⨾ ⨟", r"\comp \fcmp"),
    _infix("circ", 40, "circ", "∘", r"\circ"),
    _infix("extract", 45, "extract", "↿", r"\extract", "right"),
    _infix("override", 50, "(+)", "⊕", r"\oplus \fovr"),
    _infix("ran_restrict", 60, "|>", "▷", r"\rres"),
    _infix("ran_subtract", 60, "|/>", "⩥", r"\nrres \rsub"),
    _infix("dom_restrict", 65, "<|", "◁", r"\dres", "right"),
    _infix("dom_subtract", 65, "</|", "⩤", r"\ndres \dsub", "right"),
    # prefix
    _prefix("negate", "-", "−", r"\negate -"),
    _prefix("size", "#", "", r"\#"),
    _prefix("dom", "dom", "", r"\dom dom"),
    _prefix("ran", "ran", "", r"\ran ran"),
    _prefix("id", "id", "", r"\id"),
    _prefix("Union", "bigunion", "⋃", r"\bigcup \duni"),
    _prefix("Inter", "biginter", "⋂", r"\bigcap \dint"),
    _prefix("flatten", "flatten", "", r"\dcat"),
    _prefix("power", "power", "ℙ", r"\power \pset"),
    _prefix("power1", "power1", "ℙ₁", r"\power_1"),
    _prefix("finset", "finset", "𝔽", r"\finset \fset"),
    _prefix("finset1", "finset1", "𝔽₁", r"\finset_1"),
    _prefix("seq", "seq", "", r"\seq"),
    _prefix("seq1", "seq1", "seq₁", r"\seq_1"),
    _prefix("iseq", "iseq", "", r"\iseq"),
    _prefix("bag", "bag", "", r"\bag"),
    _prefix("poly", "poly", "↓", r"\poly"),
    # postfix
    _postfix("inverse", "~", "∼", r"\inv"),
    _postfix("closure", "^+", "⁺", r"\plus \tcl"),
    _postfix("contained", "%own", "©", r"\copyright"),
    _postfix("reflexive_closure", "^*", "", r"\star \rtcl"),
)
"""All operators but those of a special form: application, selection, relational image ``r(| s |)`` (in the tree
``Operator("image", (r, s))``), displays, binders and conditionals.
"""

BY_NAME: Final[Mapping[tuple[str, Kind], Spelling]] = {(s.name, s.kind): s for s in SPELLINGS}

INREL: Final = "inrel "
"""What the canonical name of a relation that is a name begins with: ``x inrel R y`` is ``(x, y) in R``."""


def relation(name: str) -> Spelling:
    """The spelling of a relation by its canonical name."""
    return inrel(name.removeprefix(INREL)) if name.startswith(INREL) else BY_NAME[name, "relation"]


def inrel(name: str) -> Spelling:
    """The spelling of the relation that a name, perhaps decorated, stands for."""
    return Spelling(INREL + name, "relation", RELATION, (INREL + name,), (), ())


NUMBER_SETS: Final[Mapping[str, tuple[str, str]]] = {
    "nat": ("ℕ", r"\nat"),
    "nat1": ("ℕ₁", r"\nat_1"),
    "int": ("ℤ", r"\num"),
    "real": ("ℝ", r"\real"),
    "bool": ("𝔹", r"\bool"),
}
"""Sets that have names of their own, with symbol and markup; ``num`` is read as ``int``."""

FUNCTIONS: Final = (
    *("head", "tail", "last", "front", "rev", "squash", "items", "count"),
    *("min", "max", "abs", "succ", "floor", "first", "second"),
)
"""Functions of the toolkit that are applied like any other; a script may give their names another meaning."""
