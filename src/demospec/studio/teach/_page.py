"""The page Teach: draw a path, accept or reject it, see what was understood."""

from __future__ import annotations

import asyncio
import time
from typing import Any

from demospec.errors import DemospecError
from demospec.studio.session._workspace import Workbench
from demospec.studio.teach._state import TeachState, Wanted
from demospec.studio.teach._view import TeachView

LOOK_S = 0.15
"""Nobody judges a path sooner; who does is not kept waiting by what was foreseen."""

PAUSE_S = 0.3
"""How long nothing more must happen until the next question is computed."""


def register(workbench: Workbench) -> None:
    """Registers the page at ``/teach``. State is per browser tab."""
    from nicegui import run, ui

    from demospec.studio.server._frame import page_frame

    @ui.page("/teach", title="Teach · demospec")
    def page() -> None:
        state = TeachState(workbench)
        view = TeachView(state)
        busy = {"on": False}

        async def refresh() -> None:
            """Shows what is known at once; what must be computed follows from a thread."""
            view.show()
            if busy["on"]:
                return  # the loop below sees that something changed
            busy["on"] = True
            try:
                while state.computed != state.wanted():
                    began = time.perf_counter()
                    await run.io_bound(state.understand)
                    view.show_understood(time.perf_counter() - began)
            finally:
                busy["on"] = False
            about = state.wanted()
            await asyncio.sleep(LOOK_S)
            if about == state.wanted():
                await run.io_bound(state.foresee)
            await advise(about)

        async def advise(about: Wanted) -> None:
            """The next question, unless something happens meanwhile: a verdict goes first."""
            await asyncio.sleep(PAUSE_S)
            if about != state.wanted() or about == state.advised:
                return
            await run.io_bound(state.ask)
            if about != state.wanted():
                return  # the steps follow what happened since
            await run.io_bound(state.look_ahead)
            if about == state.wanted():
                view.show_advice()
                view.show_steps()

        async def act(what: str, value: Any = None) -> None:
            """Does one thing that the person asked for; says in one line why it cannot."""
            try:
                state.do(what, value)
            except DemospecError as error:
                view.tell(str(error))
            view.remember()  # now: the tab may be loaded anew while something is computed
            await refresh()

        async def look_for_others() -> None:
            if workbench.version != state.shown_version:  # another tab, program or process
                await refresh()

        view.on_act = act
        with page_frame("Teach", "teach", script="teach.js"):
            view.build()
        for name in ("stroke", "key", "pick", "scene", "type", "hello"):
            event = f"teach_{name}"
            ui.on(event, lambda e, name=name: act(name, e.args))
        # The tab's greeting is answered with all there is to show.
        ui.timer(1.0, look_for_others, immediate=False)
