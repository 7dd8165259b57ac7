"""The markup of classes: which command stands for which token, in the union of the dialects that are in use.

The tidy forms are those of ``oz.sty`` with the spellings of ISO Z where it has one; others are read with a warning.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from cspcheck.cspm.oz.reading.operators import NUMBER_SETS, SPELLINGS

# --- tokens of Object-Z ------------------------------------------------------------------------------------------

_OTHERS: Final = {
    "forall": r"\forall \all",
    "exists": r"\exists \exi",
    "exists1": r"\exists_1 \exione",
    "lambda": r"\lambda",
    "mu": r"\mu",
    "if": r"\IF \zif",
    "then": r"\THEN \zthen",
    "else": r"\ELSE \zelse",
    "let": r"\LET \zlet",
    "true": r"\true",
    "false": r"\false",
    "EMPTY": r"\emptyset \varnothing \empty",
    "SEQUENCE_OPEN": r"\langle \lseq",
    "SEQUENCE_CLOSE": r"\rangle \rseq",
    "[[": r"\lbag",
    "]]": r"\rbag",
    "(|": r"\limg \lblot \lbind",
    "|)": r"\rimg \rblot \rbind",
    "<<": r"\ldata",
    ">>": r"\rdata \pipe",
    "@": r"\spot",
    "|": r"\mid \bar \vert",
    "where": r"\where \ST",
    "initially": r"\initially",
    "using": r"\using",
    "by": r"\induction",
    "inrel": r"\inrel",
    "==": "",
    "SDEF": r"\sdef \sdefs \defs \triangleq",
    ";": r"\semi \zcmp \dzcmp",
    "||": r"\pll \parallel",
    "||!": r"\plo",
    "[]": r"\gch \Box",
    "\\": r"\hide",
    "{": r"\{ \lbrace \lset",
    "}": r"\} \rbrace \rset",
    "[": r"\lsch \lbrack",
    "]": r"\rsch \rbrack",
    "..": r"\ldots \dots",
}
"""Commands by the kind of their token, tidy ones first."""

_BOTH_TIDY: Final = frozenset(
    [r"\lblot", r"\rblot", r"\spot", r"\mid", r"\hide", r"\semi", r"\pll", r"\gch", r"\parallel", r"\lsch", r"\rsch"]
)
"""Commands that are no tidier than the first of their kind, because they are used elsewhere."""

COMMANDS: dict[str, tuple[str, str]] = {}
"""The kind of a command's token, and the tidy form (empty for a command that is tidy)."""

for _kind, _texts in _OTHERS.items():
    for _number, _command in enumerate(_texts.split()):
        _tidy = "" if _number == 0 or _command in _BOTH_TIDY else _texts.split()[0]
        COMMANDS[_command] = (_kind, _tidy)
for _spelling in SPELLINGS:
    for _command in _spelling.latex:
        if _command.startswith("\\"):
            _tidy = "" if _command == _spelling.latex[0] else _spelling.latex[0]
            COMMANDS.setdefault(_command, (_spelling.text[0], _tidy))
for _command, _tidy in {
    r"\leftrightarrow": r"\rel",
    r"\rightarrow": r"\fun",
    r"\longrightarrow": r"\fun",
    r"\rightharpoonup": r"\pfun",
    r"\nrightarrow": r"\pfun",
    r"\rightarrowtail": r"\inj",
    r"\twoheadrightarrow": r"\surj",
    r"\Leftrightarrow": r"\iff",
    r"\longmapsto": r"\mapsto",
    r"\lhd": r"\dres",
    r"\triangleleft": r"\dres",
    r"\vartriangleleft": r"\dres",
    r"\rhd": r"\rres",
    r"\triangleright": r"\rres",
    r"\vartriangleright": r"\rres",
    r"\ominus": r"\symdiff",
    r"\backslash": r"\setminus",
    r"\leqslant": r"\leq",
    r"\geqslant": r"\geq",
    r"\smallfrown": r"\cat",
    r"\sim": r"\inv",
}.items():
    COMMANDS.setdefault(_command, (COMMANDS[_tidy][0], _tidy))
for _command, _kind in {r"\dcnj": "and", r"\dgch": "[]", r"\dsqc": ";", r"\dpll": "||"}.items():
    COMMANDS[_command] = (_kind, "")
