"""Glasshelm: explainable AI for ship collision avoidance."""

from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"
__all__ = ["__version__", "load"]

if TYPE_CHECKING:
    from glasshelm.pilots.registry import load


def __getattr__(name: str) -> Any:
    """``glasshelm.load`` on first use: importing the package imports no JAX."""
    if name == "load":
        from glasshelm.pilots.registry import load

        return load
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
