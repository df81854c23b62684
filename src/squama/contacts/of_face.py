"""Split of the compiled solver's output for scales on both faces: states and events of one face."""

from __future__ import annotations

import numpy as np

from squama.contacts import increments, touch
from squama.types import Array


def of_face(face: int, rows: Array, touches: Array) -> tuple[Array, Array]:
    """Return rows (n, m, 22 or more) and contacts (n, m, C, 16) of one of two faces: sums and slip, own contacts first.

    The scales on the two faces have even and odd numbers.
    """
    raw, own = rows.copy(), np.zeros_like(touches)
    there = np.arange(touches.shape[2]) < np.nan_to_num(np.real(raw[:, :, 12, None]))
    there &= np.real(touches[..., touch.FIRST]) % 2 == face
    order = np.argsort(~there, axis=2, kind="stable")
    kept = np.take_along_axis(there, order, axis=2)
    own[kept] = np.take_along_axis(touches, order[..., None], axis=2)[kept]
    reached = np.isfinite(np.real(raw[:, :, 0]))
    raw[reached, 12] = there.sum(axis=2)[reached]
    for at, told in ((14, 13), (15, 14)):
        raw[reached, at] = np.where(kept, own[..., told], 0.0).sum(axis=2)[reached]
    if face:
        raw[..., 16] = raw[..., 21]
    return raw, own


def events_of(face: int, events: Array, ends: Array) -> tuple[Array, Array]:
    """Return the events of one of two faces, and the ends with the number of these.

    A jump of the scales belongs to the face whose contacts it changes, if it changes any.
    """
    out, last = np.zeros_like(events), ends.copy()
    codes = np.real(events[:, :, increments.AFTER :])
    own = np.where((codes >= 0) & (codes // increments.SCALE == face), codes, -1.0)
    for i, count in enumerate(np.minimum(ends[:, 2], events.shape[1]).astype(int)):
        n, before, all_before = 0, {-1.0}, {-1.0}
        for row, after, every in zip(events[i, :count], own[i], codes[i], strict=False):
            now, all_now = {-1.0, *after.tolist()}, {-1.0, *every.tolist()}
            jumps = int(np.real(row[0])) in (increments.SNAP, increments.CHANGE) and all_now != all_before
            if now != before if jumps else np.real(row[6 + touch.FIRST]) == face:
                out[i, n] = row
                out[i, n, 13], out[i, n, increments.AFTER :] = (after >= 0).sum(), after
                n += 1
            before, all_before = now, all_now
        last[i, 2] = n
    return out, last