COMMANDS[r"\cdot"] = COMMANDS[r"\ast"] = ("*", "*")
COMMANDS[r"\project"] = COMMANDS[r"\zproject"] = ("filter", "")
COMMANDS[r"\colon"] = (":", ":")
COMMANDS[r"\dot"] = COMMANDS[r"\bullet"] = ("@", "@")
COMMANDS[r"\ldots"] = ("..", r"\upto")
COMMANDS[r"\dots"] = ("..", r"\upto")

NAMES: Final[Mapping[str, tuple[str, str]]] = {
    **{markup: (name, "") for name, (_, markup) in NUMBER_SETS.items()},
    r"\integer": ("int", r"\num"),
    r"\Delta": ("Delta", ""),
    r"\Init": ("INIT", ""),
    r"\INIT": ("INIT", r"\Init"),
    r"\chan": ("chan", ""),
    r"\method": ("method", ""),
    r"\localchan": ("local_chan", ""),
    r"\inherit": ("inherit", ""),
    r"\main": ("main", ""),
    r"\visibility": ("visible", ""),
    r"\project": ("visible", r"\visibility"),
    r"\zproject": ("visible", r"\visibility"),
    r"\upharpoonright": ("visible", r"\visibility"),
    r"\reading": ("reading", ""),
    r"\view": ("view", ""),
    r"\retrieve": ("retrieve", ""),
    r"\between": ("between", ""),
    r"\theta": ("theta", ""),
    r"\pre": ("pre", ""),
    r"\self": ("self", ""),
    r"\oid": ("oid", ""),
    **{rf"\{word}": (word, "") for word in ("head", "tail", "last", "front", "rev", "squash", "items", "first")},
    r"\Skip": ("SKIP", ""),
    r"\Stop": ("STOP", ""),
    r"\Chaos": ("CHAOS", ""),
    r"\Div": ("DIV", ""),
    **{rf"\{word}": (word, "") for word in ("second", "min", "max", "succ", "count")},
}
"""Commands that stand for a name."""

BLACKBOARD: Final[Mapping[str, str]] = {
    "N": r"\nat",
    "Z": r"\num",
    "R": r"\real",
    "B": r"\bool",
    "P": r"\power",
    "F": r"\finset",
}
"""What is meant by ``\\mathbb{N}`` and its like."""

WORDS: Final = frozenset(["if", "then", "else", "let", "true", "false", "and", "or", "not", "dom", "ran", "div", "mod"])
"""Plain words that are read as the operators that they look like, with a warning."""

NO_NAMES: Final = frozenset(["end", "where", "inrel"])
"""Words that the text notation has no names of: names in markup that are so called have a ``_`` behind them."""

LINE_BREAKS: Final = frozenset(
    [r"\also", r"\Also", r"\classbreak", r"\zbreak", r"\opbreak", r"\eol", r"\cr", r"\newline"]
)
BLANKS: Final = frozenset(
    [
        *(r"\quad", r"\qquad", r"\left", r"\right", r"\big", r"\Big", r"\bf", r"\it", r"\sf", r"\rm", r"\tt"),
        *(r"\displaystyle", r"\nextside", r"\noindent", r"\endinherit", r"\locpar", r"\endlocpar", r"\znewpage", r"\t"),
        *(r"\textstyle", r"\ensuremath", r"\smallskip", r"\medskip", r"\bigskip", r"\hfill", r"\zhide", r"\sloppy"),
        *(r"\cid", r"\sid", r"\eid", r"\varg"),
    ]
)
"""Commands that are layout only."""

FONTS: Final = frozenset(
    [
        *(r"\mathit", r"\mathrm", r"\mathsf", r"\mathbf", r"\mathtt", r"\mathcal", r"\textit", r"\textbf", r"\textsf"),
        *(r"\texttt", r"\emph", r"\operatorname", r"\textsc", r"\mathrel", r"\mathbin", r"\mathord", r"\mathop"),
    ]
)
"""Commands whose argument is read as if they were not there."""

WITH_ARGUMENT: Final = frozenset(
    [r"\hspace", r"\vspace", r"\label", r"\Label", r"\ref", r"\cite", r"\index", r"\footnote"]
)
"""Commands that are left out with their argument."""

TEXTS: Final = frozenset([r"\text", r"\textrm", r"\mbox", r"\hbox", r"\comment", r"\textnormal"])
"""Commands whose argument is a comment, unless it is one of the words of the notation."""

