"""JSON schema of a message in the plain form that plotting tools read: types, properties, items.

msgspec's own schemas use `$ref`, `anyOf` and `prefixItems`, which those tools do not read.
"""

from __future__ import annotations

from typing import Any

import msgspec
import msgspec.inspect as mi

_PLAIN: dict[type[mi.Type], str] = {
    mi.BoolType: "boolean",
    mi.IntType: "integer",
    mi.FloatType: "number",
    mi.StrType: "string",
}


def object_schema(kind: type[msgspec.Struct], without: frozenset[str] = frozenset()) -> dict[str, Any]:
    """Schema of a struct as a JSON object.

    An optional value has the schema of the value alone: viewers take one type per field, and show a null as
    no value.

    Args:
        kind: the struct; its fields are numbers, strings, booleans, structs, and tuples of one of these.
        without: names of fields that are left out.
    """
    info = mi.type_info(kind)
    assert isinstance(info, mi.StructType)
    fields = [field for field in info.fields if field.name not in without]
    return {
        "title": kind.__name__,
        "type": "object",
        "properties": {field.encode_name: _schema(field.type) for field in fields},
        "required": [field.encode_name for field in fields],
    }


def _schema(info: mi.Type) -> dict[str, Any]:
    if isinstance(info, mi.StructType):
        return object_schema(info.cls)
    if isinstance(info, mi.UnionType):
        (value,) = (t for t in info.types if not isinstance(t, mi.NoneType))
        return _schema(value)
    if isinstance(info, mi.TupleType):
        n, item = len(info.item_types), _schema(info.item_types[0])
        if any(_schema(t) != item for t in info.item_types):
            raise TypeError(f"{info} mixes types; one type per array is expected")
        return {"type": "array", "items": item, "minItems": n, "maxItems": n}
    if isinstance(info, mi.VarTupleType):
        bounds = {"minItems": info.min_length, "maxItems": info.max_length}
        return {"type": "array", "items": _schema(info.item_type)} | {
            key: bound for key, bound in bounds.items() if bound is not None
        }
    try:
        return {"type": _PLAIN[type(info)]}
    except KeyError:
        raise TypeError(f"{info} has no plain JSON schema") from None
