"""Named tuples passed to compiled code by address, instead of their hundred numbers one by one.

Numba turns each number in a tuple into an argument, each array into five or more, so that functions of large tuples
take long to compile. ``held(t)`` is the same tuple in the memory of the function that calls ``held``. It is read-only
there: other functions read the fields that they need. Tuples in the tuple become records too. Without Numba's compiler,
and for type checkers, ``held(t)`` is the tuple itself.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from types import ModuleType
from typing import Any, TypeVar

from llvmlite import ir
from numba import extending as numba_extending
from numba import types
from numba.core import base, imputils
from numba.core import cgutils as numba_cgutils
from numba.core.typing.context import BaseContext
from numba.core.typing.templates import AttributeTemplate, Signature

_T = TypeVar("_T")
extending: ModuleType = numba_extending
cgutils: ModuleType = numba_cgutils
borrowed: Callable[[base.BaseContext, ir.IRBuilder, types.Type, ir.Value], ir.Value] = imputils.impl_ret_borrowed
_ADDRESS = cgutils.voidptr_t


def held(record: _T) -> _T:
    """Return a named tuple as a record, which exists until the function that calls ``held`` returns.

    The tuple must live as long: it has to be an argument of that function.
    """
    return record


class Held(types.Type):
    """Numba type of a record; ``of`` is the type of its named tuple."""

    def __init__(self, of: Any) -> None:
        self.of = of
        digest = hashlib.sha256(of.name.encode()).hexdigest()[:16]
        super().__init__(f"{of.instance_class.__name__}_{digest}")


def _typed(_: BaseContext) -> Callable[[types.Type], Held | None]:
    return lambda record: Held(record) if isinstance(record, types.BaseNamedTuple) else None


def _hold(_: base.BaseContext, builder: ir.IRBuilder, __: Signature, args: Sequence[ir.Value]) -> ir.Value:
    """Write the tuple into memory; return its address, hidden from LLVM's knowledge of the values just written."""
    place = builder.bitcast(cgutils.alloca_once_value(builder, args[0]), _ADDRESS)
    same = ir.FunctionType(_ADDRESS, [_ADDRESS])
    return builder.asm(same, "", "=r,0,~{memory}", [place], True)


@extending.infer_getattr
class _Fields(AttributeTemplate):
    """Types of a record's fields, for Numba's type inference."""

    key = Held

    def resolve_field(self, record: Held, name: str) -> types.Type | None:
        """Return the type of a field."""
        if name not in record.of.fields:
            return None
        found = record.of.types[record.of.fields.index(name)]
        return Held(found) if isinstance(found, types.BaseNamedTuple) else found

    generic_resolve: Any = resolve_field


def _read(context: Any, builder: ir.IRBuilder, record: Held, value: ir.Value, name: str) -> ir.Value:
    """Return the value of a field, or the address of a field that is a tuple."""
    at = record.of.fields.index(name)
    whole = builder.bitcast(value, context.get_value_type(record.of).as_pointer())
    place, found = cgutils.gep_inbounds(builder, whole, 0, at), record.of.types[at]
    if isinstance(found, types.BaseNamedTuple):
        return builder.bitcast(place, _ADDRESS)
    read = builder.load(place)
    read.set_metadata("tbaa", _constant(builder.module))
    return borrowed(context, builder, found, read)


def _constant(module: ir.Module) -> ir.MDValue:
    """Return metadata that tells LLVM the values never change, so that they are read once."""
    none, yes = ir.IntType(64)(0), ir.IntType(64)(1)
    kind = module.add_metadata(["record", module.add_metadata(["squama"]), none])
    return module.add_metadata([kind, kind, none, yes])


extending.register_model(Held)(extending.models.OpaqueModel)
extending.type_callable(held)(_typed)
extending.lower_builtin(held, types.BaseNamedTuple)(_hold)
extending.lower_getattr_generic(Held)(_read)
