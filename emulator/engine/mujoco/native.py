"""MuJoCo's C library for machine code: its functions, and where its structures keep their fields.

The places of fields follow from MuJoCo's own description of its headers (`mujoco.introspect`) by the rules of
C, so that they are those of the version that is installed.
"""

from __future__ import annotations

import ctypes
from pathlib import Path
from typing import Any, Final, TypeAlias

import llvmlite.binding
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from emulator.engine.mujoco.client import ast_nodes, mujoco, structs

Layout: TypeAlias = tuple[int, int, int, int, int, int, int, int]
_SCALARS: Final = {
    "int": ctypes.c_int,
    "mjtNum": ctypes.c_double,
    "mjtSize": ctypes.c_int64,
    "mjtBool": ctypes.c_bool,
    "size_t": ctypes.c_size_t,
    "uintptr_t": ctypes.c_size_t,
    "uint64_t": ctypes.c_uint64,
}


def _load_library() -> None:
    """Let machine code call the library that the Python package has loaded."""
    (library,) = Path(mujoco.__file__).parent.glob("libmujoco*")
    llvmlite.binding.load_library_permanently(str(library))


_load_library()
_address = types.intp
mj_step: Final = types.ExternalFunction("mj_step", types.void(_address, _address))
"""One time step of a model with a state, both given as addresses."""
mj_kinematics: Final = types.ExternalFunction("mj_kinematics", types.void(_address, _address))
"""Poses of bodies and geoms, likewise."""
mj_com_pos: Final = types.ExternalFunction("mj_comPos", types.void(_address, _address))
"""Places of centres of mass, likewise."""
mj_ray: Final = types.ExternalFunction(
    "mj_ray",
    types.float64(
        _address, _address, _address, _address, _address, types.int32, types.int32, _address, _address
    ),
)
"""Distance of the nearest geom on a ray in lengths of the ray, -1 without one: of model, state, start, way,
groups of geoms that count, whether fixed geoms do, body that does not, places for the geom and the normal."""


def structure(name: str) -> Any:
    """A structure of MuJoCo as a type of `ctypes`, whose fields have an `offset` in bytes."""
    fields = [(field.name, _field_type(field.type)) for field in structs.STRUCTS[name].fields]
    return type(name, (ctypes.Structure,), {"_fields_": fields})


def _field_type(declared: Any) -> Any:
    if isinstance(declared, ast_nodes.PointerType):
        return ctypes.c_void_p
    if isinstance(declared, ast_nodes.ArrayType):
        element = _field_type(declared.inner_type)
        for extent in reversed(declared.extents):
            element = element * extent
        return element
    return _SCALARS.get(declared.name) or structure(declared.name)


def _layout() -> Layout:
    data, contact = structure("mjData"), structure("mjContact")
    return (
        *(getattr(data, name).offset for name in ("ncon", "contact", "efc_force")),
        ctypes.sizeof(contact),
        *(getattr(contact, name).offset for name in ("geom", "pos", "frame", "efc_address")),
    )


LAYOUT: Final = _layout()
"""In bytes: places of `ncon`, `contact` and `efc_force` in `mjData`; size of `mjContact`, places of `geom`,
`pos`, `frame` and `efc_address` in it."""


@intrinsic  # type: ignore[untyped-decorator]
def pointer(context: Any, address: Any) -> Any:
    """In machine code: an address as a pointer that `numba.carray` takes."""

    def generate(_: Any, builder: Any, __: Any, arguments: Any) -> Any:
        return builder.inttoptr(arguments[0], cgutils.voidptr_t)

    return types.voidptr(address), generate
