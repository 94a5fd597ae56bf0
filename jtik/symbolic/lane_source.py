"""C of a function whose numbers are vectors: it evaluates several points at once, lane by lane.

CasADi's own C is one number at a time. Here each instruction of the function becomes an operation on vectors, assigned
once; a truth value stays a mask for as long as it is used as one. All branches are evaluated, as in CasADi's C.

A product that only a sum or a difference uses is one operation with it, rounded once. The difference of two products
stays as it is: that of equal products is exactly zero. Several divisions by the same number are one division, and
products with the inverse: they differ by rounding, and a division takes as long as ten products.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Collection
from dataclasses import dataclass

import casadi

from jtik.symbolic.operations import Function

_NAMES = {value: name[3:] for name, value in vars(casadi).items() if name.startswith("OP_")}

_COMPARED = {"LT": "<", "LE": "<=", "EQ": "==", "NE": "!="}
_JOINED = {"AND": "&", "OR": "|"}

_ONE = (
    "exp",
    "log",
    "tan",
    "asin",
    "acos",
    "atan",
    "sinh",
    "cosh",
    "tanh",
    "asinh",
    "acosh",
    "atanh",
    "floor",
    "ceil",
    "erf",
    "log1p",
    "expm1",
)
_TWO = ("pow", "fmod", "copysign", "hypot")
"""Functions of the C library, called for each lane."""

_NUMBERS = {
    "ASSIGN": "{0}",
    "ADD": "{0} + {1}",
    "SUB": "{0} - {1}",
    "MUL": "{0} * {1}",
    "DIV": "{0} / {1}",
    "NEG": "-{0}",
    "SQ": "{0} * {0}",
    "TWICE": "{0} + {0}",
    "INV": "ALL(1.0) / {0}",
    "SQRT": "v_sqrt({0})",
    "FABS": "v_fabs({0})",
    "SIGN": "v_sign({0})",
    "ATAN2": "v_atan2({0}, {1})",
    "FMIN": "v_fmin({0}, {1})",
    "FMAX": "v_fmax({0}, {1})",
    **{name.upper(): f"ONE({name}, {{0}})" for name in _ONE},
    **{name.upper(): f"TWO({name}, {{0}}, {{1}})" for name in _TWO},
    "CONSTPOW": "TWO(pow, {0}, {1})",
}
"""C of an operation on numbers, by its name."""

_TURNS = {"SIN": "s", "COS": "c"}

_OTHERS = {*_COMPARED, *_JOINED, *_TURNS, "NOT", "IF_ELSE_ZERO", "CONST", "INPUT", "OUTPUT"}


def has_lanes(function: Function) -> bool:
    """Whether `lane_source` can write a function: one of scalar instructions alone, which it knows.

    Args:
        function: the function.
    """
    if not function.is_a("SXFunction"):
        return False
    known = _NUMBERS.keys() | _OTHERS
    return all(_NAMES[function.instruction_id(i)] in known for i in range(function.n_instructions()))


def lane_source(function: Function, name: str, shared: Collection[int]) -> str:
    """C of ``void name(in..., out...)``, which needs the code of `jtik.symbolic.lane_maths` before it.

    Args:
        function: a function that `has_lanes`.
        name: the name.
        shared: numbers of the inputs that are the same for all lanes: ``const R*`` instead of ``const V*``.
    """
    assigned: list[_Assignment] = []
    angles: list[dict[str, int]] = []  # whose sines and cosines are computed after each part of the code
    part_of: dict[str, int] = {}  # of a variable
    held: dict[int, str] = {}  # the variable that a place of the work vector holds
    masks: set[str] = set()
    uses: Counter[str] = Counter()

    def variable_at(place: int) -> str:
        uses[held[place]] += 1
        return held[place]

    def number(place: int) -> str:
        variable = variable_at(place)
        return f"number({variable})" if variable in masks else variable

    def truth(place: int) -> str:
        variable = variable_at(place)
        return variable if variable in masks else f"({variable} != 0.0)"

    for i in range(function.n_instructions()):
        operation, variable = _NAMES[function.instruction_id(i)], f"a{i}"
        out, own = list(function.instruction_output(i)), list(function.instruction_input(i))
        part = 0 if operation == "INPUT" else max((part_of[held[place]] for place in own), default=0)
        operands: list[str] = []
        if operation == "OUTPUT":
            assigned.append(_Assignment(part, f"out{out[0]}[{out[1]}]", number(own[0])))
            continue
        if operation == "INPUT":
            read = f"in{own[0]}[{own[1]}]"
            value = f"ALL({read})" if own[0] in shared else read
        elif operation == "CONST":
            value = f"ALL({_literal(function.instruction_constant(i))})"
        elif operation in _TURNS:
            if part == len(angles):
                angles.append({})
            angle = angles[part].setdefault(number(own[0]), len(angles[part]))
            value = f"{_TURNS[operation]}{part}[{angle}]"
            part += 1
        elif operation in _COMPARED:
            value = f"{number(own[0])} {_COMPARED[operation]} {number(own[1])}"
        elif operation in _JOINED:
            value = f"{truth(own[0])} {_JOINED[operation]} {truth(own[1])}"
        elif operation == "NOT":
            value = f"~{truth(own[0])}"
        elif operation == "IF_ELSE_ZERO":
            value = f"where({truth(own[0])}, {number(own[1])})"
        else:
            value, operands = _NUMBERS[operation], [number(place) for place in own]
        if operation in _COMPARED or operation in _JOINED or operation == "NOT":
            masks.add(variable)
        kind = "const M " if variable in masks else "const V "
        assigned.append(_Assignment(part, kind + variable, value, tuple(operands), operation))
        held[out[0]], part_of[variable] = variable, part
    lines: list[list[str]] = [[] for _ in range(len(angles) + 1)]
    for each in _fused(_with_inverses(assigned), uses):
        lines[each.part].append(f"{each.variable} = {each.value.format(*each.operands)};")
    for k, own_angles in enumerate(angles):
        count = len(own_angles)
        lines[k].append(f"const V x{k}[{count}] = {{{', '.join(own_angles)}}};")
        lines[k].append(f"V s{k}[{count}], c{k}[{count}]; v_sin_cos({count}, x{k}, s{k}, c{k});")
    inputs = [f"const {'R' if k in shared else 'V'}* restrict in{k}" for k in range(function.n_in())]
    outputs = [f"V* restrict out{k}" for k in range(function.n_out())]
    body = "\n".join(line for part_lines in lines for line in part_lines)
    return f"static JTIK_CPU void {name}({', '.join(inputs + outputs)}) {{\n{body}\n}}\n"


@dataclass(frozen=True)
class _Assignment:
    """The value of a variable.

    Attributes:
        part: the part of the code: the sines and cosines that the parts before need are known.
        variable: the variable, with its type.
        value: its value as C, with a field for each operand.
        operands: the operands of an arithmetic operation.
        operation: name of the operation.
    """

    part: int
    variable: str
    value: str
    operands: tuple[str, ...] = ()
    operation: str = ""


def _with_inverses(assigned: list[_Assignment]) -> list[_Assignment]:
    """The assignments with an inverse, and products, for each divisor of several divisions.

    Args:
        assigned: the assignments, each after those that it uses.
    """
    divisions = Counter(each.operands[1] for each in assigned if each.operation == "DIV")
    part_of = {each.variable.split()[-1]: each.part for each in assigned}
    inverses: dict[str, str] = {}
    found: list[_Assignment] = []
    for each in assigned:
        if each.operation == "DIV" and divisions[each.operands[1]] > 1:
            number, divisor = each.operands
            if divisor not in inverses:
                inverses[divisor] = f"i{len(inverses)}"
                part = part_of.get(divisor, each.part)  # `number(mask)` is no variable
                found.append(_Assignment(part, f"const V {inverses[divisor]}", "ALL(1.0) / {0}", (divisor,), "INV"))
            each = _Assignment(each.part, each.variable, "{0} * {1}", (number, inverses[divisor]), "MUL")
        found.append(each)
    return found


def _fused(assigned: list[_Assignment], uses: Counter[str]) -> list[_Assignment]:
    """The assignments with products fused into the sums and differences that alone use them.

    Args:
        assigned: the assignments, each after those that it uses.
        uses: how often each variable is used.
    """
    factors = {each.variable.split()[-1]: each.operands for each in assigned if each.operation == "MUL"}
    gone: set[str] = set()
    found: list[_Assignment] = []
    for each in assigned:
        product = sign = ""
        if each.operation in ("ADD", "SUB"):
            sign = "-" if each.operation == "SUB" else ""
            once = [operand for operand in each.operands if operand in factors and uses[operand] == 1]
            if once and not (sign and all(operand in factors for operand in each.operands)):
                product = once[-1]
        if product:
            gone.add(product)
            is_second = each.operands[1] == product
            value = f"v_fma({sign}{{0}}, {{1}}, {{2}})" if is_second else f"v_fma({{0}}, {{1}}, {sign}{{2}})"
            operands = (*factors[product], each.operands[0 if is_second else 1])
            each = _Assignment(each.part, each.variable, value, operands, "FMA")
        found.append(each)
    return [each for each in found if each.variable.split()[-1] not in gone]


def _literal(value: float) -> str:
    if math.isnan(value):
        return "NAN"
    return float(value).hex() if math.isfinite(value) else ("INFINITY" if value > 0 else "-INFINITY")
