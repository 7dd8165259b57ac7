"""Texts that once made something fail: a crash, a hang, memory without end, or words in the wrong place.

The random tests begin with them and damage them further. Numbers are small, so that nothing takes long that works.
"""

from __future__ import annotations

SCRIPTS: tuple[str, ...] = (
    # Texts as arguments of processes.
    'channel s\nP(t) = s -> P(t)\nQ = s -> Q\nS = P("+str(1)+") [|{s}|] Q\n'
    "R = P(<'a', 'b'>)\nassert S :[deadlock free]",
    'X = error("boom\\n::error::x\\r")\nassert X == 1',
    # Work without a search in it.
    "fib(n) = if n < 2 then n else fib(n - 1) + fib(n - 2)\nchannel a\nP = if fib(4) == 3 then STOP else a -> P\n"
    "assert fib(4) == 3\nassert P :[deadlock free]",
    "pw(n) = if n == 0 then 2 else pw(n - 1) * pw(n - 1)\nassert pw(4) == 5",
    "transparent normal\nchannel a, b\nP = a -> P [] b -> P [] a -> Q(4)\n"
    "Q(n) = if n == 0 then STOP else (a -> Q(n - 1) [] b -> Q(n - 1))\nassert normal(P) :[deadlock free]",
    "channel coin, tea, tock\nTimed(\\x @ 1) {\nM = coin -> WAIT(7) ; tea -> M\n}\nassert M :[deadlock free]",
    "channel a, b, c\nM = a -> M [] b -> M /\\ c -> M\nassert M :[deadlock free]",
    "channel c : {1..10}.{1..4}\nprint {| c |}",
    "channel n : Int\nQ = n!5 -> n!1 -> Q\nP = n!1 -> STOP [] n!5 -> STOP\nassert Q :[deadlock free]",
    # Long and odd lines.
    "X = 1 + {- " + "é" * 40 + " -}",
    "X = 1\x85Y = 2\u2028Z\xa0= 3",
    "f(<<<<x>>>>^<(((y)))>) = - - - - x\nX = 1+1+1+1+(((1)))",
)

CLASSES: tuple[str, ...] = (
    "given M\nreading M = 3\nclass C\n  chan a : [x : M]\nend\nassert C :[deadlock free]",
    "class Counter\n  chan up : [n! : {0..3}]\n  method reset\n  main = up -> main [] reset -> STOP\n"
    "  state n : {0..3}\n  init n = 0\n  op com_up Delta(n) n! : {0..3} where n < 3 and n' = n + 1 and n! = n'\n"
    "  op reset Delta(n) where n' = 0\nend\nassert Counter :[deadlock free]",
)

DOCUMENTS: tuple[str, ...] = (
    "\\begin{zed}\n[A]\\\\\nB\u00a0== 1\n\\end{zed}\n",
    "\\begin{zed}\n[A]\\\\\nB\u2028== 1\x85\\\\\x1cC == 2\n\\end{zed}\n",
    "\\begin{class}{C} \\chan a \\\\ main = a \\then main \\end{class}\n"
    "\\begin{cspm}\nassert C :[deadlock free]\n\\end{cspm}\n",
)

RUNS: tuple[bytes, ...] = (
    b'{"event": "a.0", "time": ' + 400 * b"9" + b"}\n",
    b'{"event": "a.0", "time": true}\n{"event": "\\u001b[31ma.0", "tasks": ["P", 3]}\n',
    2_000 * b"[" + b"\n",
    b'"a.\xff"\n',
)
