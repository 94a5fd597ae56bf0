"""The operations of a function in lanes: CasADi's, each value assigned once, and fewer of them for the same values.

A truth value stays a mask for as long as it is used as one, and a value that one of two opposite masks picks is one
choice. A product that only a sum or a difference uses is one operation with it, rounded once. The difference of two
products stays as it is: that of equal products is exactly zero. Several divisions by the same number are one division,
and products with the inverse: they differ by rounding, and a division takes as long as ten products.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, replace

import casadi

from jtik.symbolic.operations import Function

NAMES = {value: name[3:] for name, value in vars(casadi).items() if name.startswith("OP_")}
"""CasADi's names of operations, by their numbers."""

COMPARISONS = frozenset({"LT", "LE", "EQ", "NE"})

MASKS = COMPARISONS | {"AND", "OR", "NOT"}
"""Operations whose value is a mask."""

_TRUTHS = {"AND": 2, "OR": 2, "NOT": 1, "IF_ELSE_ZERO": 1, "CHOOSE": 1}
"""How many operands are used as truth values, the first ones."""

_PRODUCTS = ("MUL", "SQ")


@dataclass(frozen=True)
class Operation:
    """A value that is assigned once.

    Attributes:
        name: CasADi's name of the operation; or CHOOSE (mask, value where it holds, value elsewhere), or FMA (a, b, c),
            a b + c, FMS (a, b, c), a b - c, FNMA (a, b, c), c - a b.
        value: the variable that holds the value; of an output its place.
        operands: the variables that it is computed from; of an input or a constant, what it is.
    """

    name: str
    value: str
    operands: tuple[str, ...]


def operations(function: Function) -> list[Operation]:
    """The operations of a function, each after those whose values it uses.

    Args:
        function: a function of scalar instructions.
    """
    found: list[Operation] = []
    held: dict[int, str] = {}  # the variable that a place of the work vector holds
    for i in range(function.n_instructions()):
        name, variable = NAMES[function.instruction_id(i)], f"a{i}"
        out, own = list(function.instruction_output(i)), list(function.instruction_input(i))
        operands: tuple[str, ...] = tuple(held[place] for place in own) if name != "INPUT" else ()
        if name == "OUTPUT":
            variable = f"out{out[0]}[{out[1]}]"
        elif name == "INPUT":
            operands = (f"in{own[0]}[{own[1]}]",)
        elif name == "CONST":
            operands = (float(function.instruction_constant(i)).hex(),)
        found.append(Operation(name, variable, operands))
        if name != "OUTPUT":
            held[out[0]] = variable
    for change in (_with_masks, _with_choices, _with_inverses, _fused):
        found = _used(change(found))
    return found


def _arguments(operation: Operation) -> tuple[str, ...]:
    """The variables that an operation uses."""
    return () if operation.name in ("INPUT", "CONST") else operation.operands


def _used(found: list[Operation]) -> list[Operation]:
    """The operations whose values are used."""
    kept: list[Operation] = []
    used: set[str] = set()
    for each in reversed(found):
        if each.name == "OUTPUT" or each.value in used:
            used.update(_arguments(each))
            kept.append(each)
    return kept[::-1]


def _as_numbers(found: Iterable[Operation]) -> set[str]:
    """The variables that are used as numbers."""
    return {operand for each in found for operand in _arguments(each)[_TRUTHS.get(each.name, 0) :]}


def _with_masks(found: list[Operation]) -> list[Operation]:
    """The same with values that are 0 or 1, and used as truth values alone, as masks."""
    masks: set[str] = set()
    numbers = _as_numbers(found)
    changed: list[Operation] = []
    for each in found:
        if each.name == "IF_ELSE_ZERO" and each.operands[1] in masks:
            each = replace(each, name="AND")
        elif each.name == "ADD" and masks.issuperset(each.operands) and each.value not in numbers:
            each = replace(each, name="OR")
        if each.name in MASKS:
            masks.add(each.value)
        changed.append(each)
    return changed


def _with_choices(found: list[Operation]) -> list[Operation]:
    """The same with one operation for the sum of two values of which a mask picks one."""
    by_value = {each.value: each for each in found}
    changed: list[Operation] = []
    for each in found:
        if each.name == "ADD":
            first, second = (by_value[operand] for operand in each.operands)
            if first.name == second.name == "IF_ELSE_ZERO":
                (one, a), (other, b) = first.operands, second.operands
                if by_value[other] == Operation("NOT", other, (one,)):
                    each = Operation("CHOOSE", each.value, (one, a, b))
                elif by_value[one] == Operation("NOT", one, (other,)):
                    each = Operation("CHOOSE", each.value, (other, b, a))
        changed.append(each)
    return changed


def _with_inverses(found: list[Operation]) -> list[Operation]:
    """The same with an inverse, and products, for each divisor of several divisions."""
    divisions = Counter(each.operands[1] for each in found if each.name == "DIV")
    inverses: dict[str, str] = {}
    changed: list[Operation] = []
    for each in found:
        if each.name == "DIV" and divisions[each.operands[1]] > 1:
            number, divisor = each.operands
            if divisor not in inverses:
                inverses[divisor] = f"i{len(inverses)}"
                changed.append(Operation("INV", inverses[divisor], (divisor,)))
            each = Operation("MUL", each.value, (number, inverses[divisor]))
        changed.append(each)
    return changed


def _fused(found: list[Operation]) -> list[Operation]:
    """The same with products fused into the sums and differences that alone use them."""
    uses = Counter(operand for each in found for operand in _arguments(each))
    factors = {each.value: (each.operands * 2)[:2] for each in found if each.name in _PRODUCTS}
    changed: list[Operation] = []
    for each in found:
        if each.name in ("ADD", "SUB") and not (each.name == "SUB" and factors.keys() >= {*each.operands}):
            once = [place for place in (1, 0) if each.operands[place] in factors and uses[each.operands[place]] == 1]
            if once:
                name = "FMA" if each.name == "ADD" else "FNMA" if once[0] else "FMS"
                operands = (*factors[each.operands[once[0]]], each.operands[1 - once[0]])
                each = Operation(name, each.value, operands)
        changed.append(each)
    return changed
