"""Files of a store that follow from its plan: metadata of arrays, and coordinates, as zarr writes them."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from squama.needs import need
from squama.study.plan import CHECKSUMS, STATUS, Plan, arrays, attributes, coordinates

if TYPE_CHECKING:
    from zarr.core.buffer import Buffer


def fill(place: object, plan: Plan) -> None:
    """Write an empty store of a plan to a folder or to a zarr store."""
    library = need("zarr")
    group = library.create_group(place, zarr_format=3, attributes=attributes(plan))
    for name, about in arrays(plan).items():
        # marks and checksums stay uncompressed: the same bytes with every codec version
        plain = name in {STATUS, CHECKSUMS}
        codecs = [*([] if plain else [library.codecs.ZstdCodec(level=1)]), library.codecs.Crc32cCodec()]
        how = {"chunk_key_encoding": {"name": "default", "separator": "."}, "config": {"write_empty_chunks": True}}
        group.create_array(name=name, compressors=codecs, **how, **about)
    for name, (values, _) in coordinates(plan).items():
        group[name][:] = values


def following(plan: Plan) -> dict[str, bytes]:
    """Return the contents of all files that follow from the plan, by place; without the group's own metadata."""
    made: dict[str, Buffer] = {}
    fill(need("zarr").storage.MemoryStore(store_dict=made), plan)
    return {name: data.to_bytes() for name, data in made.items() if "/" in name}


def alike(found: Mapping[str, bytes], plan: Plan, name: str) -> bool:
    """Say whether the stored files of an array mean the same as the plan, though another version of zarr wrote them."""
    library = need("zarr")
    made = library.storage.MemoryStore()
    fill(made, plan)
    buffer = library.core.buffer.default_buffer_prototype().buffer
    read = library.storage.MemoryStore(store_dict={place: buffer.from_bytes(data) for place, data in found.items()})
    array = library.open_array(read, path=name, mode="r", zarr_format=3)
    wanted = library.open_group(made, mode="r")[name]
    same = json.dumps(array.metadata.to_dict()) == json.dumps(wanted.metadata.to_dict())
    return same and (name not in coordinates(plan) or np.array_equal(array[:], coordinates(plan)[name][0]))
