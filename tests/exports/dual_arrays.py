"""A stand-in for JAX: its names used by a printout, for NumPy arrays and for dual numbers of arrays.

As in reverse differentiation, the derivative of a choice is that of both branches times 1 and 0: a derivative of the
branch that is not taken has to be finite.
"""

from __future__ import annotations

import operator
import sys
from types import ModuleType, SimpleNamespace

import numpy as np


class Dual:
    """A value x with a slope d, both arrays or dual numbers."""

    __array_ufunc__ = None

    def __init__(self, x, d):
        self.x, self.d = x, d

    dtype = property(lambda self: self.x.dtype)

    def __neg__(self):
        return Dual(-self.x, -self.d)

    def __add__(self, other):
        other = dual(other)
        return Dual(self.x + other.x, self.d + other.d)

    def __mul__(self, other):
        other = dual(other)
        return Dual(self.x * other.x, self.d * other.x + self.x * other.d)

    def __truediv__(self, other):
        other = dual(other)
        quotient = self.x / other.x
        return Dual(quotient, (self.d - quotient * other.d) / other.x)

    def __pow__(self, power):
        return Dual(self.x**power, power * self.x ** (power - 1) * self.d)

    __radd__, __rmul__ = __add__, __mul__

    def __sub__(self, other):
        return self + -other

    def __rsub__(self, other):
        return -self + other

    def __rtruediv__(self, other):
        return dual(other) / self


def _compared(relation):
    return lambda a, b: relation(value(a), value(b))


for _name in ("lt", "le", "gt", "ge", "eq"):
    setattr(Dual, f"__{_name}__", _compared(getattr(operator, _name)))


def dual(x):
    """Return a number as a dual number."""
    return x if isinstance(x, Dual) else Dual(x, 0.0)


def value(x):
    """Return the innermost value of a number."""
    return value(x.x) if isinstance(x, Dual) else x


def _function(name, slope):
    def call(x):
        return Dual(call(x.x), slope(x.x) * x.d) if isinstance(x, Dual) else getattr(np, name)(x)

    return call


def where(condition, then, otherwise):
    """Return a choice whose slope reads both branches."""
    if not isinstance(then, Dual) and not isinstance(otherwise, Dual):
        return np.where(condition, then, otherwise)
    then, otherwise = dual(then), dual(otherwise)
    return Dual(where(condition, then.x, otherwise.x), then.d * condition + otherwise.d * ~np.asarray(condition))


sin = _function("sin", lambda x: cos(x))
cos = _function("cos", lambda x: -sin(x))
sqrt = _function("sqrt", lambda x: 0.5 / sqrt(x))
exp = _function("exp", lambda x: exp(x))
JNP = SimpleNamespace(
    sin=sin, cos=cos, sqrt=sqrt, exp=exp, where=where, float64=np.dtype(np.float64), pi=np.pi,
    tan=_function("tan", lambda x: 1.0 / cos(x) ** 2),
    arctan=_function("arctan", lambda x: 1.0 / (1.0 + x**2)),
    arccos=_function("arccos", lambda x: -1.0 / sqrt(1.0 - x**2)),
    log=_function("log", lambda x: 1.0 / x),
    expm1=_function("expm1", lambda x: exp(x)),
    sign=_function("sign", lambda x: 0.0),
)  # fmt: skip
JNP.atan, JNP.acos = JNP.arctan, JNP.arccos


class _Plain:
    """A function without its own derivative."""

    def __init__(self, function):
        self.defjvp = lambda rule: rule


def module_from(text, monkeypatch):
    """Return the names of a JAX printout that runs with this module in place of JAX."""
    jax = ModuleType("jax")
    jax.numpy, jax.custom_jvp = JNP, _Plain
    monkeypatch.setitem(sys.modules, "jax", jax)
    monkeypatch.setitem(sys.modules, "jax.numpy", JNP)
    names = {}
    exec(compile(text, "printout", "exec"), names)
    return SimpleNamespace(**names)
