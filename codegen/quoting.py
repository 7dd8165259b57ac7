"""Quoting: how a text of the script stands in a file of the program, as a value or as prose, and never as code.

Whatever a script, its file name or an option says reaches a template through one function of this module, which gives
:class:`Code`; the templates take nothing else (``codegen.emit.project``). A value that was forgotten is therefore an
error of ours when the program is generated, and not code when it is run.
"""

from __future__ import annotations

import re

_NAME = re.compile(r"[^\W\d]\w*")
_ESCAPES = {"\\": "\\\\", "\n": "\\n", "\r": "\\r", "\t": "\\t"}


class Code(str):
    """Text that may stand in a file as it is: it was quoted, or made by the generator."""

    __slots__ = ()


class Unquoted(TypeError):
    """A value reaches a template that went through no function of this module: a mistake in the generator."""


def literal(text: str) -> Code:
    """A text as a literal of Python, in double quotes; what is no printable character is escaped.

    >>> literal('a "b"')
    '"a \\\\"b\\\\""'
    """
    return Code(f'"{_escaped(text, quote=True)}"')


def literals(texts: list[str] | tuple[str, ...]) -> Code:
    """The inside of a tuple of texts; one has its comma."""
    return Code(", ".join(map(literal, texts)) + ("," if len(texts) == 1 else ""))


def name(text: str) -> Code:
    """A name of Python: what is none is a mistake in the generator.

    Raises:
        Unquoted: it is no name.
    """
    if _NAME.fullmatch(text) is None:
        raise Unquoted(f"{text!r} is no name")
    return Code(text)


def names(texts: list[str]) -> Code:
    """Names, with commas."""
    return Code(", ".join(map(name, texts)))


def code(text: str) -> Code:
    """Text that the generator made, of names, literals and signs of Python."""
    return Code(text)


def prose(text: str) -> Code:
    """A text inside a docstring, its line breaks kept; it can neither end the docstring nor escape anything."""
    lines = [_escaped(line.rstrip(), quote=False) for line in text.strip().splitlines()]
    inside = "\n".join(lines).replace('"""', "'''")
    # A quote at the end would stand before the three that end the docstring.
    return Code(f"{inside[:-1]}'" if inside.endswith('"') else inside)


def phrase(text: str, width: int = 90) -> Code:
    """A text inside a docstring on one line, cut to *width*."""
    one = " ".join(text.split())
    return prose(one if len(one) <= width else f"{one[: width - 3].rstrip()}...")


def markdown(text: str) -> Code:
    """A text as code inside a line or a table of Markdown."""
    one = " ".join(_plain(text).split())
    longest = max((len(run) for run in re.findall(r"`+", one)), default=0)
    ticks = "`" * (longest + 1)
    room = " " if longest else ""
    return Code(f"{ticks}{room}{one.replace('|', chr(92) + '|')}{room}{ticks}")


def shell(text: str) -> Code:
    """A text as one word of a shell."""
    plain = _plain(text)
    if re.fullmatch(r"[\w./:=+,@-]+", plain) and not plain.startswith("-"):
        return Code(plain)
    return Code("'" + plain.replace("'", "'\\''") + "'")


def project_name(text: str) -> Code:
    """The name of a project in ``pyproject.toml``, made of a folder's name."""
    return Code(re.sub(r"[^a-z0-9]+", "-", text.lower()).strip("-") or "program")


def _escaped(text: str, *, quote: bool) -> str:
    """A text with escapes for what Python would read otherwise, or an editor not show."""
    found = []
    for character in text:
        escape = _ESCAPES.get(character)
        if escape is not None:
            found.append(escape)
        elif character == '"' and quote:
            found.append('\\"')
        elif character.isprintable():
            found.append(character)
        else:
            number = ord(character)
            width = 2 if number < 256 else 4 if number < 65536 else 8
            found.append(f"\\{ {2: 'x', 4: 'u', 8: 'U'}[width] }{number:0{width}x}")
    return "".join(found)


def _plain(text: str) -> str:
    """A text with a sign in place of everything that is no printable character."""
    return "".join(c if c.isprintable() else " " if c.isspace() else "\N{REPLACEMENT CHARACTER}" for c in text)


# --- C ------------------------------------------------------------------------------------------------------------


