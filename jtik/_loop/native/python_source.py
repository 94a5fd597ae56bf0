"""C that reads Python's objects and makes new ones, for functions that Python calls."""

from __future__ import annotations

from collections.abc import Mapping

from jtik._loop.native.object_layout import HEAD
from jtik.symbolic import Function
from jtik.symbolic import function as function_of
from jtik.task import TaskStack

FASTCALL = 0x80
"""The kind of a function that Python calls with an array of arguments, METH_FASTCALL."""

FUNCTIONS = {
    "call": "PyObject_CallFunctionObjArgs",
    "pass_on": "PyObject_Vectorcall",
    "number": "PyFloat_FromDouble",
    "integer": "PyLong_FromLongLong",
    "allocate": "PyType_GenericAlloc",
    "fill": "PyTuple_SetItem",
    "pack": "PyTuple_Pack",
    "bytes": "PyBytes_FromStringAndSize",
    "content": "PyBytes_AsString",
    "bind": "PyMethod_New",
    "set": "PyObject_GenericSetAttr",
    "compare": "PyObject_RichCompareBool",
    "hold": "Py_IncRef",
    "release": "Py_DecRef",
    "leave": "PyEval_SaveThread",
    "enter": "PyEval_RestoreThread",
}
"""Functions of Python's C interface, and their names there. Each has a type of C: that of ``call`` is to_call."""

NEW_ARRAY = 94
"""Place of ``PyArray_NewFromDescr`` among the functions of NumPy's C interface, ``new_array`` in C."""

