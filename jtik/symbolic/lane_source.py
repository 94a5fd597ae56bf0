"""C of a function whose numbers are vectors: it evaluates several points at once, lane by lane.

CasADi's own C is one number at a time. Here each instruction of the function becomes an operation on vectors, assigned
once; a truth value stays a mask for as long as it is used as one. All branches are evaluated, as in CasADi's C.
"""

from __future__ import annotations

import math
from collections.abc import Collection

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
    "INV": "1.0 / {0}",
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
    """C of ``void name(in..., out...)``, which needs `jtik.symbolic.lane_maths.LANE_MATHS` before it.

    Args:
        function: a function that `has_lanes`.
        name: the name.
        shared: numbers of the inputs that are the same for all lanes: ``const double*`` instead of ``const V*``.
    """
    parts = [_Part()]  # each begins with the sines and cosines of angles that the one before has computed
    part_of: dict[str, int] = {}  # of a variable
    held: dict[int, str] = {}  # the variable that a place of the work vector holds
    masks: set[str] = set()

    def number(place: int) -> str:
        variable = held[place]
        return f"number({variable})" if variable in masks else variable

    def truth(place: int) -> str:
        variable = held[place]
        return variable if variable in masks else f"({variable} != 0.0)"

    for i in range(function.n_instructions()):
        operation, variable = _NAMES[function.instruction_id(i)], f"a{i}"
        out, own = list(function.instruction_output(i)), list(function.instruction_input(i))
        at = 0 if operation == "INPUT" else max((part_of[held[place]] for place in own), default=0)
        if operation == "OUTPUT":
            parts[at].lines.append(f"out{out[0]}[{out[1]}] = {number(own[0])};")
            continue
        if operation == "INPUT":
            read = f"in{own[0]}[{own[1]}]"
            value = f"ALL({read})" if own[0] in shared else read
        elif operation == "CONST":
            value = f"ALL({_literal(function.instruction_constant(i))})"
        elif operation in _TURNS:
            angles = parts[at].angles
            angle = angles.setdefault(number(own[0]), len(angles))
            value = f"{_TURNS[operation]}{at}[{angle}]"
            at += 1
            if at == len(parts):
                parts.append(_Part())
        elif operation in _COMPARED:
            value = f"{number(own[0])} {_COMPARED[operation]} {number(own[1])}"
        elif operation in _JOINED:
            value = f"{truth(own[0])} {_JOINED[operation]} {truth(own[1])}"
        elif operation == "NOT":
            value = f"~{truth(own[0])}"
        elif operation == "IF_ELSE_ZERO":
            value = f"where({truth(own[0])}, {number(own[1])})"
        else:
            value = _NUMBERS[operation].format(*map(number, own))
        if operation in _COMPARED or operation in _JOINED or operation == "NOT":
            masks.add(variable)
        parts[at].lines.append(f"const {'M' if variable in masks else 'V'} {variable} = {value};")
        held[out[0]], part_of[variable] = variable, at
    lines = [line for k, part in enumerate(parts) for line in part.source(k)]
    inputs = [f"const {'double' if k in shared else 'V'}* restrict in{k}" for k in range(function.n_in())]
    outputs = [f"V* restrict out{k}" for k in range(function.n_out())]
    return f"static JTIK_CPU void {name}({', '.join(inputs + outputs)}) {{\n" + "\n".join(lines) + "\n}\n"


class _Part:
    """A part of the code, and the angles whose sines and cosines are computed at its end.

    Attributes:
        lines: the code.
        angles: the position of each angle in the call.
    """

    def __init__(self) -> None:
        self.lines: list[str] = []
        self.angles: dict[str, int] = {}

    def source(self, number: int) -> list[str]:
        """The code of part ``number``, and the call."""
        count = len(self.angles)
        if not count:
            return self.lines
        angles = f"const V x{number}[{count}] = {{{', '.join(self.angles)}}};"
        call = f"V s{number}[{count}], c{number}[{count}]; v_turns({count}, x{number}, s{number}, c{number});"
        return [*self.lines, angles, call]


def _literal(value: float) -> str:
    if math.isnan(value):
        return "NAN"
    return float(value).hex() if math.isfinite(value) else ("INFINITY" if value > 0 else "-INFINITY")