def c_text(text: str) -> Code:
    """A text as a literal of C, in ASCII: other characters as the bytes of UTF-8, in octal.

    Octal, since a hexadecimal escape goes on for as long as there are digits; and no ``??``, which begins a trigraph.
    """
    found = []
    for byte in text.encode("utf-8", "surrogateescape"):
        character = chr(byte)
        plain = 32 <= byte < 127 and character not in '"\\?'
        found.append(character if plain else f"\\{byte:03o}")
    return Code(f'"{"".join(found)}"')


def c_comment(text: str) -> Code:
    """A text inside a comment of C, on one line."""
    one = " ".join(_plain(text).split()).encode("ascii", "replace").decode("ascii")
    return Code(one.replace("*/", "* /").replace("/*", "/ *").replace("??", "? ?").rstrip("\\"))


def c_name(text: str) -> Code:
    """A name of C made of a text: letters, digits and underscores."""
    name = re.sub(r"[^A-Za-z0-9]+", "_", text.replace("'", "_prime")).strip("_") or "x"
    name = f"n{name}" if name[0].isdigit() else name
    return Code(f"{name}_" if name in _C_WORDS else name)


_C_WORDS = frozenset(
    {
        "auto",
        "break",
        "case",
        "char",
        "const",
        "continue",
        "default",
        "do",
        "double",
        "else",
        "enum",
        "extern",
        "float",
        "for",
        "goto",
        "if",
        "inline",
        "int",
        "long",
        "register",
        "restrict",
        "return",
        "short",
        "signed",
        "sizeof",
        "static",
        "struct",
        "switch",
        "typedef",
        "union",
        "unsigned",
        "void",
        "volatile",
        "while",
        "bool",
        "true",
        "false",
        "main",
        "asm",
        "NULL",
        "exit",
        "signal",
        "abort",
        "stop",
    }
)


# --- Ada ----------------------------------------------------------------------------------------------------------


def ada_text(text: str) -> Code:
    """A text as an expression of Ada: a literal of printable ASCII, and the other bytes of UTF-8 by their numbers."""
    parts: list[str] = []
    plain = ""
    for byte in text.encode("utf-8", "surrogateescape"):
        if 32 <= byte < 127:
            if len(plain) >= 60:
                parts.append(f'"{plain}"')
                plain = ""
            plain += '""' if byte == 34 else chr(byte)
            continue
        if plain:
            parts.append(f'"{plain}"')
            plain = ""
        parts.append(f"Character'Val ({byte})")
    if plain or len(parts) < 2:
        parts.append(f'"{plain}"')
    return Code(" & ".join(parts))


def ada_name(text: str) -> Code:
    """A name of Ada made of a text."""
    name = re.sub(r"[^A-Za-z0-9]+", "_", text.replace("'", "_prime")).strip("_") or "X"
    name = f"N_{name}" if name[0].isdigit() else name
    return Code(f"{name}_X" if name.lower() in _ADA_WORDS else name)


_ADA_WORDS = frozenset(
    {
        "abort",
        "abs",
        "abstract",
        "accept",
        "access",
        "aliased",
        "all",
        "and",
        "array",
        "at",
        "begin",
        "body",
        "case",
        "constant",
        "declare",
        "delay",
        "delta",
        "digits",
        "do",
        "else",
        "elsif",
        "end",
        "entry",
        "exception",
        "exit",
        "for",
        "function",
        "generic",
        "goto",
        "if",
        "in",
        "interface",
        "is",
        "limited",
        "loop",
        "mod",
        "new",
        "not",
        "null",
        "of",
        "or",
        "others",
        "out",
        "overriding",
        "package",
        "pragma",
        "private",
        "procedure",
        "protected",
        "raise",
        "range",
        "record",
        "rem",
        "renames",
        "requeue",
        "return",
        "reverse",
        "select",
        "separate",
        "some",
        "subtype",
        "synchronized",
        "tagged",
        "task",
        "terminate",
        "then",
        "type",
        "until",
        "use",
        "when",
        "while",
        "with",
        "xor",
        "integer",
        "natural",
        "positive",
        "boolean",
        "true",
        "false",
        "character",
        "string",
        "csp",
        "tables",
        "methods",
        "main",
    }
)
