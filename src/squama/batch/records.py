"""Records of arrays for compiled code: it passes the address of a named tuple, not the some hundred numbers in it.

Numba passes a tuple as one argument for each number in it, five and more for an array, so that functions of a large
tuple take long to compile. ``held(t)`` is the same tuple in the memory of the function that calls it, which nothing
changes, and the compiled code of other functions reads what it needs where it needs it. Tuples in the tuple are such
records, too. Without Numba's compiler ``held(t)`` is the tuple itself.
"""

from __future__ import annotations

import hashlib
from typing import Any, TypeVar

from llvmlite import ir
from numba import types
from numba.core import cgutils, typing
from numba.extending import (
    infer_getattr,
    lower_builtin,
    lower_getattr_generic,
    models,
    register_model,
    type_callable,
)

_T = TypeVar("_T")
_OWNER = 2
"""First members of an array, those of what owns its memory: a record owns nothing, so no references are counted."""


def held(record: _T) -> _T:
    """Return a named tuple as a record. It is there until the function returns, and must be kept there until then."""
    return record


class Held(types.Type):
    """A named tuple in memory."""

    def __init__(self, of: Any) -> None:
        self.of = of
        digest = hashlib.sha256(of.name.encode()).hexdigest()[:16]
        parent: Any = super()
        parent.__init__(f"{of.instance_class.__name__}_{digest}")

    def field(self, name: str) -> tuple[int, Any]:
        """Return place and type of a field of the tuple."""
        at = self.of.fields.index(name)
        return at, self.of.types[at]


register_model(Held)(models.OpaqueModel)


@type_callable(held)
def _type(context: Any) -> Any:
    def typed(record: Any) -> Any:
        return Held(record) if isinstance(record, types.BaseNamedTuple) else None

    return typed


@infer_getattr
class _Fields(typing.templates.AttributeTemplate):
    """Types of a record's fields."""

    key = Held

    def generic_resolve(self, record: Any, name: str) -> Any:
        if name not in record.of.fields:
            return None
        found = record.field(name)[1]
        return Held(found) if isinstance(found, types.BaseNamedTuple) else found


@lower_builtin(held, types.BaseNamedTuple)
def _lower(context: Any, builder: Any, signature: Any, args: Any) -> Any:
    """Write the tuple into memory, and return an address of which LLVM does not know that it was just written to."""
    place = builder.bitcast(cgutils.alloca_once_value(builder, args[0]), cgutils.voidptr_t)
    same = ir.FunctionType(cgutils.voidptr_t, [cgutils.voidptr_t])
    return builder.asm(same, "", "=r,0,~{memory}", [place], True)


@lower_getattr_generic(Held)
def _read(context: Any, builder: Any, record: Any, value: Any, name: str) -> Any:
    """Read a field, or return the address of one that is a tuple."""
    at, found = record.field(name)
    place = builder.bitcast(value, context.get_value_type(record.of).as_pointer())
    place = cgutils.gep_inbounds(builder, place, 0, at)
    if isinstance(found, types.BaseNamedTuple):
        return builder.bitcast(place, cgutils.voidptr_t)
    return _constant(builder, place, _OWNER if isinstance(found, types.Array) else 0)


def _constant(builder: Any, place: Any, begin: int = 0) -> Any:
    """Read a value that nothing changes, but for its first members, number by number; LLVM does not read them twice."""
    kind = place.type.pointee
    if not isinstance(kind, ir.Aggregate):
        value = builder.load(place)
        value.set_metadata("invariant.load", builder.module.add_metadata([]))
        return value
    value = ir.Constant(kind, None)
    for i in range(begin, len(kind)):
        value = builder.insert_value(value, _constant(builder, cgutils.gep_inbounds(builder, place, 0, i)), i)
    return value