UNSUPPORTED: Final[Mapping[str, str]] = {
    r"\dplo": "the associative parallel operator, distributed,",
}
"""What of Object-Z has no counterpart here, in words."""

UNREAD_LINES: Final[Mapping[str, str]] = {
    **dict.fromkeys([r"\relation", r"\function", r"\generic"], r"an operator template (`x \inrel{R} y` needs none)"),
}
"""Commands that begin a line which has no counterpart here, in words."""

SUPERSCRIPTS: Final = {
    **dict.fromkeys(["+"], "^+"),
    **dict.fromkeys(["*", r"\ast", r"\star"], "^*"),
    **dict.fromkeys(["-1", r"\sim", "~"], "~"),
}
"""What may stand above a name, by the postfix operator that it is."""

LONE: Final = {
    **{sign: sign for sign in "()[],;:.|@=<>+-*/"},
    "==": "==",
    "::=": "::=",
    "||": "||",
    "[]": "[]",
    "..": "..",
    "<=": "<=",
    ">=": ">=",
    "!=": "!=",
}
"""Signs that are tokens of the notation as they stand."""

# --- tokens of CSP -----------------------------------------------------------------------------------------------

CSP_SIGNS: Final[Mapping[str, str]] = {
    "->": r"\then",
    "[]": r"\extchoice",
    "|~|": r"\intchoice",
    "|||": r"\interleave",
    "||": r"\parallel",
    "COMPOSES": r"\parallel",
    "[|": r"\lpar",
    "|]": r"\rpar",
    "\\": r"\circhide",
    "|\\": r"\circproject",
    "&": r"\circguard",
    ";": r"\circseq",
    "[>": r"\timeout",
    "/\\": r"\interrupt",
    "{|": r"\lchanset",
    "|}": r"\rchanset",
    "{": r"\{",
    "}": r"\}",
    "SEQUENCE_OPEN": r"\langle",
    "SEQUENCE_CLOSE": r"\rangle",
    "LESS": "<",
    "<=": r"\leq",
    ">=": r"\geq",
    "!=": r"\neq",
    "and": r"\land",
    "or": r"\lor",
    "not": r"\lnot",
    "^": r"\cat",
    "#": r"\#",
    "%": r"\%",
    "$": r"\$",
    "if": r"\IF",
    "then": r"\THEN",
    "else": r"\ELSE",
    "let": r"\LET",
    "within": r"\WITHIN",
    "true": r"\true",
    "false": r"\false",
    "..": r"\upto",
    "[[": r"\lrename",
    "]]": r"\rrename",
    "<-": r"\from",
    "<->": r"\rel",
    "(|": r"\lmap",
    "|)": r"\rmap",
    "|>": r"\rthrow",
    "/+": r"\lsync",
    "+\\": r"\rsync",
    "_": r"\_",
}
"""How the signs and words of CSPm are marked up; what is not here is written as it is."""

CSP_COMMANDS: dict[str, str] = {command: sign for sign, command in CSP_SIGNS.items() if command.startswith("\\")}
CSP_COMMANDS |= {
    r"\langle": "<",
    r"\rangle": ">",
    r"\parallel": "||",
    r"\Extchoice": "[]",
    r"\Intchoice": "|~|",
    r"\Interleave": "|||",
    r"\Box": "[]",
    r"\gch": "[]",
    r"\sqcap": "|~|",
    r"\pll": "||",
    r"\rightarrow": "->",
    r"\to": "->",
    r"\hide": "\\",
    r"\semi": ";",
    r"\le": "<=",
    r"\ge": ">=",
    r"\ne": "!=",
    r"\wedge": "and",
    r"\vee": "or",
    r"\neg": "not",
    r"\mod": "%",
    r"\negate": "-",
    r"\lambda": "\\",
    r"\spot": "@",
    r"\sdef": "=",
    r"\sdefs": "=",
    r"\defs": "=",
    r"\triangleq": "=",
    r"\main": "main",
    r"\&": "&",
    r"\lbrace": "{",
    r"\rbrace": "}",
}
"""What a command stands for in the equations of a class."""

CSP_CLOSERS: Final = frozenset([r"\rrename", r"\rchanset", r"\rmap"])
"""Commands that close brackets of CSP, behind which an operand is complete."""
