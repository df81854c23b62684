"""Compilation with Numba: inner functions together with their caller, outer ones cached on the disk."""

from __future__ import annotations

import gc
import hashlib
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from functools import cached_property
from pathlib import Path
from types import CodeType, FunctionType
from typing import Any, ParamSpec, Protocol, TypeVar, TypeVarTuple, cast

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

_P = ParamSpec("_P")
_R = TypeVar("_R")
_Ts = TypeVarTuple("_Ts")
_F = TypeVar("_F", bound=Callable[..., object])
_Fold = Callable[[Sequence[object], Mapping[str, object]], tuple[object, Sequence[object]]]


class _Pipeline(Protocol):
    """Numba's passes."""

    passes: list[tuple[type, str]]
    _finalized: bool

    def finalize(self) -> None: ...


class _Part(JITCodeLibrary):
    """Code called only by compiled code: optimised and turned into machine code in its outermost caller."""

    def add_llvm_module(self, module: llvm.ModuleRef) -> None:
        """Add code after a few quick passes that remove most of Numba's redundancy, so that later passes run faster."""
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

    def _get_module_for_linking(self) -> llvm.ModuleRef:
        """Return a module with this code and all code that it calls, each part once, callers first."""
        parts: dict[JITCodeLibrary, None] = {}
        self._gather(parts)
        own: Callable[[JITCodeLibrary], llvm.ModuleRef] = JITCodeLibrary._get_module_for_linking
        whole, *others = (own(part) for part in parts)
        whole = whole.clone()
        for other in others:
            whole.link_in(other, preserve=True)
        return whole

    def _gather(self, parts: dict[JITCodeLibrary, None]) -> None:
        """Add this code, and then all code that it calls, to the keys of a dictionary."""
        parts[self] = None
        for called in self._linking_libraries:
            if called not in parts:
                called._gather(parts) if isinstance(called, _Part) else parts.setdefault(called)

    @property
    def codegen(self) -> _Part:
        """Stand-in for a code generator: there is no machine code yet whose environment could be set."""
        return self

    def set_env(self, *_: object) -> None:
        """Ignore the environment: this code has none."""


class _Parts(Compiler):
    """Compiler that turns functions into a :class:`_Part`."""

    place: type[JITCodeLibrary] = _Part

    def define_pipelines(self) -> list[_Pipeline]:
        """Return Numba's passes with a :class:`_Part` as library, without passes that have nothing to do."""
        state = self.state
        state.library = self.place(state.targetctx.codegen(), state.func_id.func_qualname)
        # this pass marks the ends of references
        idle: set[type] = set() if state.flags.nrt else {IRLegalization}
        if not any(isinstance(c, CodeType) for c in state.func_id.code.co_consts):
            idle.add(InlineClosureLikes)
        define: Callable[[], list[_Pipeline]] = super().define_pipelines
        pipelines = define()
        for pipeline in pipelines:
            pipeline.passes = [p for p in pipeline.passes if p[0] not in idle]
            pipeline._finalized = False
            pipeline.finalize()
        return pipelines


class _Flags(Flags):
    """Numba's flags with a fast comparison, because they are compared often."""

    def __hash__(self) -> int:
        return hash(_Flags)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Flags) and self._known == other._known

    @cached_property
    def _known(self) -> tuple[object, ...]:
        values: Callable[[], Mapping[str, object]] = super().values
        return tuple(values().values())


def _by_types(fold: _Fold) -> _Fold:
    """Wrap the resolution of argument types so that constants count by type only, not as versions of their own."""
    plain: Callable[[object], object] = types.unliteral

    def folded(args: Sequence[object], kws: Mapping[str, object]) -> tuple[object, Sequence[object]]:
        signature, found = fold(args, kws)
        return signature, tuple(plain(v) for v in found)

    return folded


def _at_once(compile_: Callable[[*_Ts], _R]) -> Callable[[*_Ts], _R]:
    """Wrap a compiler to switch garbage collection off while it works: there is little garbage."""

    def compiled(*args: *_Ts) -> _R:
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
"""Numba options of functions called only by compiled code; 1/0 = inf, without a test."""


def making(f: _F, **options: bool | set[str]) -> _F:
    """Return a compiled function that only compiled code may call."""
    made = cast("_F", numba.njit(**{**INNER, "_nrt": True, **options})(f))
    if isinstance(made, Dispatcher):
        compiler = vars(made)["_compiler"]
        compiler.fold_argument_types, compiler._customize_flags = _by_types(compiler.fold_argument_types), _Flags
    return made


def part(f: _F, **options: bool | set[str]) -> _F:
    """Return a compiled function as :func:`making`, for one that makes no array, without reference counts.

    Counting references to parts of arrays takes longer than the work itself.
    """
    return making(f, _nrt=False, **options)


def inlined(f: _F) -> _F:
    """Return a compiled function as :func:`part`, inlined into its callers."""
    return part(f, forceinline=True)


class _Copy(FunctionCache):
    """Cache of compiled code on the disk; if it cannot be read or written, code is compiled in memory."""

    def __init__(self, f: FunctionType) -> None:
        start: Callable[[FunctionType], None] = super().__init__
        start(f)

    def load_overload(self, sig: object, target_context: object) -> object:
        """Return the cached code; None if there is none, or if it is damaged, which deletes it."""
        load: Callable[[object, object], object] = super().load_overload
        flush: Callable[[], None] = super().flush
        try:
            return load(sig, target_context)
        except Exception:  # damaged bytes raise errors of many kinds
            with suppress(OSError):
                flush()
            return None

    def save_overload(self, sig: object, data: object) -> None:
        """Write the code to the cache; log in one line if that fails."""
        save: Callable[[object, object], None] = super().save_overload
        try:
            save(sig, data)
        except (OSError, EOFError) as error:
            not_kept("compiled code", self.cache_path, error)


def kept(
    f: Callable[_P, _R], sources: Sequence[Path], fastmath: bool | set[str] = False
) -> Dispatcher[Callable[_P, _R]]:
    """Return a compiled function with a cache on the disk, valid as long as none of the ``sources`` changes.

    Numba itself checks only the file of this function. If no folder is writable, each process compiles anew.
    """
    assert isinstance(f, FunctionType)
    stamp = hashlib.sha256(b"".join(file.read_bytes() for file in sources)).hexdigest()
    # the files of the copy bear the digest: Numba fails on those of sources from which a module went
    f.__qualname__ = f"{f.__name__}_{stamp[:16]}"
    made = numba.njit(error_model="numpy", nogil=True, fastmath=fastmath)(f)
    if isinstance(made, Dispatcher):
        compiler = vars(made)["_compiler"]
        compiler.compile = _at_once(compiler.compile)
    with suppress(RuntimeError):  # no place on the disk to keep compiled code
        vars(made)["_cache"] = _Copy(f)
    return made


def is_ready(f: Dispatcher[Callable[..., object]]) -> bool:
    """Return whether a compiled function is loaded, or likely to be in the cache."""
    place = f.stats.cache_path
    return bool(f.signatures) or (place is not None and any(Path(place).glob(f"*{f.py_func.__qualname__}-*.nbc")))


_told: set[str] = set()


def tell(f: Dispatcher[Callable[..., object]], what: str) -> None:
    """Log once that the code for ``what`` will be compiled, if it will, and whether each process has to repeat that."""
    if what in _told or is_ready(f):
        return
    _told.add(what)
    often = "once; a minute or two"
    if f.stats.cache_path is None:
        often = "a minute or two in each run: no folder for its cache can be written, NUMBA_CACHE_DIR sets one"
    LOG.warning("squama: compiling the code for %s, %s", what, often)
