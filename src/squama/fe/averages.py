"""Sections held on average: conditions on mean place and turns of their nodes, with two derivatives."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from squama.fe.mesh import Index
from squama.fe.periodic import Course, Moves, Twist
from squama.types import Array


class Section:
    """Mean place and mean turns of a section, held by multipliers in a frame that follows the loads.

    ``nodes`` (k,): numbers among the masters; ``arms`` (k, 3): places in the frame; ``weights`` (k,): shares of the
    section's area; ``frame``: by the loads, one :class:`squama.fe.periodic.Moves` or one for each node; ``turns`` (c,
    k, 3): directions in the frame along each of which the mean displacement, weighted by the shares, is 0, too.
    """

    def __init__(
        self, nodes: Index, arms: Array, weights: Array, frame: Callable[[Array], Moves], turns: Array
    ) -> None:
        self.nodes, self._arms, self.weights = nodes, arms, weights / weights.sum()
        self._frame = frame
        self._across = turns / (self.weights @ (turns**2).sum(axis=-1).T)[:, None, None]
        self.conditions = 3 + len(turns)
        # derivatives of x, y, z and the turns by the places: rows, and columns 3 k + axis
        k = 3 * np.arange(self.nodes.size)
        self.rows = np.repeat([0, 1, 2, *np.repeat(np.arange(3, self.conditions), 3)], k.size)
        self.columns = np.concatenate([k, k + 1, k + 2] * (1 + len(turns)))

    @classmethod
    def of_pitch(cls, nodes: Index, places: Array, weights: Array, course: Course | None = None) -> Section:
        """Return the cut of an endless beam at rest: nodes with places (k, 3) follow the course at their height."""
        nodes, places, weights = (given[weights != 0] for given in (nodes, places, weights))
        flat, led = places * [1.0, 1.0, 0.0], course or Twist()
        turns = np.cross(flat, np.array([[[0.0, 0.0, 1.0]]]))
        return cls(nodes, flat, weights, lambda loads: led.moves(loads, places[:, 2]), turns)

    def means(self, y: Array, loads: Array) -> tuple[Array, Array, Array, Array, Array]:
        """Return the means, with derivatives by the places of the nodes and two derivatives by the L loads.

        The means (c,) at places y (k, 3) are 0 where the section is held; their derivatives by the loads are (c, L) and
        (c, L, L). Derivatives by places are in the order of ``rows``; their rates with the loads are (.., L).
        """
        moves, w = self._frame(loads), self.weights
        frames, c = moves.of(self._arms), self.conditions
        # shifts from the frame, and turns across it
        off, L = y - frames[0], loads.size
        entries, rates = np.zeros((c, 3, w.size)), np.zeros((c, 3, w.size, L))
        entries[[0, 1, 2], [0, 1, 2]] = w
        means, by, second = np.zeros(c), np.zeros((c, L)), np.zeros((c, L, L))
        means[:3], by[:3], second[:3] = (
            w @ off,
            -np.tensordot(frames[1], w, (0, 0)).T,
            -np.tensordot(frames[2], w, (0, 0)).T,
        )
        for i, across in enumerate(self._across, start=3):
            a, da, dda = moves.turned(across)
            entries[i], rates[i] = (w[:, None] * a).T, np.einsum("k,kli->ikl", w, da)
            means[i] = w @ (off * a).sum(axis=1)
            by[i] = np.einsum("k,ki,kli->l", w, off, da) - np.einsum("k,kli,ki->l", w, frames[1], a)
            mixed = np.einsum("k,kli,kmi->lm", w, frames[1], da)
            second[i] = np.einsum("k,ki,klmi->lm", w, off, dda) - np.einsum("k,klmi,ki->lm", w, frames[2], a)
            second[i] -= mixed + mixed.T
        # the shifts along one axis each, the turns along all
        own = np.concatenate([[0, 4, 8], np.arange(9, 3 * c)])
        return (
            entries.reshape(3 * c, -1)[own].ravel(),
            rates.reshape(3 * c, -1, L)[own].reshape(-1, L),
            means,
            by,
            second,
        )
