r"""From the LaTeX of classes to the tokens of the Object-Z notation.

The tokens are those that the text notation has: environments become the words of their sections (``\begin{op}{Push}``
is ``op Push``, its end is ``end``), commands the signs that they stand for, ``\\`` is the end of a line. So one parser
reads both. Style that is odd but clear gives a warning.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Final

from cspcheck.cspm.diagnostics import Diagnostic
from cspcheck.cspm.oz.reading import messages as messages
from cspcheck.cspm.oz.reading.latex_commands import (
    BLACKBOARD,
    BLANKS,
    COMMANDS,
    CSP_CLOSERS,
    CSP_COMMANDS,
    FONTS,
    LINE_BREAKS,
    LONE,
    NAMES,
    NO_NAMES,
    SUPERSCRIPTS,
    TEXTS,
    UNREAD_LINES,
    UNSUPPORTED,
    WITH_ARGUMENT,
    WORDS,
)
from cspcheck.cspm.oz.reading.latex_environments import BOXES, LAYOUT, RENAMING, SKIPPED, THEOREM, THEOREM_USAGE
from cspcheck.cspm.oz.reading.lexer import INFIX, OPERAND_ENDS, PREFIX, Token
from cspcheck.cspm.source import Source, Span
from cspcheck.cspm.spelling import suggestions

_SIGNS: Final = frozenset(
    [
        *(
            "::=",
            "==",
            "->",
            "|||",
            "||",
            "[|",
            "|]",
            "[]",
            "..",
            "<=",
            ">=",
            "!=",
            "=>",
            "<->",
            "<-",
            "::",
            "+]",
            "[+",
        ),
        *("@@", "/+"),
    ]
)
_TOKEN = re.compile(
    r"(?P<blank>[\s~&$]+)"
    r"|(?P<comment>%[^\n]*)"
    r"|(?P<break>\\\\(?:\*|[ \t]*\[[0-9.]+[a-z]+\])?)"
    r"|(?P<begin>\\begin[ \t]*\{(?P<begun>[A-Za-z*]+)\})"
    r"|(?P<finish>\\end[ \t]*\{(?P<ended>[A-Za-z*]+)\})"
    r"|(?P<tab>\\t[ \t]*[0-9])"
    r"|(?P<stack>\\(?:stackrel|overset)[ \t]*\{\s*\\wedge\s*\}[ \t]*\{\s*=\s*\}|\\(?:wide)?hat[ \t]*(?:\{\s*=\s*\}|=))"
    r"|(?P<command>\\[A-Za-z]+)"
    r"|(?P<thin>\\[,:;! \n\t]|\\/|\\-)"
    r"|(?P<symbol>\\.)"
    r"|(?P<name>[A-Za-z](?:[A-Za-z0-9]|\\_|_\{?[A-Za-z0-9]+\}?)*(?:\\_)*)(?:~(?=['?!]))?(?P<decoration>['?!]+)?"
    r"|(?P<real>[0-9]+\.[0-9]+)"
    r"|(?P<int>[0-9]+)"
    r'|(?P<literal>"(?:[^"\\\n]|\\[^\n])*"|\'(?:[^\'\\\n]|\\[^\n])\')'
    r"|(?P<super>\^[ \t]*(?:\{[^{}]*\}|\\?[A-Za-z]+|[-+*]))"
    rf"|(?P<sign>{'|'.join(re.escape(s) for s in sorted(_SIGNS, key=len, reverse=True))}|[^\s{{}}])"
    r"|(?P<group>[{}])",
    re.DOTALL,
)
_SUBSCRIPT = re.compile(r"_(?:1|\{1\})(?![A-Za-z0-9])")
_RELATION = re.compile(
    r"\\relation\s*\(\s*(?:\\varg|\\_)\s*~?([A-Za-z][A-Za-z0-9]*(?:\\_[A-Za-z0-9]+)*)~?\s*(?:\\varg|\\_)\s*\)"
)
_LINE_END = re.compile(r"\\\\|\\end[ \t]*\{")
_ARGUMENT = re.compile(r"\s*\{")
_GENERICS = re.compile(r"[ \t]*\[[^\]\[\n]*\]")
_PROSE = re.compile(r"[A-Za-z]{2,}[ \t\n~]+[A-Za-z]{2,}")


@dataclass(slots=True)
class Markup:
    """What was read of a part of a document: tokens, each with the box that it stands in, and remarks."""

    tokens: list[Token] = field(default_factory=list)
    boxes: list[str] = field(default_factory=list)
    comments: list[tuple[int, int]] = field(default_factory=list)
    errors: list[Diagnostic] = field(default_factory=list)
    remarks: list[Diagnostic] = field(default_factory=list)


class Lexer:
    """Makes the tokens of one environment at the top of a document."""

    def __init__(self, source: Source, start: int, end: int, relations: set[str] | None = None) -> None:
        """*relations* are the names that templates before have made infix relations; those in here are added."""
        self.source = source
        self.relations = set() if relations is None else relations
        self.text = source.text
        self.position = start
        self.end = end
        self.markup = Markup()
        self.open: list[tuple[str, Span]] = []  # environments, innermost last
        self.fresh = True  # a line begins here
        self.last = -1  # where the last token ended
        self.typing = False  # behind the colon of a declaration

    # --- tokens ----------------------------------------------------------------------------------------------

    def run(self) -> Markup:
        """Read everything; the last token has the kind ``$END``."""
        self._range(self.end)
        for name, span in reversed(self.open):
            self.markup.errors.append(messages.environment_not_closed(span, name, None))
        tokens = self.markup.tokens
        last = tokens[-1].end if tokens else self.position
        tokens.append(Token("$END", last, last, first=True, section=True))
        self.markup.boxes.append("")
        return self.markup

    @property
    def box(self) -> str:
        """The word of the innermost box; ``zed`` for none."""
        for name, _ in reversed(self.open):
            if name in BOXES:
                return BOXES[name]
        return "zed"

    def _add(self, kind: str, start: int, end: int, value: str = "", decoration: str = "", **more: bool) -> Token:
        if kind == "NAME" and self.previous == "inrel":
            kind = "RELATION"
        token = Token(
            kind,
            start,
            end,
            first=self.fresh,
            tight=start == self.last,
            value=value,
            decoration=decoration,
            section=more.get("section", False),
        )
        self.markup.tokens.append(token)
        self.markup.boxes.append(self.box)
        self.fresh = False
        self.last = end
        if kind == ":":
            self.typing = True
        elif kind in (";", "|", "@", "where", "end", ","):
            self.typing = False
        return token

    def _break(self) -> None:
        self.fresh = True
        self.typing = False

    def warn(self, start: int, end: int, tidy: str, written: str = "") -> None:
        """Remark on what is read as *tidy*."""
        span = self.source.span(start, end)
        self.markup.remarks.append(messages.untidy_markup(span, written or " ".join(span.text.split()), tidy))

    @property
    def previous(self) -> str:
        """The kind of the last token."""
        return self.markup.tokens[-1].kind if self.markup.tokens else ""

    def _range(self, end: int) -> None:
        while self.position < end:
            match = _TOKEN.match(self.text, self.position, end)
            assert match is not None, self.text[self.position : self.position + 20]
            group = match.lastgroup
            assert group is not None
            start, self.position = match.span()
            _READERS[group](self, match, start)

    def _skip(self, match: re.Match[str], start: int) -> None:
        pass

    def _comment(self, match: re.Match[str], start: int) -> None:
        self.markup.comments.append((start, self.position))

    def _line_break(self, match: re.Match[str], start: int) -> None:
        self._break()

    def _name(self, match: re.Match[str], start: int) -> None:
        written = match["name"]
        name = written.replace("\\_", "\0")
        if "_" in name:
            name = re.sub(r"_\{?([A-Za-z0-9]+)\}?", r"_\1", name)
            self.warn(start, start + len(written), name.replace("\0", "_").replace("_", "\\_"))
        name = name.replace("\0", "_")
        decoration = match["decoration"] or ""
        end = self.position
        if name in WORDS and not decoration and self.previous != ".":
            tidy = next((c for c, (kind, t) in COMMANDS.items() if kind == name and not t), "")
            self.warn(start, end, tidy)
            self._add(name, start, end, name)
            return
        if name == "theorem" and self.fresh and self.box == "zed" and self._theorem(start):
            return
        if name == "num":
            name = "int"
        elif name in NO_NAMES:
            name += "_"
        if name in self.relations and not self.fresh and self.previous in OPERAND_ENDS:
            self._add("inrel", start, start)
        self._add("NAME", start, end, name, decoration)

    def _number(self, match: re.Match[str], start: int) -> None:
        self._add("INT" if match["int"] else "REAL", start, self.position, match[0])

    def _literal(self, match: re.Match[str], start: int) -> None:
        self._add("LITERAL", start, self.position)

    def _super(self, match: re.Match[str], start: int) -> None:
        inner = match[0][1:].strip().strip("{}").strip()
        if inner in ("\\prime", "'") and self.markup.tokens and self.previous == "NAME":
            self.warn(start, self.position, "'")
            token = self.markup.tokens[-1]
            token.decoration += "'"
            token.end = self.last = self.position
            return
        kind = SUPERSCRIPTS.get(inner)
        if kind is None:
            # A bare `^` concatenates in the CSP part.
            self.position = start + 1
            self._add("^", start, self.position)
            return
        tidy = {"^+": "\\plus", "^*": "\\star", "~": "\\inv"}[kind]
        self.warn(start, self.position, tidy)
        self._add(kind, start, self.position)

    def _sign(self, match: re.Match[str], start: int) -> None:
        sign = match[0]
        if sign == "[|" and self.previous not in OPERAND_ENDS:
            # Where an operand is due a schema begins that declares nothing.
            self._add("[", start, start + 1)
            self._add("|", start + 1, self.position)
            return
        if sign == "[" and self.previous not in ("SDEF", ":") and self._is_prose(start):
            self._prose(start)
            return
        self._add(LONE.get(sign, "BAD"), start, self.position)

    # --- comments in brackets --------------------------------------------------------------------------------

    def _is_prose(self, start: int) -> bool:
        """Whether the bracket at *start* opens a comment."""
        tight = start == self.last and self.previous == "NAME"
        content = self.text[start + 1 : self._closing(start)]
        if self.previous in ("NAME", "]", ")") and RENAMING.fullmatch(content):
            return False
        prose = bool(_PROSE.search(content)) and not re.search(r"\\(?!_)|[|:]", content)
        if self.box in ("class", "zed", "retrieve"):
            return prose
        return not tight or prose

    def _closing(self, start: int) -> int:
        depth = 0
        for position in range(start, self.end):
            depth += (self.text[position] == "[") - (self.text[position] == "]")
            if depth == 0:
                return position
        return self.end - 1

    def _prose(self, start: int) -> None:
        self.position = self._closing(start) + 1
        self.markup.comments.append((start, self.position))

    def _argument(self) -> tuple[int, int] | None:
        """The content of the group that comes next, which is passed over."""
        match = _ARGUMENT.match(self.text, self.position, self.end)
        if match is None:
            return None
        begin = match.end()
        depth = 1
        position = begin
        while position < self.end and depth:
            character = self.text[position]
            if character == "\\":
                position += 1
            else:
                depth += (character == "{") - (character == "}")
            position += 1
        self.position = position
        return begin, max(position - 1, begin)

    # --- commands --------------------------------------------------------------------------------------------

    def _symbol(self, match: re.Match[str], start: int) -> None:
        command = match[0]
        if command in COMMANDS:
            self._add(COMMANDS[command][0], start, self.position)
        elif command == "\\_" or command in CSP_COMMANDS:
            self._add("BAD", start, self.position)
        else:
            self.markup.errors.append(messages.unknown_command(self.source.span(start, self.position), ()))

    def _stack(self, match: re.Match[str], start: int) -> None:
        self.warn(start, self.position, "\\sdef")
        self._add("SDEF", start, self.position)

    def _command(self, match: re.Match[str], start: int) -> None:
        command = match[0]
        subscript = _SUBSCRIPT.match(self.text, self.position, self.end)
        if subscript is not None and (f"{command}_1" in COMMANDS or f"{command}_1" in NAMES):
            command += "_1"
            self.position = subscript.end()
        if command in LINE_BREAKS:
            self._break()
        elif command in BLANKS:
            pass
        elif command in WITH_ARGUMENT:
            self._argument()
        elif command in FONTS:
            self._font(start)
        elif command in TEXTS:
            self._text(start)
        elif command == "\\mathbb":
            self._blackboard(start)
        elif command == "\\ooalign":
            self._argument()
            self.warn(start, self.position, "\\ndres", "\\ooalign")
            self._add("</|", start, self.position)
        elif command == "\\Xi":
            self._xi(start)
        elif command == "\\nexi":
            self.warn(start, self.position, "\\lnot \\exists")
            self._add("not", start, start)
            self._add("exists", start, self.position)
        elif command in UNSUPPORTED:
            span = self.source.span(start, self.position)
            self.markup.errors.append(messages.unsupported(span, UNSUPPORTED[command]))
        elif command == "\\vdash":
            self._conjecture(start)
        elif command in UNREAD_LINES:
            self._unread_line(command, start)
        elif command in NAMES and not (command in COMMANDS and not self._names()):
            self._named(command, start)
        elif command in COMMANDS:
            self._operator(command, start)
        elif command in CSP_COMMANDS:
            self._add(")" if command in CSP_CLOSERS else "BAD", start, self.position)
        else:
            known = [*COMMANDS, *NAMES, *CSP_COMMANDS]
            span = self.source.span(start, self.position)
            self.markup.errors.append(messages.unknown_command(span, suggestions(command, known)))

    def _theorem(self, start: int) -> bool:
        r"""``theorem name[X] \vdash? p`` in one line, up to the predicate; whether it is one."""
        match = THEOREM.match(self.text, start, self.end)
        if match is None:
            return False
        name = re.sub(r"[\s~]+", "", match["name"]).replace("\\_", "_").strip("_")
        self._add("NAME", start, start, "lemma", section=True)
        self._add("NAME", start, start, name)
        if match["generics"] is not None:
            self.position = match.start("generics")
            self._range(match.end("generics"))
        self.position = match.end()
        self._add(":", match.end(), match.end())
        return True

    def _conjecture(self, start: int) -> None:
        """``\\vdash? p`` is a lemma that is called after its line; in a theorem it says nothing more."""
        mark = re.compile(r"\s*\?").match(self.text, self.position, self.end)
        if mark is not None:
            self.position = mark.end()
        if self.box == "lemma":
            return
        self.fresh = True
        self._add("NAME", start, start, "lemma", section=True)
        self._add("NAME", start, start, f"conjecture_{self.source.position(start)[0]}")
        self._add(":", start, self.position)

    def _unread_line(self, command: str, start: int) -> None:
        """A template of an infix relation is read; any other is passed over to the end of its line, and told."""
        template = _RELATION.match(self.text, start, self.end)
        if template is not None:
            self.relations.add(template[1].replace("\\_", "_"))
            self.position = template.end()
            return
        span = self.source.span(start, self.position)
        self.markup.errors.append(messages.unsupported(span, UNREAD_LINES[command]))
        found = _LINE_END.search(self.text, self.position, self.end)
        self.position = found.start() if found is not None else self.end

    def _names(self) -> bool:
        """Whether a command that is both a name and an operator is a name here, at the beginning of a line."""
        return self.fresh and self.box == "class"

    def _named(self, command: str, start: int) -> None:
        name, tidy = NAMES[command]
        if tidy:
            self.warn(start, self.position, tidy)
        decoration = ""
        if self.position < self.end and self.text[self.position] in "'?!" and name not in ("Delta", "chan", "method"):
            decoration = self.text[self.position]
            self.position += 1
        self._add("NAME", start, self.position, name, decoration, section=name == "Delta" and self.fresh)

    def _operator(self, command: str, start: int) -> None:
        kind, tidy = COMMANDS[command]
        if command == "\\to":
            # A function space in a type, a maplet elsewhere, the prefix of CSP in an equation.
            kind, tidy = ("->", "\\fun") if self.typing else ("|->", "\\mapsto")
        if tidy:
            self.warn(start, self.position, tidy)
        if kind == "where":
            self._break()
            self._add("where", start, self.position, section=True)
            self._break()
            return
        if kind == "initially":
            self._break()
            self._add("NAME", start, self.position, "init", section=True)
            self._break()
            return
        if kind in ("using", "by"):
            for word in ("using",) if kind == "using" else ("by", "induction", "on"):
                self._add("NAME", start, self.position, word, section=word == kind)
            return
        value = kind if kind in PREFIX or kind in INFIX else ""
        self._add(kind, start, self.position, value)

    def _font(self, start: int) -> None:
        """Words in a font of their own: one name, or a word of the notation."""
        argument = self._argument()
        if argument is None:
            return
        after = self.position
        words = re.sub(r"[~\s]+", " ", self.text[slice(*argument)].replace("\\_", "_")).strip()
        name = re.fullmatch(r"([A-Za-z][A-Za-z0-9_]*)('|\?|!)?", words)
        if name is None:
            self.position = argument[0]
            self._range(argument[1])
            self.position = after
            return
        if name[1] in WORDS:
            self._add(name[1], start, after, name[1])
        else:
            decoration = name[2] or ""
            if not decoration and after < self.end and self.text[after] in "'?!":
                decoration = self.text[after]
                self.position = after = after + 1
            self._add("NAME", start, after, name[1], decoration)

    def _text(self, start: int) -> None:
        """A comment, or a word of the notation in the font of the text."""
        argument = self._argument()
        if argument is None:
            return
        words = re.sub(r"\\[a-z]+\b|[{}]", "", self.text[slice(*argument)]).strip()
        if words in ("chan", "method", "local_chan", "inherit", "main", "INIT"):
            self._add("NAME", start, self.position, words)
        else:
            self.markup.comments.append((start, self.position))

    def _blackboard(self, start: int) -> None:
        argument = self._argument()
        letter = self.text[slice(*argument)].strip() if argument else ""
        tidy = BLACKBOARD.get(letter)
        if tidy is None:
            span = self.source.span(start, self.position)
            self.markup.errors.append(messages.unknown_command(span, ()))
            return
        subscript = _SUBSCRIPT.match(self.text, self.position, self.end)
        if subscript is not None and (f"{tidy}_1" in COMMANDS or f"{tidy}_1" in NAMES):
            tidy += "_1"
            self.position = subscript.end()
        self.warn(start, self.position, tidy)
        if tidy in NAMES:
            self._add("NAME", start, self.position, NAMES[tidy][0])
        else:
            self._add(COMMANDS[tidy][0], start, self.position)

    def _xi(self, start: int) -> None:
        """``\\Xi S`` includes a schema twice; ``\\Xi (x, y)`` is read over."""
        if re.compile(r"\s*\(").match(self.text, self.position, self.end) is None:
            self._add("NAME", start, self.position, "Xi")
            return
        list_ = re.compile(r"\s*\([^()]*\)").match(self.text, self.position, self.end)
        if list_ is not None:
            self.position = list_.end()
        self.markup.remarks.append(messages.xi_list(self.source.span(start, self.position)))

    # --- environments ----------------------------------------------------------------------------------------

    def _begin(self, match: re.Match[str], start: int) -> None:
        name = match["begun"]
        span = self.source.span(start, self.position)
        self._break()
        if name in SKIPPED:
            close = self.text.find(f"\\end{{{name}}}", self.position, self.end)
            self.position = self.end if close < 0 else close + len(f"\\end{{{name}}}")
            self.markup.comments.append((start, self.position))
            return
        if name not in BOXES and name not in LAYOUT:
            known = [*BOXES, *LAYOUT]
            self.markup.errors.append(messages.unknown_environment(span, name, suggestions(name, known)))
        outer = self.box
        self.open.append((name, span))
        if name in LAYOUT:
            if name in ("array", "sidebyside"):
                self._argument()
            return
        word = BOXES.get(name)
        if word is None:
            return
        self._add("NAME", start, self.position, word, section=True)
        if word == "const" and name == "gendef":
            generics = _GENERICS.match(self.text, self.position, self.end)
            if generics is not None:
                self._break()
                self.fresh = False
                self._range(generics.end())
        if word in ("class", "schema", "op", "retrieve", "lemma"):
            argument = self._argument()
            if argument is not None:
                after = self.position
                usage = THEOREM_USAGE.match(self.text, argument[0], argument[1]) if name == "theorem" else None
                self.position = argument[0] if usage is None else usage.end()
                self._range(argument[1])
                self.position = after
                generics = _GENERICS.match(self.text, after, self.end)
                if word in ("class", "schema", "lemma") and generics is not None and not _PROSE.search(generics[0]):
                    self.last = after + len(generics[0]) - len(generics[0].lstrip())  # of the name, no comment
                    self._range(generics.end())
            if word == "retrieve":
                self._classes_of_retrieve()
            elif word == "lemma":
                self._add(":", self.position, self.position)
        if word == "init" and outer == "schema":
            self.open[-1] = ("init", span)
        self._break()

    def _classes_of_retrieve(self) -> None:
        for number, word in enumerate(("between", "and")):
            argument = self._argument()
            if argument is None:
                return
            after = self.position
            self._add("NAME" if number == 0 else "and", argument[0], argument[0], word)
            self.position = argument[0]
            self._range(argument[1])
            self.position = after

    def _finish(self, match: re.Match[str], start: int) -> None:
        name = match["ended"]
        span = self.source.span(start, self.position)
        if not any(open_name == name for open_name, _ in self.open):
            return
        while self.open[-1][0] != name:
            inner, begun = self.open.pop()
            self.markup.errors.append(messages.environment_not_closed(begun, inner, span))
        word = BOXES.get(name)
        self._break()
        nested = word == "init" and len(self.open) > 1 and BOXES.get(self.open[-2][0]) == "schema"
        if word not in (None, "lemma") and not nested:
            self._add("end", start, self.position, "end", section=True)
        self.open.pop()
        self._break()


_READERS: Final[dict[str, Callable[[Lexer, re.Match[str], int], None]]] = {
    "blank": Lexer._skip,
    "thin": Lexer._skip,
    "tab": Lexer._skip,
    "comment": Lexer._comment,
    "break": Lexer._line_break,
    "begin": Lexer._begin,
    "begun": Lexer._begin,
    "finish": Lexer._finish,
    "ended": Lexer._finish,
    "stack": Lexer._stack,
    "command": Lexer._command,
    "symbol": Lexer._symbol,
    "name": Lexer._name,
    "decoration": Lexer._name,
    "real": Lexer._number,
    "int": Lexer._number,
    "literal": Lexer._literal,
    "super": Lexer._super,
    "sign": Lexer._sign,
    "group": Lexer._skip,  # braces group for TeX alone
}
"""What is done with each group of ``_TOKEN``."""
