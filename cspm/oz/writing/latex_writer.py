r"""Writing scripts as LaTeX documents in the markup of ``oz.sty``.

Terms are printed in the text notation, with its brackets and line breaks, and then marked up token by token; boxes
come from the tree. What :mod:`cspcheck.cspm.oz.reading.latex_reader` makes of the result is the same tree. The rest
of a script, its CSPm, goes as it is into environments ``cspm``.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Final

from cspcheck.cspm.oz import syntax as z
from cspcheck.cspm.oz.reading.latex_commands import COMMANDS, CSP_SIGNS, WORDS
from cspcheck.cspm.oz.reading.lexer import BINDERS, NAMING, OPERAND_ENDS, PREFIX, Scan, Token, tokens
from cspcheck.cspm.oz.reading.operators import NUMBER_SETS, SPELLINGS
from cspcheck.cspm.oz.writing.printer import ParagraphPrinter
from cspcheck.cspm.oz.writing.printer_terms import ANYWHERE
from cspcheck.cspm.parsing.lexer import tokenise
from cspcheck.cspm.printing.layout import Doc, lay_out
from cspcheck.cspm.printing.printer import print_expression, print_script
from cspcheck.cspm.recursion import deep_recursion
from cspcheck.cspm.source import Source
from cspcheck.cspm.syntax import tree as s

WIDTH: Final = 76
"""Columns of the text notation that a line of a box has, where that is possible."""

INITIALLY: Final = r"\initially"
"""Begins what a schema says of its initial values."""

PREAMBLE: Final = r"""\documentclass{article}
\usepackage{oz}
\usepackage{verbatim}
% What oz.sty has not: the CSP part of classes, and what is said about a specification.
\newenvironment{cspm}{\verbatim}{\endverbatim}
\newenvironment{retrieve}[3]{\begin{schema}{#1 \mathrel{\mathsf{between}} #2 \mathrel{\mathsf{and}} #3}}{\end{schema}}
\providecommand{\chan}{\mathsf{chan}~}
\providecommand{\method}{\mathsf{method}~}
\providecommand{\localchan}{\mathsf{local\_chan}~}
\providecommand{\inherit}{\mathsf{inherit}~}
\providecommand{\main}{\mathsf{main}}
\newenvironment{ozlemma}[1]{\begin{schema}{\mathsf{lemma}~#1}}{\end{schema}}
\providecommand{\using}{\mathsf{using}~}
\providecommand{\induction}{\mathsf{by~induction~on}~}
\providecommand{\initially}{\mathit{INIT}}
\providecommand{\reading}{\mathsf{reading}~}
\providecommand{\view}{\mathsf{view}~}
\providecommand{\mathbb}[1]{\mathsf{#1}}
\providecommand{\real}{\mathbb{R}}
\providecommand{\bool}{\mathbb{B}}
\providecommand{\negate}{-}
\providecommand{\symdiff}{\mathbin{\ominus}}
\providecommand{\extract}{\mathbin{\upharpoonleft}}
\providecommand{\prefix}{\mathrel{\mathsf{prefix}}}
\providecommand{\suffix}{\mathrel{\mathsf{suffix}}}
\providecommand{\infix}{\mathrel{\mathsf{in}}}
\providecommand{\inrel}[1]{\mathrel{\underline{#1}}}
\providecommand{\partition}{\mathrel{\mathsf{partition}}}
\providecommand{\disjoint}{\mathop{\mathsf{disjoint}}}
\providecommand{\inbag}{\mathrel{\mathsf{in}}}
\providecommand{\iseq}{\mathop{\mathsf{iseq}}}
\providecommand{\poly}{\mathop{\downarrow}}
\providecommand{\dcat}{\mathop{{}^{\frown}/}}
\providecommand{\lbag}{[\![}
\providecommand{\rbag}{]\!]}
\providecommand{\buni}{\mathbin{\uplus}}
\providecommand{\ldata}{\langle\!\langle}
\providecommand{\rdata}{\rangle\!\rangle}
\providecommand{\inv}{^{\sim}}
\providecommand{\plus}{^{+}}
\providecommand{\IF}{\mathrel{\mathsf{if}}}
\providecommand{\THEN}{\mathrel{\mathsf{then}}}
\providecommand{\ELSE}{\mathrel{\mathsf{else}}}
\providecommand{\LET}{\mathop{\mathsf{let}}}
\providecommand{\true}{\mathsf{true}}
\providecommand{\false}{\mathsf{false}}
\providecommand{\semi}{\mathbin{;}}
\providecommand{\pll}{\mathbin{\|}}
\providecommand{\gch}{\mathbin{\Box}}
\providecommand{\visibility}{\upharpoonright}
\providecommand{\then}{\rightarrow}
\providecommand{\extchoice}{\mathrel{\Box}}
\providecommand{\intchoice}{\mathrel{\sqcap}}
\providecommand{\interleave}{\mathrel{|\!|\!|}}
\providecommand{\lpar}{\mathrel{[|}}
\providecommand{\rpar}{\mathrel{|]}}
\providecommand{\circhide}{\mathrel{\backslash}}
\providecommand{\circproject}{\mathrel{|\backslash}}
\providecommand{\circguard}{\mathrel{\&}}
\providecommand{\circseq}{\mathrel{;}}
\providecommand{\timeout}{\mathrel{\triangleright}}
\providecommand{\interrupt}{\mathrel{\triangle}}
\providecommand{\lchanset}{\{|}
\providecommand{\rchanset}{|\}}
\providecommand{\lrename}{[\![}
\providecommand{\rrename}{]\!]}
\providecommand{\lmap}{(|}
\providecommand{\rmap}{|)}
\providecommand{\lsync}{\mathrel{/\!+}}
\providecommand{\rsync}{\mathrel{+\!\backslash}}
\providecommand{\rthrow}{\mathrel{|\!\rangle}}
\providecommand{\from}{\leftarrow}
\providecommand{\WITHIN}{\mathrel{\mathsf{within}}}
\providecommand{\Skip}{\mathit{SKIP}}
\providecommand{\Stop}{\mathit{STOP}}
\providecommand{\lblot}{\langle\!|}
\providecommand{\rblot}{|\!\rangle}
"""
"""Before the text of a document; a definition of the style itself stands where it has one."""

_SIGNS: Final = {
    **{kind: command for command, (kind, tidy) in reversed(COMMANDS.items()) if not tidy},
    **{s.text[0]: s.latex[0] for s in SPELLINGS if s.kind != "prefix" or s.text[0] != "-"},
    **{sign: sign for sign in ("(", ")", "[", "]", ",", ":", ";", ".", "|", "@", "=", "==", "<", ">", "::=")},
    "{": r"\{",
    "}": r"\}",
    "..": r"\upto",
    "EMPTY": r"\emptyset",
}
_OPERATIONS: Final = {";": r"\semi", "||": r"\pll", "||!": r"\plo", "[]": r"\gch", "\\": r"\hide", "@": "@"}
_DISTRIBUTED: Final = {"and": r"\dcnj", "[]": r"\dgch", ";": r"\dsqc", "||": r"\dpll"}
_NAMES: Final = {name: markup for name, (_, markup) in NUMBER_SETS.items()}
_CSP_NAMES: Final = {"SKIP": r"\Skip", "STOP": r"\Stop"}
_INTERFACES: Final = {"chan": r"\chan", "method": r"\method", "local_chan": r"\localchan"}


class Writer:
    """Writes paragraphs and whole scripts."""

    def __init__(self) -> None:
        self._printer = ParagraphPrinter()

    def document(self, script: s.Script) -> str:
        """A document that holds all of a script."""
        parts: list[str] = []
        plain: list[s.Declaration] = []
        with deep_recursion():
            for declaration in script.declarations:
                if isinstance(declaration, s.Paragraph):
                    parts += self._csp(plain)
                    plain = []
                    parts.append(self.paragraph(declaration))
                else:
                    plain.append(declaration)
            parts += self._csp(plain)
        body = "\n".join(parts)
        return f"{PREAMBLE}\\begin{{document}}\n\n{body}\n\\end{{document}}\n"

    def _csp(self, declarations: Sequence[s.Declaration]) -> list[str]:
        if not declarations:
            return []
        script = s.Script(span=declarations[0].span, declarations=tuple(declarations))
        return [f"\\begin{{cspm}}\n{print_script(script)}\\end{{cspm}}\n"]

    def paragraph(self, node: s.Paragraph) -> str:
        """The environment that a paragraph becomes."""
        match node:
            case z.Class():
                return self._class(node)
            case z.Schema():
                return self._schema(node)
            case z.Axiom():
                return self._axiom(node)
            case z.Lemma():
                return self._lemma(node)
            case z.Retrieve():
                head = f"\\begin{{retrieve}}{{{_name(node.name)}}}{{{_name(node.abstract.name)}}}"
                head += f"{{{_name(node.concrete.name)}}}"
                return f"{head}\n\\where\n{self._lines(map(self.term, node.predicates))}\\end{{retrieve}}\n"
        return f"\\begin{{zed}}\n{self._line(node)}\n\\end{{zed}}\n"

    def _line(self, node: s.Paragraph) -> str:
        """A paragraph of one line in a ``zed`` environment or in a class."""
        match node:
            case z.GivenTypes():
                return f"[{_names(node.names)}]"
            case z.Reading():
                return self._marked(self._printer.paragraph(node)).replace("reading", "\\reading", 1)
            case z.View():
                return f"\\view {node.kind}"
        return self._marked(self._printer.paragraph(node))

    # --- terms -----------------------------------------------------------------------------------------------

    def term(self, node: z.Term) -> str:
        """A term in markup."""
        return self._marked(self._printer.term(node))

    def _declare(self, node: z.Declare) -> str:
        return self._marked(self._printer.declare(node))

    def _marked(self, doc: Doc, *, operations: bool = False) -> str:
        """A document of the text notation in markup."""
        text = lay_out(doc, WIDTH)
        # As the body of a definition, so that no word at its beginning is taken for that of a section.
        source = Source("text", f"= {text}")
        found = list(tokens(source, 0, len(source.text), Scan()))[1:-1]
        return "".join(_markup(found, operations=operations))

    # --- boxes -----------------------------------------------------------------------------------------------

    def _lines(self, lines: Iterable[str]) -> str:
        """Lines of a box, each with what ends it but the last."""
        found = list(lines)
        return "".join(f"  {line} \\\\\n" for line in found[:-1]) + "".join(f"  {line}\n" for line in found[-1:])

    def _where(self, predicates: Sequence[z.Term]) -> str:
        return f"\\where\n{self._lines(map(self.term, predicates))}" if predicates else ""

    def _schema(self, node: z.Schema) -> str:
        box = self._lines(map(self._declare, node.declarations))
        if node.initial is None:
            box += self._where(node.predicates)
        else:
            # oz.sty allows no box for INIT outside a class: it is a part of the predicate, behind a word of its own.
            initial = map(self.term, node.initial)
            box += f"\\where\n{self._lines([*map(self.term, node.predicates), INITIALLY, *initial])}"
        generics = f"[{_names(node.generics)}]" if node.generics else ""
        return f"\\begin{{schema}}{{{_name(node.name)}}}{generics}\n{box}\\end{{schema}}\n"

    def _axiom(self, node: z.Axiom) -> str:
        declarations = self._lines(map(self._declare, node.declarations))
        box, generics = ("gendef", f"[{_names(node.generics)}]") if node.generics else ("axdef", "")
        return f"\\begin{{{box}}}{generics}\n{declarations}{self._where(node.predicates)}\\end{{{box}}}\n"

    def _lemma(self, node: z.Lemma) -> str:
        generics = f"[{_names(node.generics)}]" if node.generics else ""
        lines = [self.term(node.predicate)]
        if node.hints is not None and node.hints.using:
            lines.append(f"\\using {self._uses(node.hints.using)}")
        if node.hints is not None and node.hints.induction is not None:
            lines.append(f"\\induction {_name(node.hints.induction.name)}")
        return f"\\begin{{ozlemma}}{{{_name(node.name)}}}{generics}\n{self._lines(lines)}\\end{{ozlemma}}\n"

    def _uses(self, uses: Iterable[z.LemmaUse]) -> str:
        """Lemmas, with what they are used for."""
        return ", ".join(
            _name(use.name) + (f"({', '.join(map(self.term, use.arguments))})" if use.arguments else "") for use in uses
        )

    # --- classes ---------------------------------------------------------------------------------------------

    def _class(self, node: z.Class) -> str:
        generics = f"[{_names(node.generics)}]" if node.generics else ""
        # Boxes that nothing stands between are set beside each other.
        sections = " \\\\\n".join(section.removesuffix("\n") for section in self._parts(node))
        sections += "\n" if sections else ""
        return f"\\begin{{class}}{{{_name(node.name)}}}{generics}\n{sections}\\end{{class}}\n"

    def _parts(self, node: z.Class) -> Iterator[str]:
        if node.visibility is not None:
            yield f"\\visibility ({_names(node.visibility)})"
        for parent in node.inherits:
            arguments = ", ".join(map(self.term, parent.arguments))
            renamings = ", ".join(f"{_name(new.name)}/{_name(old.name)}" for new, old in parent.renamings)
            line = f"\\inherit {_name(parent.name)}"
            yield line + (f"[{arguments}]" if arguments else "") + (f"[{renamings}]" if renamings else "")
        for interface in node.interface:
            line = f"{_INTERFACES[interface.kind]} {_names(interface.names)}"
            if interface.parameters:
                line += f" : [ {self._marked(self._printer.bound(interface.parameters, ANYWHERE))} ]"
            yield line
        for equation in node.equations:
            yield self._equation(equation)
        for paragraph in node.paragraphs:
            match paragraph:
                case z.Schema():
                    yield self._schema(paragraph)
                case z.Axiom():
                    yield self._axiom(paragraph)
                case z.Lemma():
                    yield self._lemma(paragraph)
                case _:
                    yield self._line(paragraph)
        if node.state is not None:
            yield self._state(node.state)
        if node.initial is not None:
            yield f"\\begin{{init}}\n{self._lines(map(self.term, node.initial.predicates))}\\end{{init}}\n"
        for operation in node.operations:
            yield self._operation(operation)

    def _state(self, node: z.State) -> str:
        lines = [*map(self._declare, node.primary)]
        if node.secondary:
            lines += ["\\Delta", *map(self._declare, node.secondary)]
        return f"\\begin{{state}}\n{self._lines(lines)}{self._where(node.predicates)}\\end{{state}}\n"

    def _operation(self, node: z.OperationSchema | z.OperationDefinition) -> str:
        if isinstance(node, z.OperationDefinition):
            body = self._marked(self._printer.operations(node.body), operations=True)
            return f"{_name(node.name)} \\sdef {body}" + (f" \\using {self._uses(node.using)}" if node.using else "")
        delta = [] if node.delta is None else [f"\\Delta ({_names(node.delta)})"]
        lines = self._lines([*delta, *map(self._declare, node.declarations)])
        predicates = [*map(self.term, node.predicates)]
        using = [f"\\using {self._uses(node.using)}"] if node.using else []
        where = f"\\where\n{self._lines([*predicates, *using])}" if predicates else self._lines(using)
        return f"\\begin{{op}}{{{_name(node.name)}}}\n{lines}{where}\\end{{op}}\n"

    def _equation(self, node: s.Declaration) -> str:
        """A definition of CSPm, its signs and words marked up."""
        source = Source("text", print_expression(node, width=WIDTH))
        found = tokenise(source, form="equations")
        parts: list[str] = []
        end = 0
        for index, kind in enumerate(found.kinds[:-1]):
            start = found.starts[index]
            if kind == "_NEWLINE":
                parts.append(" \\\\\n  ")
                end = _after_blanks(source.text, start)
                continue
            gap = source.text[end:start]
            text = found.text(index)
            if kind in ("NAME", "QUALIFIED"):
                text = _CSP_NAMES.get(text, _name(text))
            elif kind in ("CHAR", "STRING"):
                pass
            else:
                text = CSP_SIGNS.get(kind, text)
            parts.append(_gap(parts, gap, text))
            parts.append(text)
            end = found.ends[index]
        return "".join(parts)


def _after_blanks(text: str, start: int) -> int:
    while start < len(text) and text[start].isspace():
        start += 1
    return start


def _gap(before: Sequence[str], gap: str, text: str) -> str:
    """What stands between two pieces of markup where the text has *gap*."""
    if "\n" in gap:
        return "\n    "
    if gap:
        return " "
    # A command ends at the first character that is no letter.
    letters = bool(before) and before[-1].startswith("\\") and before[-1][-1].isalpha() and text[:1].isalnum()
    return " " if letters else ""


def _markup(found: Sequence[Token], *, operations: bool) -> Iterator[str]:
    """The tokens of a term with their markup; a token that begins a line gets a line break before it."""
    brackets: list[str] = []
    before: Token | None = None
    last = ""
    for number, token in enumerate(found):
        text = _sign(found, number, brackets, operations=operations)
        if before is not None:
            gap = " " if token.start > before.end else ""
            applied = before.kind in OPERAND_ENDS and token.kind in _ARGUMENTS and gap
            if token.first:
                yield " \\\\\n    \\t2 "
            elif applied:
                yield "~"
            elif gap or (last.startswith("\\") and last[-1].isalpha() and text[:1].isalnum()):
                yield " "
        yield text
        before, last = token, text


_ARGUMENTS: Final = frozenset(["NAME", "INT", "REAL", "true", "false", "(", "{", "(|", "[[", "SEQUENCE_OPEN", "EMPTY"])
"""What an application without brackets may have as its argument: a hard space stands before it."""


def _sign(found: Sequence[Token], place: int, brackets: list[str], *, operations: bool) -> str:
    token = found[place]
    kind = token.kind
    if kind == "NAME":
        name = str(token.value)
        return (_NAMES[name] if name in _NAMES and not token.decoration else _name(name)) + token.decoration
    if kind == "RELATION":
        return f"{{{_name(str(token.value))}{token.decoration}}}"
    if kind in ("INT", "REAL"):
        return str(token.value)
    if kind in NAMING and kind not in WORDS and not _applies(found, place):
        return kind
    if kind == "-":
        infix = place > 0 and found[place - 1].kind in OPERAND_ENDS
        return "-" if infix else r"\negate"
    if kind == "(|":
        binding = found[place + 1].kind == "NAME" and found[place + 2].kind == "=="
        brackets.append("blot" if binding else "img")
        return r"\l" + brackets[-1]
    if kind == "|)":
        return r"\r" + brackets.pop()
    if operations and kind in _DISTRIBUTED and (place == 0 or found[place - 1].kind not in OPERAND_ENDS):
        return _DISTRIBUTED[kind]
    if operations and kind in _OPERATIONS:
        return _OPERATIONS[kind]
    return _SIGNS[kind]


def _applies(found: Sequence[Token], place: int) -> bool:
    """Whether something follows that the word at *place* is applied to, so that it is no name."""
    kinds = [token.kind for token in found[place + 1 : place + 4]]
    if kinds[:1] == ["["]:  # a schema
        return kinds[1:2] == ["NAME"] and kinds[2:3] in ([":"], [","])
    following = kinds[0] if kinds else ""
    return following in _ARGUMENTS or following in BINDERS or (following in ("if", "let", *PREFIX) and following != "-")


def _name(name: str) -> str:
    return name.replace("_", "\\_")


def _names(declarations: Iterable[s.NameDeclaration]) -> str:
    return ", ".join(_name(declaration.name) for declaration in declarations)


def write_latex(script: s.Script) -> str:
    """A script as a LaTeX document."""
    return Writer().document(script)