SOURCE = r"""
#include <stddef.h>
#include <string.h>

#ifndef CASADI_SYMBOL_EXPORT
#define CASADI_SYMBOL_EXPORT
#endif

typedef char* (*JTIK_NAME_to_call)(char*, ...);
typedef char* (*JTIK_NAME_to_pass_on)(char*, char* const*, size_t, char*);
typedef char* (*JTIK_NAME_to_number)(double);
typedef char* (*JTIK_NAME_to_integer)(long long);
typedef char* (*JTIK_NAME_to_allocate)(char*, ptrdiff_t);
typedef int (*JTIK_NAME_to_fill)(char*, ptrdiff_t, char*);
typedef char* (*JTIK_NAME_to_pack)(ptrdiff_t, ...);
typedef char* (*JTIK_NAME_to_bytes)(const char*, ptrdiff_t);
typedef char* (*JTIK_NAME_to_content)(char*);
typedef char* (*JTIK_NAME_to_bind)(char*, char*);
typedef int (*JTIK_NAME_to_set)(char*, char*, char*);
typedef int (*JTIK_NAME_to_compare)(char*, char*, int);
typedef void (*JTIK_NAME_to_hold)(char*);
typedef void (*JTIK_NAME_to_release)(char*);
typedef void* (*JTIK_NAME_to_leave)(void);
typedef void (*JTIK_NAME_to_enter)(void*);
typedef char* (*JTIK_NAME_to_new_array)(char*, char*, int, const ptrdiff_t*, const ptrdiff_t*, void*, int, char*);

/* A NumPy array after the head of every object. */
typedef struct {
  char* data;
  int dimensions;
  const ptrdiff_t* shape;
  const ptrdiff_t* strides;
  void* base;
  const char* type;
} JTIK_NAME_array;

/* Python's PyMethodDef. */
typedef struct {
  const char* name;
  char* (*call)(char*, char* const*, ptrdiff_t);
  int kind;
  const char* text;
} JTIK_NAME_method;

static const JTIK_NAME_array* JTIK_NAME_fields(const char* object) {
  return (const JTIK_NAME_array*)(object + JTIK_HEAD);
}

static const char* JTIK_NAME_type(const char* object) {
  return *(const char* const*)(object + JTIK_HEAD - sizeof(char*));
}

/* The array of doubles that an object is; 0 where it is something else. */
static const JTIK_NAME_array* JTIK_NAME_doubles(const char* object, const char* array_type, const char* float64) {
  const JTIK_NAME_array* array = JTIK_NAME_fields(object);
  return JTIK_NAME_type(object) == array_type && array->type == float64 ? array : 0;
}

/* Copy a vector of this size; 0 where the array is none. */
static int JTIK_NAME_copied(const JTIK_NAME_array* array, ptrdiff_t size, double* to) {
  if (array->dimensions != 1 || array->shape[0] != size) return 0;
  for (ptrdiff_t i = 0; i < size; ++i) memcpy(to + i, array->data + i * array->strides[0], sizeof(double));
  return 1;
}

/* A new array of a configuration, whose numbers are not set. */
static char* JTIK_NAME_new(JTIK_NAME_to_new_array make, char* array_type, char* float64, JTIK_NAME_to_hold hold) {
  const ptrdiff_t size = JTIK_NQ;
  hold(float64); /* the array has it then */
  return make(array_type, float64, 1, &size, 0, 0, 0, 0);
}

#if JTIK_READS
/* Read a matrix (4, 4) as a target; 0 where the array is none, or is no pose. */
static int JTIK_NAME_read(const JTIK_NAME_array* array, double* to) {
  double T[16], target[JTIK_TARGET_SIZE], valid[1], w[JTIK_READER_W];
  const double* arg[JTIK_READER_ARG] = {T};
  double* res[JTIK_READER_RES] = {target, valid};
  long long iw[JTIK_READER_IW];
  if (array->dimensions != 2 || array->shape[0] != 4 || array->shape[1] != 4) return 0;
  for (ptrdiff_t i = 0; i < 16; ++i) {
    memcpy(T + i, array->data + i / 4 * array->strides[0] + i % 4 * array->strides[1], sizeof(double));
  }
  if (JTIK_NAME_matrix(arg, res, iw, w, 0) || !valid[0]) return 0;
  memcpy(to, target, sizeof target);
  return 1;
}
#endif

/* Write an array as the target; 0 where it is left to Python. A vector need not be finite. */
static int JTIK_NAME_aimed(const JTIK_NAME_array* goal, double* to) {
#if JTIK_READS
  if (JTIK_NAME_read(goal, to)) return 1;
#endif
  return JTIK_IS_VECTOR && JTIK_NAME_copied(goal, JTIK_TARGET_SIZE, to);
}
"""


def constants(tasks: TaskStack) -> dict[str, int]:
    """The numbers that the code names."""
    reader = matrix_reader(tasks)
    return {
        **work_sizes("READER", reader),
        "READS": int(reader is not None),
        "IS_VECTOR": int(tasks.target_is_vector),
        "NQ": tasks.robot.nq,
        "TARGET_SIZE": tasks.target_size,
        "HEAD": HEAD,
        "FASTCALL": FASTCALL,
    }


def members(memory: Mapping[str, str]) -> str:
    """The members of a structure of C, by name and type."""
    return "\n".join(f"  {kind} {name};" for name, kind in memory.items())


def matrix_reader(tasks: TaskStack, beside: str = "jtik_step") -> Function | None:
    """The function that reads a matrix as a target, by its name beside a function."""
    return named(tasks.matrix_reader, f"{beside}_matrix")


def named(function: Function | None, name: str) -> Function | None:
    """The same function with this name."""
    if function is None:
        return None
    symbols = function.sx_in() if function.is_a("SXFunction") else function.mx_in()
    return function_of(name, symbols, function.call(symbols))


def work_sizes(prefix: str, function: Function | None) -> dict[str, int]:
    """Sizes of the memory that a call of a function works in."""
    if function is None:
        return {}
    sizes = {"ARG": function.sz_arg(), "RES": function.sz_res(), "IW": function.sz_iw(), "W": function.sz_w()}
    return {f"{prefix}_{name}": max(size, 1) for name, size in sizes.items()}
