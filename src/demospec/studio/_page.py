"""The studio's page: the scenes of a set, large, with the demonstrations drawn over them."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from demospec.demonstrations import Demonstration, DemonstrationSet
from demospec.studio._scene_svg import scene_svg

STATIC = Path(__file__).parent / "static"
EVERYONE = "all types"


def build_page(data: DemonstrationSet) -> None:
    """Registers the page at ``/``. State is per browser tab."""
    from nicegui import app, ui

    app.add_static_files("/studio-static", STATIC)
    by_scene = data.rows_by_scene()

    @ui.page("/", title=f"demospec: {data.name}")
    def page() -> None:
        ui.add_head_html('<link rel="stylesheet" href="/studio-static/studio.css">')
        ui.dark_mode(None)
        state: dict[str, Any] = {"scene": data.scenes[0].scene_id, "type": EVERYONE}
        stage: Any = None
        counts: Any = None
        buttons: dict[str, Any] = {}

        def chosen() -> list[Demonstration]:
            rows = by_scene.get(state["scene"], np.empty(0, dtype=int))
            every = [data.demonstrations[int(i)] for i in rows]
            return [d for d in every if state["type"] in (EVERYONE, d.type)]

        def show() -> None:
            some = chosen()
            stage.set_content(scene_svg(data.scene(state["scene"]), some))
            counts.set_content(counts_html(some))
            for name, button in buttons.items():
                button.classes(
                    add="chosen" if name == state["scene"] else "",
                    remove="" if name == state["scene"] else "chosen",
                )

        def choose(name: str) -> None:
            state["scene"] = name
            show()

        def choose_type(event: Any) -> None:
            state["type"] = event.value
            show()

        with ui.element("main").classes("studio"):
            with ui.element("nav").props('aria-label="Scenes"'):
                ui.html(
                    f"<h1>{escape(data.name)}</h1><p class='soft'>{len(data.scenes)} scenes, "
                    f"{len(data.demonstrations)} demonstrations</p>",
                    sanitize=False,
                )
                with ui.element("div").classes("scenes"):
                    for scene in data.scenes[:200]:
                        with ui.element("button").on(
                            "click", lambda _, name=scene.scene_id: choose(name)
                        ) as button:
                            ui.html(scene_svg(scene) + escape(scene.scene_id), sanitize=False)
                        buttons[scene.scene_id] = button
            with ui.element("section").classes("stage").props('aria-label="Scene"'):
                stage = ui.html("", sanitize=False)
            with ui.element("aside").classes("panel"):
                ui.html("<h2>Whose demonstrations</h2>", sanitize=False)
                ui.radio([EVERYONE, *data.types], value=EVERYONE, on_change=choose_type)
                counts = ui.html("", sanitize=False)
        show()


def counts_html(demonstrations: Sequence[Demonstration]) -> str:
    """A legend with counts."""
    names = {True: "accepted", False: "rejected", None: "unsaid"}
    words = {"accepted": "accepted", "rejected": "rejected", "unsaid": "nobody said"}
    rows = []
    for verdict, name in names.items():
        count = sum(d.valid is verdict for d in demonstrations)
        rows.append(
            f"<tr><td><span class='key {name}'></span>{words[name]}</td><td>{count}</td></tr>"
        )
    return (
        "<h2 style='margin-top:1.2rem'>In this scene</h2>"
        f"<table class='counts'><tbody>{''.join(rows)}</tbody></table>"
        "<p class='soft' style='margin-top:.8rem'>Point at a path or an object to see its name.</p>"
    )
