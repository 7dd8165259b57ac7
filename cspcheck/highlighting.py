"""CSPm and CSP-OZ for Pygments: the lexer ``cspm``, which Sphinx and others find by its entry point."""

from __future__ import annotations

from typing import ClassVar

from pygments.lexer import RegexLexer, bygroups, words
from pygments.token import (
    Comment,
    Keyword,
    Name,
    Number,
    Operator,
    Punctuation,
    String,
    Text,
    Whitespace,
)

from cspcheck.cspm.prelude import BUILTINS, EXTERNAL, TIMED_BUILTINS, TRANSPARENT

KEYWORDS = (
    "assert",
    "channel",
    "datatype",
    "else",
    "endmodule",
    "exports",
    "external",
    "if",
    "include",
    "instance",
    "let",
    "module",
    "nametype",
    "print",
    "subtype",
    "then",
    "transparent",
    "within",
    "Timed",
)
CLASS_KEYWORDS = (
    "class",
    "end",
    "inherit",
    "visible",
    "chan",
    "method",
    "local_chan",
    "state",
    "init",
    "INIT",
    "op",
    "where",
    "Delta",
    "given",
    "reading",
    "view",
    "retrieve",
    "schema",
    "const",
    "lemma",
    "using",
    "forall",
    "exists",
    "exists1",
    "lambda",
    "mu",
)
OPERATORS = (
    "[|", "|]", "[[", "]]", "{|", "|}", "(|", "|)", "|~|", "|||", "||", "[]", "[>", "[+", "+]", "/\\", "/+", "+\\",
    "[T=", "[F=", "[FD=", "[V=", "[VD=", "[R=", "[RD=", "[OZ=", "[|>", "|>", "|\\", "<->", "<-", "->", "<=", ">=",
    "==", "!=", "::", "@@", "&&",
)  # fmt: skip


class CspmLexer(RegexLexer):  # type: ignore[misc]
    """CSPm scripts, with CSP-OZ classes in the text notation."""

    name = "CSPm"
    aliases: ClassVar[list[str]] = ["cspm", "csp", "csp-oz"]
    filenames: ClassVar[list[str]] = ["*.csp", "*.cspm"]
    mimetypes: ClassVar[list[str]] = ["text/x-cspm"]
    url = "https://en.wikipedia.org/wiki/Communicating_sequential_processes"

    tokens: ClassVar[dict[str, list[object]]] = {
        "root": [
            (r"\s+", Whitespace),
            (
                r"(--\s*)(expect)(:\s*)(pass|fail|unknown)\b",
                bygroups(Comment, Keyword.Pseudo, Comment, Keyword.Constant),
            ),
            (r"--.*", Comment.Single),
            (r"\{-", Comment.Multiline, "comment"),
            (r'"(\\.|[^"\\\n])*"', String),
            (r"'(\\.|[^'\\\n])'", String.Char),
            (
                r"(:\[)([^\[\]\n]*(?:\[[A-Z]+\])?)(\])(:?)",
                bygroups(Operator, Keyword.Pseudo, Operator, Operator),
            ),
            (
                r"(class|module|instance|datatype|subtype|nametype|schema)(\s+)(\w+)",
                bygroups(Keyword.Declaration, Whitespace, Name.Class),
            ),
            (r"(channel|chan|method)\b", Keyword.Declaration),
            (words(KEYWORDS, prefix=r"\b", suffix=r"\b"), Keyword),
            (words(CLASS_KEYWORDS, prefix=r"\b", suffix=r"\b"), Keyword.Reserved),
            (words(("and", "or", "not"), prefix=r"\b", suffix=r"\b"), Operator.Word),
            (words(("true", "false"), prefix=r"\b", suffix=r"\b"), Keyword.Constant),
            (
                words(
                    tuple(sorted(BUILTINS | EXTERNAL | TRANSPARENT | TIMED_BUILTINS)), prefix=r"\b", suffix=r"\b(?!')"
                ),
                Name.Builtin,
            ),
            (r"^([^\W\d]\w*'*)(?=\s*(\([^()\n]*\)\s*)*=(?!=))", Name.Function),
            (r"\d+(\.\d+)?", Number.Integer),
            (r"[^\W\d]\w*'*", Name),
            (words(OPERATORS), Operator),
            (r"[-+*/%<>=&|;\\!?$@#~^.:∈∉≤≥≠∧∨¬∀∃λμ∪∩∖ΔℕℤℝΣ⟨⟩⌢↦→⇒⇔⇸×∅⊆⊂□⊓‖]", Operator),
            (r"[()\[\]{},_]", Punctuation),
            (r".", Text),
        ],
        "comment": [
            (r"[^{}-]+", Comment.Multiline),
            (r"\{-", Comment.Multiline, "#push"),
            (r"-\}", Comment.Multiline, "#pop"),
            (r"[{}-]", Comment.Multiline),
        ],
    }
