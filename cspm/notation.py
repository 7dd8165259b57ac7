"""What an extension brings to CSPm: the register through which the core meets notations that it does not know.

A notation with paragraphs of its own inside scripts derives from :class:`Extension` and registers itself once with
:func:`register`; the core asks :func:`extension` wherever a paragraph, a claim about one, or an expression that stands
for one may turn up. Without an extension there are no paragraphs. The hooks import what they need when they are
called, so a script of plain CSPm never loads an extension.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, Protocol, TypeAlias

if TYPE_CHECKING:
    from cspcheck.cspm.diagnostics import Diagnostic
    from cspcheck.cspm.naming.symbols import Names
    from cspcheck.cspm.parsing.lexer import Tokens
    from cspcheck.cspm.printing.declarations import Printer
    from cspcheck.cspm.printing.patterns import Printing
    from cspcheck.cspm.source import Source, Span
    from cspcheck.cspm.syntax import tree as syntax
    from cspcheck.cspm.typing.inference.context import InferenceContext
    from cspcheck.cspm.typing.types import Type


View: TypeAlias = Literal["data", "control"]
Outputs: TypeAlias = Literal["demonic", "angelic"]


@dataclass(frozen=True, slots=True)
class ClassReading:
    """How classes are read.

    Attributes:
        view: ``control`` drops the data and keeps the process equations; None: as the script says.
        outputs: ``demonic``: the class chooses them; ``angelic``: the environment does.
    """

    view: View | None = None
    outputs: Outputs = "demonic"


class Paragraphs(Protocol):
    """What the paragraphs of one script mean, as far as the core needs to know."""

    @property
    def warnings(self) -> tuple[Diagnostic, ...]:
        """What is odd about them."""

    @property
    def control(self) -> bool:
        """Whether their data is dropped."""

    @property
    def has_left(self) -> bool:
        """Whether evaluation has met something outside the finite readings of wide types."""

    def chosen(self, readings: Sequence[str]) -> bool:
        """Whether one of some readings is no reading of the script, but a choice that was made for it."""

    def readings(self, names: Names, operands: Sequence[syntax.Expr]) -> tuple[str, ...]:
        """The finite readings of wide types that the paragraphs behind some expressions follow, as written."""


class Document(Protocol):
    """A document of another form that holds a script."""

    @property
    def errors(self) -> list[Diagnostic]:
        """What is wrong in it."""

    @property
    def remarks(self) -> list[Diagnostic]:
        """What is odd in it."""

    def script(self) -> syntax.Script | None:
        """The script in it; None if there is none that could be read."""


class Extension:
    """A notation beside CSPm. This one has nothing; what is here is what plain CSPm does at each place.

    Only :meth:`paragraph_end` is asked of every script; the rest is asked where an earlier hook has said yes.
    """

    # --- reading ---------------------------------------------------------------------------------------------

    def paragraph_end(self, tokens: Tokens, begin: int, *, free: bool) -> int | None:
        """The offset behind the paragraph that begins at *begin*, its comments added to *tokens*; None if none does.

        *free* tells whether a declaration begins there in any case.
        """
        return None

    def paragraph(self, source: Source, start: int, end: int) -> tuple[syntax.Declaration, list[Diagnostic]]:
        """The tree of the paragraph in a stretch of a source, with the mistakes in it."""
        raise NotImplementedError

    def document(self, source: Source, include: Callable[[str, Span], tuple[syntax.Declaration, ...]]) -> Document:
        """Read a file that is no script but holds one."""
        raise NotImplementedError

    def obligations(self, **fields: Any) -> syntax.Assertion:
        """The claim that proof obligations of a paragraph hold."""
        raise NotImplementedError

    def hints(self, *, names: tuple[syntax.NameDeclaration, ...], **fields: Any) -> syntax.Node:
        """What helps to prove a claim about paragraphs."""
        raise NotImplementedError

    def subtype(self, **fields: Any) -> syntax.Assertion:
        """The claim that one paragraph is a subtype of another."""
        raise NotImplementedError

    def data_refinement(self, **fields: Any) -> syntax.Assertion:
        """The claim that one paragraph refines another under a retrieve relation."""
        raise NotImplementedError

    # --- printing --------------------------------------------------------------------------------------------

    def print_paragraph(self, node: syntax.Paragraph, printer: Printer) -> Printing:
        """A paragraph as a document of the printer."""
        raise NotImplementedError

    def print_claim(self, node: syntax.Assertion) -> str:
        """A claim about paragraphs as text."""
        raise NotImplementedError

    def expanded(self, tokens: Tokens, script: syntax.Script) -> tuple[Tokens, frozenset[int]]:
        """The tokens of a script with those inside paragraphs, and where the latter start."""
        raise NotImplementedError

    # --- meaning ---------------------------------------------------------------------------------------------

    def elaborated(self, tree: syntax.Script, semantics: ClassReading | None) -> tuple[Paragraphs, syntax.Script]:
        """What the paragraphs of a script mean, and the script with what they become in their place.

        Raises:
            ScriptError: a paragraph is wrong.
        """
        raise NotImplementedError

    def foreign_type(self, context: InferenceContext, node: syntax.Foreign) -> Type:
        """The type of an expression that stands for a part of a paragraph.

        Raises:
            Rejected: it has none.
        """
        raise NotImplementedError


_registered: list[Extension] = []
_PLAIN = Extension()


def register(found: Extension) -> None:
    """Have the core ask *found* from now on, instead of whatever was registered before."""
    _registered[:] = [found]


def extension() -> Extension:
    """The notation that is registered, or one that has nothing."""
    return _registered[0] if _registered else _PLAIN
