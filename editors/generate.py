"""Write the grammars of the editors from the words of the language: ``python editors/generate.py``.

One list of words and operators, that of the Pygments lexer, serves all: a test holds the files that lie here to it.
"""

from __future__ import annotations

import json
import re
from pathlib import Path

from cspcheck.cspm.prelude import BUILTINS, EXTERNAL, TIMED_BUILTINS, TRANSPARENT
from cspcheck.highlighting import CLASS_KEYWORDS, KEYWORDS, OPERATORS

HERE = Path(__file__).parent
FUNCTIONS = sorted(BUILTINS | EXTERNAL | TRANSPARENT | TIMED_BUILTINS)


def _words(items: tuple[str, ...] | list[str]) -> str:
    return rf"\b({'|'.join(map(re.escape, items))})\b(?!')"


def textmate() -> str:
    """The grammar that VS Code, Sublime Text and others read."""
    operators = "|".join(re.escape(item) for item in sorted(OPERATORS, key=len, reverse=True))
    patterns = [
        {
            "match": r"(--\s*)(expect)(:\s*)(pass|fail|unknown)\b",
            "captures": {
                "1": {"name": "comment.line.double-dash.cspm"},
                "2": {"name": "keyword.other.expect.cspm"},
                "3": {"name": "comment.line.double-dash.cspm"},
                "4": {"name": "constant.language.verdict.cspm"},
            },
        },
        {"name": "comment.line.double-dash.cspm", "match": r"--.*$"},
        {"include": "#comment"},
        {"name": "string.quoted.double.cspm", "match": r'"(\\.|[^"\\])*"'},
        {"name": "string.quoted.single.cspm", "match": r"'(\\.|[^'\\])'"},
        {
            "match": r"(:\[)([^\[\]]*(?:\[[A-Z]+\])?)(\])",
            "captures": {
                "1": {"name": "keyword.operator.cspm"},
                "2": {"name": "support.constant.property.cspm"},
                "3": {"name": "keyword.operator.cspm"},
            },
        },
        {
            "match": r"\b(class|module|instance|datatype|subtype|nametype|schema)\s+(\w+)",
            "captures": {"1": {"name": "storage.type.cspm"}, "2": {"name": "entity.name.type.cspm"}},
        },
        {"name": "storage.type.cspm", "match": r"\b(channel|chan|method)\b"},
        {"name": "keyword.control.cspm", "match": _words(KEYWORDS)},
        {"name": "keyword.other.class.cspm", "match": _words(CLASS_KEYWORDS)},
        {"name": "keyword.operator.word.cspm", "match": r"\b(and|or|not)\b"},
        {"name": "constant.language.cspm", "match": r"\b(true|false)\b"},
        {"name": "support.function.cspm", "match": _words(FUNCTIONS)},
        {
            "match": r"^\s*([A-Za-z]\w*'*)(?=\s*(\([^()]*\)\s*)*=(?!=))",
            "captures": {"1": {"name": "entity.name.function.cspm"}},
        },
        {"name": "constant.numeric.cspm", "match": r"\b\d+(\.\d+)?\b"},
        {"name": "keyword.operator.cspm", "match": operators},
        {"name": "keyword.operator.cspm", "match": r"[-+*/%<>=&|;\\!?$@#~^.:]"},
    ]
    comment = {
        "name": "comment.block.cspm",
        "begin": r"\{-",
        "end": r"-\}",
        "patterns": [{"include": "#comment"}],
    }
    document = {
        "$schema": "https://raw.githubusercontent.com/martinring/tmlanguage/master/tmlanguage.json",
        "name": "CSPm",
        "scopeName": "source.cspm",
        "fileTypes": ["csp", "cspm"],
        "patterns": patterns,
        "repository": {"comment": comment},
    }
    return json.dumps(document, indent=2, ensure_ascii=False) + "\n"


def vim() -> str:
    """The syntax file of Vim and Neovim."""
    operators = [op for op in OPERATORS if op not in ("::", "&&")]
    pattern = r"\|".join(re.sub(r"([\[\]\\~.*^$/])", r"\\\1", op) for op in sorted(operators, key=len, reverse=True))
    return f'''" Vim syntax file
" Language: CSPm, with CSP-OZ classes
" Made by editors/generate.py

if exists("b:current_syntax")
  finish
endif

syntax case match
syntax iskeyword @,48-57,_,'
syntax keyword cspmKeyword {" ".join(KEYWORDS)}
syntax keyword cspmKeyword channel chan method
syntax keyword cspmClass {" ".join(CLASS_KEYWORDS)}
syntax keyword cspmWord and or not
syntax keyword cspmConstant true false
syntax keyword cspmFunction {" ".join(FUNCTIONS)}
syntax match cspmNumber "\\<\\d\\+\\%(\\.\\d\\+\\)\\?\\>"
syntax match cspmOperator "{pattern}"
syntax match cspmDefinition "^\\s*\\zs\\h[[:alnum:]_']*\\ze\\s*\\%(([^()]*)\\s*\\)*=[^=]"
syntax match cspmProperty ":\\[[^]]*\\%(\\]\\]\\|\\]\\)"
syntax region cspmString start=+"+ skip=+\\\\.+ end=+"+ oneline
syntax region cspmComment start="--" end="$" keepend contains=cspmExpect,@Spell
syntax region cspmComment start="{{-" end="-}}" contains=cspmComment,@Spell
syntax match cspmExpect "expect:\\s*\\%(pass\\|fail\\|unknown\\)" contained

highlight default link cspmKeyword Keyword
highlight default link cspmClass Structure
highlight default link cspmWord Operator
highlight default link cspmConstant Boolean
highlight default link cspmFunction Function
highlight default link cspmNumber Number
highlight default link cspmOperator Operator
highlight default link cspmDefinition Identifier
highlight default link cspmProperty Special
highlight default link cspmString String
highlight default link cspmComment Comment
highlight default link cspmExpect Todo

let b:current_syntax = "cspm"
'''


FILES = {"vscode/syntaxes/cspm.tmLanguage.json": textmate, "vim/syntax/cspm.vim": vim}

if __name__ == "__main__":
    for name, make in FILES.items():
        (HERE / name).write_text(make(), encoding="utf-8")
