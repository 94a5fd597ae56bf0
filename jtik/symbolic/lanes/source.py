"""C of a function whose numbers are vectors: it evaluates several points at once, lane by lane.

CasADi's own C is one number at a time. Here each of `jtik.symbolic.lanes.operations` becomes one on vectors. Of a
branch both sides are evaluated, as in CasADi's C. Sines and cosines of several angles take less time at once.
"""

from __future__ import annotations

import math
from collections.abc import Collection

from jtik.symbolic.lanes.operations import MASKS, NAMES, Operation, operations
from jtik.symbolic.operations import Function

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
    "FMA": "v_fma({0}, {1}, {2})",
    "FMS": "v_fma({0}, {1}, -{2})",
    "FNMA": "v_fma(-{0}, {1}, {2})",
}
"""C of an operation on numbers, by its name."""

_PICKED = {"NOT": "~{0}", "IF_ELSE_ZERO": "where({0}, {1})", "CHOOSE": "choose({0}, {1}, {2})"}

_TURNS = {"SIN": "s", "COS": "c"}

_OTHERS = {*_COMPARED, *_JOINED, *_PICKED, *_TURNS, "CONST", "INPUT", "OUTPUT"}


def has_lanes(function: Function) -> bool:
    """Whether `lane_source` can write a function: one of scalar instructions alone, which it knows.

    Args:
        function: the function.
    """
    if not function.is_a("SXFunction"):
        return False
    known = _NUMBERS.keys() | _OTHERS
    return all(NAMES[function.instruction_id(i)] in known for i in range(function.n_instructions()))


def lane_source(function: Function, name: str, shared: Collection[int]) -> str:
    """C of ``void name(in..., out...)``, which needs the code of `jtik.symbolic.lanes.maths` before it.

    Args:
        function: a function that `has_lanes`.
        name: the name.
        shared: numbers of the inputs that are the same for all lanes: ``const R*`` instead of ``const V*``.
    """
    scalars = {f"in{k}" for k in shared}
    parts: list[list[str]] = [[]]  # of the code, with the sines and cosines between them
    angles: list[dict[str, int]] = []  # those between two parts
    part_of: dict[str, int] = {}  # of a variable
    masks: set[str] = set()

    for each in operations(function):
        part = max((part_of.get(operand, 0) for operand in each.operands), default=0)
        if each.name in _TURNS:
            if part == len(angles):
                angles.append({})
                parts.append([])
            angle = angles[part].setdefault(_number(each.operands[0], masks), len(angles[part]))
            value = f"{_TURNS[each.name]}{part}[{angle}]"
            part += 1
        else:
            value = _value(each, masks, scalars)
        if each.name in MASKS:
            masks.add(each.value)
        part_of[each.value] = part
        kind = "" if each.name == "OUTPUT" else "const M " if each.value in masks else "const V "
        parts[part].append(f"{kind}{each.value} = {value};")
    for k, own in enumerate(angles):
        parts[k].append(f"const V x{k}[{len(own)}] = {{{', '.join(own)}}};")
        parts[k].append(f"V s{k}[{len(own)}], c{k}[{len(own)}]; v_sin_cos({len(own)}, x{k}, s{k}, c{k});")
    inputs = [f"const {'R' if k in shared else 'V'}* restrict in{k}" for k in range(function.n_in())]
    outputs = [f"V* restrict out{k}" for k in range(function.n_out())]
    body = "\n".join(line for lines in parts for line in lines)
    return f"static JTIK_CPU void {name}({', '.join(inputs + outputs)}) {{\n{body}\n}}\n"


def _value(operation: Operation, masks: Collection[str], scalars: Collection[str]) -> str:
    """C of the value of an operation that is no sine or cosine.

    Args:
        operation: the operation.
        masks: the variables that are masks.
        scalars: the inputs that are the same for all lanes.
    """
    name, first = operation.name, operation.operands[0]
    if name == "INPUT":
        return f"ALL({first})" if first.split("[")[0] in scalars else first
    if name == "CONST":
        return f"ALL({_literal(float.fromhex(first))})"
    numbers = [_number(each, masks) for each in operation.operands]
    if name in _COMPARED:
        return f"MASK({numbers[0]} {_COMPARED[name]} {numbers[1]})"
    if name in _JOINED:
        return f"{_truth(first, masks)} {_JOINED[name]} {_truth(operation.operands[1], masks)}"
    if name in _PICKED:
        return _PICKED[name].format(_truth(first, masks), *numbers[1:])
    return numbers[0] if name == "OUTPUT" else _NUMBERS[name].format(*numbers)


def _number(variable: str, masks: Collection[str]) -> str:
    return f"number({variable})" if variable in masks else variable


def _truth(variable: str, masks: Collection[str]) -> str:
    return variable if variable in masks else f"({variable} != 0.0)"


def _literal(value: float) -> str:
    if math.isnan(value):
        return "NAN"
    return value.hex() if math.isfinite(value) else ("INFINITY" if value > 0 else "-INFINITY")
