"""Stubborn sets: some of the rules that can fire in a state, such that the others can wait.

Valmari, "Stubborn sets for reduced state space generation" (Advances in Petri Nets 1990); for CSP: Gibson-Robinson,
Hansen, Roscoe and Wang, "Practical partial order reduction for CSP" (NFM 2015). What is kept of the states and why,
``cspcheck.checker.packing.stubborn`` says. A set is a function of the state alone: it does not matter in which order,
by which thread or process, or how often a state is expanded.

See ``cspcheck.checker.kernels.table`` for what is common to all kernels.
"""

from __future__ import annotations

from cspcheck.checker.arrays import Int64Array
from cspcheck.checker.kernels.arrays import Scratch, StubbornTables

TRIED = 24
"""So many sets are tried that would do; the smallest of them is taken."""


def hindrance(tables: StubbornTables, states: Int64Array, base: int, rule: int, scratch: Scratch, number: int) -> int:
    """The first slot that keeps a rule from firing; -1 if none does, -2 if a slot of set *number* does."""
    first = -1
    for part in range(tables.parts[rule], tables.parts[rule + 1]):
        slot = tables.slot[part]
        local = (states[base + tables.word[slot]] >> tables.shift[slot]) & tables.mask[slot]
        if tables.ready[tables.able[part] + local] == 0:
            if scratch.within[slot] == number:
                return -2
            if first < 0:
                first = slot
    return first


def closure(
    tables: StubbornTables, states: Int64Array, base: int, start: int, format: int, scratch: Scratch, number: int
) -> int:
    """Close {*start*} under dependence: mark its slots with *number*; how many rules can fire that slots of it move.

    What a slot of the set can take part in from where it is now either can fire, and then all its participants belong
    to the set, or is kept from it by a slot of the set. So nothing that moves a slot of the set can happen before one
    of these rules has fired.

    Returns:
        The number of rules, or -1 if one of them may not be in a set that leaves something out.
    """
    rules = 0
    head = 0
    tail = 1
    scratch.within[start] = number
    scratch.waiting[0] = start
    for entry in range(tables.wide_offsets[format], tables.wide_offsets[format + 1]):
        slot = hindrance(tables, states, base, tables.wide[entry], scratch, number)
        if slot == -1:
            return -1
        if slot >= 0:
            scratch.within[slot] = number
            scratch.waiting[tail] = slot
            tail += 1
    while head < tail:
        slot = scratch.waiting[head]
        head += 1
        row = tables.base[slot] + ((states[base + tables.word[slot]] >> tables.shift[slot]) & tables.mask[slot])
        for entry in range(tables.offsets[row], tables.offsets[row + 1]):
            rule = tables.entries[entry]
            if tables.format[rule] != format:
                continue
            other = hindrance(tables, states, base, rule, scratch, number)
            if other >= 0:
                scratch.within[other] = number
                scratch.waiting[tail] = other
                tail += 1
            elif other == -1:
                if tables.free[rule] == 0:
                    return -1
                if tables.slot[tables.parts[rule]] == slot:
                    rules += 1
                for part in range(tables.parts[rule], tables.parts[rule + 1]):
                    other = tables.slot[part]
                    if scratch.within[other] != number:
                        scratch.within[other] = number
                        scratch.waiting[tail] = other
                        tail += 1
    return rules


def stubborn_set(tables: StubbornTables, states: Int64Array, base: int, scratch: Scratch) -> int:
    """A stubborn set of the row that begins at *base*.

    Returns:
        A number, not 0, with which ``scratch.within`` marks the slots that its rules move; 0 if nothing is left out.
    """
    slots = len(tables.word)
    format = (states[base + tables.format_word] >> tables.format_shift) & tables.format_mask
    best = -1
    fewest = 0
    tried = 0
    start = 0
    number = scratch.within[slots]
    while True:
        number += 1
        rules = closure(tables, states, base, start, format, scratch, number)
        if start == best:
            break
        if rules > 0:
            tried += 1
            if best < 0 or rules < fewest:
                best = start
                fewest = rules
                if rules == 1:
                    break
        start += 1
        if start == slots or tried == TRIED:
            if best < 0:
                break
            start = best
    scratch.within[slots] = number
    return number if best >= 0 else 0


KERNELS = (hindrance, closure, stubborn_set)
