"""Options of public functions by name: the signature lists each of them, and a wrong one gets the nearest."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import wraps
from inspect import Parameter, signature
from typing import ParamSpec, TypeVar

from .errors import UnknownName

P = ParamSpec("P")
R = TypeVar("R")


class UnknownOption(UnknownName, TypeError):
    """A keyword argument that a function does not have; the message has the nearest one."""


def named(*further: Callable[..., object] | Iterable[str]) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Return a decorator of a function: a keyword that it does not have raises `UnknownOption`.

    `further`: what the function passes on by its ``**options``: names, or the class or function whose parameters with a
    default they are. The signature lists them in place of ``**options``.

    >>> @named(["loss"])
    ... def cost(table, **options):
    ...     return options
    >>> cost(None, loss="huber"), str(signature(cost))
    ({'loss': 'huber'}, '(table, *, loss=None)')
    >>> cost(None, lost="huber")
    Traceback (most recent call last):
    ...
    tirefmu.boundary.named_options.UnknownOption: unknown option of cost() 'lost': did you mean loss?
    """

    def decorate(function: Callable[P, R]) -> Callable[P, R]:
        whole = signature(function)
        listed = [p for p in whole.parameters.values() if p.kind is not Parameter.VAR_KEYWORD]
        passed = [option for source in further for option in _options(source)]
        listed += [option for option in passed if option.name not in whole.parameters]
        given_by_name = [p.name for p in listed if p.kind is not Parameter.POSITIONAL_ONLY]
        shown = [name for name in given_by_name if listed[0].name != name]

        @wraps(function)
        def checked(*arguments: P.args, **options: P.kwargs) -> R:
            for name in options:
                if name not in given_by_name:
                    raise UnknownOption(f"option of {function.__name__}()", name, shown)
            return function(*arguments, **options)

        checked.__signature__ = whole.replace(parameters=listed)  # type: ignore[attr-defined]
        return checked

    return decorate


def _options(source: Callable[..., object] | Iterable[str]) -> list[Parameter]:
    """Return the options of a class or function, or those of given names, as keyword parameters."""
    if callable(source):
        parameters = signature(source).parameters.values()
        return [p.replace(kind=Parameter.KEYWORD_ONLY) for p in parameters if p.default is not Parameter.empty]
    return [Parameter(name, Parameter.KEYWORD_ONLY, default=None) for name in source]
