"""Watching a simulation: 3-D clearances to every object, and contacts."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from demospec.execution._results import Contact

if TYPE_CHECKING:
    import mujoco

_FAR_M = 2.0


class Monitor:
    """Smallest distance of the moving geoms to each object, and every contact of theirs.

    Args:
        model: Bodies named ``object/ID`` are the objects; body ``table`` is the table.
        moving: Ids of the geoms that the robot moves.
    """

    def __init__(self, model: mujoco.MjModel, moving: list[int]) -> None:
        import mujoco

        self.model = model
        self.moving = moving
        self.objects: dict[str, list[int]] = {}
        for geom in range(model.ngeom):
            name = mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_BODY, int(model.geom_bodyid[geom]))
            if name and name.startswith("object/"):
                self.objects.setdefault(name.removeprefix("object/"), []).append(geom)
        self.clearance_m = dict.fromkeys(self.objects, np.inf)
        self._contacts: dict[tuple[str, str], Contact] = {}

    def clearances(self, data: mujoco.MjData) -> None:
        """Updates the smallest distances; call it a few times per centimetre."""
        import mujoco

        ends = np.zeros(6)
        for name, geoms in self.objects.items():
            for geom in geoms:
                for mover in self.moving:
                    # Skip pairs whose bounding balls are further apart than the best so far.
                    apart = float(np.linalg.norm(data.geom_xpos[geom] - data.geom_xpos[mover]))
                    reach = float(self.model.geom_rbound[geom] + self.model.geom_rbound[mover])
                    least = min(self.clearance_m[name], _FAR_M)
                    if apart - reach < least:
                        gap = mujoco.mj_geomDistance(self.model, data, mover, geom, least, ends)
                        self.clearance_m[name] = min(self.clearance_m[name], float(gap))

    def contacts(self, data: mujoco.MjData) -> None:
        """Notes every touching pair that involves something moved; call it at every step."""
        if data.ncon == 0:
            return
        moving = set(self.moving)
        for i in range(data.ncon):
            touch = data.contact[i]
            if touch.dist >= 0 or not ({int(touch.geom1), int(touch.geom2)} & moving):
                continue
            pair = sorted((self._name(int(touch.geom1)), self._name(int(touch.geom2))))
            old = self._contacts.get((pair[0], pair[1]))
            since = float(data.time) if old is None else old.t
            depth = max(-float(touch.dist), 0.0 if old is None else old.depth_m)
            self._contacts[pair[0], pair[1]] = Contact(pair[0], pair[1], since, depth)

    @property
    def found(self) -> tuple[Contact, ...]:
        """All contacts, earliest first."""
        return tuple(sorted(self._contacts.values(), key=lambda c: c.t))

    def _name(self, geom: int) -> str:
        import mujoco

        body = int(self.model.geom_bodyid[geom])
        return mujoco.mj_id2name(self.model, mujoco.mjtObj.mjOBJ_BODY, body) or f"geom {geom}"
