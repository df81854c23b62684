"""How functions are compiled: inner ones together with their caller, outer ones with a copy on the disk."""

from __future__ import annotations

import gc
import hashlib
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import cached_property
from pathlib import Path
from types import CodeType, FunctionType
from typing import Any, TypeVar

import llvmlite.binding as llvm
import numba
from numba import types
from numba.core.caching import FunctionCache
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler, Flags
from numba.core.dispatcher import Dispatcher
from numba.core.typed_passes import IRLegalization
from numba.core.untyped_passes import InlineClosureLikes

from squama.progress import LOG, not_kept


class _Part(JITCodeLibrary):
    """Code that only compiled code calls: optimised, and made machine code, in its outermost caller, not before."""

    def add_llvm_module(self, module: Any) -> None:
        """Add code after a few quick passes that remove most of Numba's redundancy; later passes run faster."""
        module.data_layout = self._codegen._data_layout
        passes = llvm.create_new_module_pass_manager()
        passes.add_sroa_pass()
        passes.add_instruction_combine_pass()
        passes.add_simplify_cfg_pass()
        passes.run(module, llvm.create_pass_builder(self._codegen._tm, llvm.create_pipeline_tuning_options(0)))
        self._final_module.link_in(module)

    def finalize(self) -> None:
        """Do nothing: the outermost caller links and optimises this code."""
        self._finalized = True

    def _get_module_for_linking(self) -> Any:
        """Return this code and all that it calls, each part once, after a caller of it."""
        parts: dict[Any, None] = {}
        self._gather(parts)
        own: Any = JITCodeLibrary._get_module_for_linking
        whole, *others = (own(part) for part in parts)
        whole = whole.clone()
        for other in others:
            whole.link_in(other, preserve=True)
        return whole

    def _gather(self, parts: dict[Any, None]) -> None:
        """Add this code, and then what it calls, to the keys of a dictionary."""
        parts[self] = None
        for called in self._linking_libraries:
            if called not in parts:
                called._gather(parts) if isinstance(called, _Part) else parts.setdefault(called)

    @property
    def codegen(self) -> Any:
        """Stand in for a code generator: there is no machine code yet whose environment could be set."""
        return self

    def set_env(self, *_: Any) -> None:
        """Ignore the environment: this code has none."""


class _Parts(Compiler):
    """Compiles functions into parts."""

    place: Any = _Part

    def define_pipelines(self) -> Any:
        """Return Numba's passes, with such a library, without those that would have nothing to do."""
        state = self.state
        state.library = self.place(state.targetctx.codegen(), state.func_id.func_qualname)
        # the first one says where references end
        idle: set[Any] = set() if state.flags.nrt else {IRLegalization}
        if not any(isinstance(c, CodeType) for c in state.func_id.code.co_consts):
            idle.add(InlineClosureLikes)
        passes: Any = super()
        pipelines = passes.define_pipelines()
        for pipeline in pipelines:
            pipeline.passes = [p for p in pipeline.passes if p[0] not in idle]
            pipeline._finalized = False
            pipeline.finalize()
        return pipelines


class _Flags(Flags):
    """Numba's flags with a quick comparison: they are compared often."""

    def __hash__(self) -> int:
        return hash(_Flags)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Flags) and self._known == other._known

    @cached_property
    def _known(self) -> tuple[Any, ...]:
        parent: Any = super()
        return tuple(parent.values().values())


def _by_types(fold: Callable[..., Any]) -> Callable[..., Any]:
    """Wrap the search for argument types: by type alone, else each constant would have a version of its own."""
    plain: Any = types.unliteral

    def folded(args: Any, kws: Any) -> Any:
        signature, found = fold(args, kws)
        return signature, tuple(plain(v) for v in found)

    return folded


def _at_once(compile_: Callable[..., Any]) -> Callable[..., Any]:
    """Wrap a compiler: no garbage collection while it works, there is little garbage."""

    def compiled(*args: Any) -> Any:
        collects = gc.isenabled()
        gc.disable()
        try:
            return compile_(*args)
        finally:
            if collects:
                gc.enable()

    return compiled


INNER: dict[str, Any] = {
    "pipeline_class": _Parts,
    "error_model": "numpy",
    "no_rewrites": True,
    "no_cpython_wrapper": True,
    "no_cfunc_wrapper": True,
}
"""Options of a function that only compiled code calls; 1/0 = inf, without a test."""
_F = TypeVar("_F", bound=Callable[..., Any])


def making(f: _F, **options: Any) -> _F:
    """Return a function compiled, to be called by compiled code only."""
    made: Any = numba.njit(**{**INNER, "_nrt": True, **options})(f)
    if isinstance(made, Dispatcher):
        compiler: Any = vars(made)["_compiler"]
        compiler.fold_argument_types, compiler._customize_flags = _by_types(compiler.fold_argument_types), _Flags
    found: _F = made
    return found


def part(f: _F, **options: Any) -> _F:
    """Return such a function, one that makes no array: nothing is counted that refers to those it is given.

    Counting takes longer than the work itself where it is done on parts of arrays.
    """
    return making(f, _nrt=False, **options)


def inlined(f: _F) -> _F:
    """Return such a function, whose code stands where it is called."""
    return part(f, forceinline=True)


class _Copy(FunctionCache):
    """The copy of compiled code on the disk; where it cannot be read or written, code is compiled in memory."""

    def __init__(self, f: FunctionType) -> None:
        parent: Any = super()
        parent.__init__(f)

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return the copy; None where there is none, or a damaged one, which is discarded."""
        parent: Any = super()
        try:
            return parent.load_overload(sig, target_context)
        except Exception:  # damaged bytes raise errors of many kinds
            with suppress(OSError):
                parent.flush()
            return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Write the copy; say in one line where and why it cannot be written."""
        parent: Any = super()
        try:
            parent.save_overload(sig, data)
        except (OSError, EOFError) as error:
            not_kept("compiled code", self.cache_path, error)


def kept(f: Callable[..., Any], sources: Sequence[Path], **options: Any) -> Any:
    """Return a function compiled; its copy on the disk is used as long as none of the sources changes.

    Numba itself looks at the file of this function only. Where no folder takes a copy, each process compiles anew.
    """
    assert isinstance(f, FunctionType)
    stamp = hashlib.sha256(b"".join(file.read_bytes() for file in sources)).hexdigest()
    # the files of the copy bear the digest: Numba fails on those of sources from which a module went
    f.__qualname__ = f"{f.__name__}_{stamp[:16]}"
    made: Any = numba.njit(error_model="numpy", nogil=True, **options)(f)
    if isinstance(made, Dispatcher):
        compiler: Any = vars(made)["_compiler"]
        compiler.compile = _at_once(compiler.compile)
    with suppress(RuntimeError):  # no place on the disk to keep compiled code
        made._cache = _Copy(f)
    return made


def is_ready(f: Any) -> bool:
    """Whether a compiled function is loaded, or likely to be found on the disk."""
    place = f.stats.cache_path
    return bool(f.signatures) or (place is not None and any(Path(place).glob(f"*{f.py_func.__qualname__}-*.nbc")))


_told: set[str] = set()


def tell(f: Any, what: str) -> None:
    """Log once that code will be compiled, if it will, and whether that recurs in each process."""
    if what in _told or is_ready(f):
        return
    _told.add(what)
    often = "once; some seconds"
    if f.stats.cache_path is None:
        often = "some seconds in each run: no folder for its cache can be written, NUMBA_CACHE_DIR sets one"
    LOG.warning("squama: compiling the code for %s, %s", what, often)
