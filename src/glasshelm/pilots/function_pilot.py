"""Any function from observation to rudder as a pilot: ten lines of somebody else's code.

``package.module:function`` takes an :class:`Observation` and returns the rudder
as a fraction of the limit. A function that JAX can trace is compiled with the
environment; any other (numpy, another library) is called back for each observation.
"""

import hashlib
import importlib
import inspect
import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from glasshelm.core.errors import InputError
from glasshelm.env.observe import Observation, empty_observation
from glasshelm.pilots.protocols import Decision, Memory, Pilot

#: What JAX raises when a function looks at the values of what it traces.
_UNTRACEABLE = (
    jax.errors.TracerArrayConversionError,
    jax.errors.TracerIntegerConversionError,
    jax.errors.ConcretizationTypeError,
)


class FunctionPilot(eqx.Module):
    """Steers by a function without memory. ``source_sha256`` is that of the function's file."""

    function: Callable[[Observation], Any] = eqx.field(static=True)
    name: str = eqx.field(static=True)
    traced: bool = eqx.field(static=True)
    source_sha256: str | None = eqx.field(static=True, default=None)

    def start(self) -> Memory:
        return ()

    def decide(self, observation: Observation, memory: Memory) -> tuple[Decision, Memory]:
        if self.traced:
            rudder = jnp.asarray(self.function(observation), jnp.float32).reshape(())
            return Decision(rudder), memory
        shape = jax.ShapeDtypeStruct((), jnp.float32)
        rudder = jax.pure_callback(self._called, shape, observation, vmap_method="sequential")
        return Decision(rudder), memory

    def _called(self, observation: Observation) -> np.ndarray:
        plain = jax.tree.map(np.asarray, observation)
        return np.asarray(self.function(plain), np.float32).reshape(())


def function_pilot(name: str) -> Pilot:
    """The pilot called ``package.module:function``; an object that is a pilot is taken as it is.

    The module is imported, and so its code is run; the current folder is searched as well.
    Only who starts a command may name one: never a log, a file or a viewer of the page.
    InputError, in one line, if there is no such thing, or if it gives no rudder for an
    observation.
    """
    module_name, _, attribute = name.partition(":")
    if not module_name or not attribute:
        raise InputError(f"pilot {name!r}: write package.module:function")
    here = os.getcwd()
    if here not in sys.path:
        sys.path.insert(0, here)
    try:
        found = getattr(importlib.import_module(module_name), attribute)
    except ImportError as error:
        raise InputError(f"pilot {name!r}: cannot import {module_name} ({error})") from None
    except AttributeError:
        raise InputError(f"pilot {name!r}: {module_name} has no {attribute}") from None
    except Exception as error:  # it is somebody's code, and may fail as it likes
        raise InputError(f"pilot {name!r}: importing {module_name} fails ({error!r})") from None
    if isinstance(found, Pilot):
        return _checked(name, found)
    if not callable(found):
        lacks = [part for part in ("name", "start", "decide") if not hasattr(found, part)]
        raise InputError(
            f"pilot {name!r}: neither a function nor a pilot, which has {', '.join(lacks)} too"
        )
    return FunctionPilot(found, name, _traceable(name, found), _digest(found))


def _checked(name: str, pilot: Pilot) -> Pilot:
    """The pilot; tried on two ships. InputError if it gives no decision."""
    try:
        memory = jax.eval_shape(pilot.start)
        decided = jax.eval_shape(pilot.decide, empty_observation(2), memory)
    except Exception as error:  # it is somebody's code, and may fail as it likes
        raise InputError(f"pilot {name!r}: fails on an observation ({error!r})") from None
    if not (isinstance(decided, tuple) and len(decided) == 2 and isinstance(decided[0], Decision)):
        raise InputError(f"pilot {name!r}: decide must return (Decision(rudder), memory)")
    if np.shape(decided[0].rudder) != ():
        raise InputError(f"pilot {name!r}: the rudder must be one number in [-1, 1]")
    return pilot


def _traceable(name: str, function: Callable[[Observation], Any]) -> bool:
    """Whether JAX can trace it; tried on two ships. InputError if it gives no number at all."""
    example = empty_observation(2)
    try:
        out = jax.eval_shape(
            lambda observation: jnp.asarray(function(observation), jnp.float32), example
        )
        size = out.size
        traced = True
    except _UNTRACEABLE:
        traced = False
        try:
            size = np.asarray(function(jax.tree.map(np.asarray, example)), np.float32).size
        except Exception as error:
            raise InputError(f"pilot {name!r}: fails on an observation ({error!r})") from None
    except Exception as error:
        raise InputError(f"pilot {name!r}: fails on an observation ({error!r})") from None
    if size != 1:
        raise InputError(f"pilot {name!r}: must return one number in [-1, 1], not {size}")
    return traced


def _digest(function: Callable[..., Any]) -> str | None:
    try:
        file = inspect.getsourcefile(function)
    except TypeError:
        return None
    return None if file is None else hashlib.sha256(Path(file).read_bytes()).hexdigest()
