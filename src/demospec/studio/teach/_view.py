"""The elements of the Teach page, and how they show a tab's state."""

from __future__ import annotations

import json
from collections.abc import Callable, Coroutine
from html import escape
from typing import Any
from urllib.parse import quote

from demospec.studio.drawing._contours import rings_svg
from demospec.studio.drawing._scene_svg import (
    ends_svg,
    marks_svg,
    paths_svg,
    scene_svg,
    short_name,
    view_box,
)
from demospec.studio.teach._state import NEXT_AFTER, TeachState
from demospec.studio.teach._summary import culprits
from demospec.studio.teach._text import (
    conflict_words,
    culprit_words,
    rows_html,
    understood_html,
)

MOST_ROWS = 60
"""Paths listed for one scene; more are counted."""

Act = Callable[..., Coroutine[Any, Any, None]]


class TeachView:
    """Builds the elements once; the ``show`` functions fill them.

    Args:
        state: The tab's.
    """

    def __init__(self, state: TeachState) -> None:
        self.state = state
        self.on_act: Act
        self._shown_scene: tuple[Any, ...] | None = None
        self._shown_types: tuple[tuple[str, ...], str] | None = None

    def build(self) -> None:
        """Builds the page inside the current element."""
        from nicegui import ui

        with ui.element("div").classes("teach"):
            with ui.element("section").classes("teach-stage").props('aria-label="Scene"'):
                self._build_scene_bar()
                # The script finds the scene's geometry in `data-scene`.
                self.stage = ui.element("div").props("id=stage").classes("stage")
                with self.stage:
                    self.picture = ui.html("", sanitize=False)
                    self.marks = ui.html("", sanitize=False).classes("marks")
                    self.pen = ui.html("", sanitize=False).classes("marks")
                ui.html("", sanitize=False).props('id=hint role="status"').classes("hint soft")
                self._build_actions()
            with ui.element("aside").classes("teach-side").props('aria-label="Understanding"'):
                self._build_objects()
                self._build_understood()
                self._build_people()
                self._build_paths()

    def _button(self, words: str, what: str, *, key: str = "", look: str = "") -> Any:
        from nicegui import ui

        hint = f"<kbd>{key}</kbd>" if key else ""
        button = ui.html(words + hint, sanitize=False, tag="button").props("type=button")
        return button.classes(f"plain-button {look}").on(
            "click", lambda: self.on_act(what), args=[]
        )

    def _build_scene_bar(self) -> None:
        from nicegui import ui

        with ui.element("div").classes("scene-bar"):
            self.heading = ui.html("", sanitize=False, tag="h2")
            self._button("←<span class='out-of-sight'>Previous scene</span>", "previous")
            self._button("Next scene", "next", key="N")
            ui.html(
                "<label class='plain-button' tabindex='-1'>Add a picture…<input id='picture-file' "
                "class='out-of-sight' type='file' "
                "accept='image/png,image/jpeg,image/webp'></label>",
                sanitize=False,
            )

    def _build_actions(self) -> None:
        from nicegui import ui

        with ui.element("div").classes("actions").props('role="toolbar" aria-label="Actions"'):
            self.accept = self._button("Accept", "accept", key="A", look="accept")
            self.reject = self._button("Reject", "reject", key="R", look="reject")
            self.undo = self._button("Undo", "undo", key="U")
            self.redo = self._button("Redo", "redo", key="⇧U")
            self.delete = self._button("Delete", "delete", key="Del")
            ui.html("Replay<kbd>Space</kbd>", sanitize=False, tag="button").props(
                "id=replay type=button"
            ).classes("plain-button")
            ui.html(
                "<label class='speed'><span class='soft'>Speed</span> <select id='speed' "
                "class='plain-input'><option value='0.5'>½</option>"
                "<option value='1' selected>1</option><option value='2'>2</option>"
                "<option value='4'>4</option>"
                "</select></label>",
                sanitize=False,
            )

    def _build_understood(self) -> None:
        from nicegui import ui

        with ui.element("section").classes("card understood"):
            ui.html("Understood so far", sanitize=False, tag="h2")
            self.words = ui.html("<p class='soft'>Looking at what is there…</p>", sanitize=False)
            self.words.props('aria-live="polite"')
            self.conflicts = ui.element("div").classes("conflicts")
            with ui.element("div").classes("ask"):
                self.ask = self._button("Ask me", "ask", key="Q", look="ask-button")
                self.advice = ui.html("", sanitize=False).classes("soft")

    def _build_objects(self) -> None:
        """Where the set does not list a scene's objects, people do."""
        from nicegui import ui

        with ui.element("section").classes("card objects") as self.objects:
            ui.html("What stands here", sanitize=False, tag="h2")
            ui.html(
                "Name an object, press <b>Mark</b>, and draw a loop around it. Distances are "
                "measured to what is marked.",
                sanitize=False, tag="p",
            ).classes("soft")  # fmt: skip
            with ui.element("div").classes("mark-row"):
                ui.html("<label for='object-word'>It is a</label>", sanitize=False)
                ui.element("input").props(
                    'id=object-word autocomplete=off maxlength=60 placeholder="cup"'
                ).classes("plain-input").on(
                    "input", lambda e: self.on_act("object_word", e.args),
                    js_handler="(e) => emit(e.target.value)",
                )  # fmt: skip
                ui.html("Mark", sanitize=False, tag="button").props(
                    "id=mark type=button aria-pressed=false"
                ).classes("plain-button")
            self.marked = ui.element("div").classes("marked")
            self.find = self._button("Find objects by themselves", "find")

    def _show_objects(self) -> None:
        from nicegui import ui

        state = self.state
        may = state.bench.may_mark(state.scene_id)
        self.objects.set_visibility(may)
        self.marked.clear()
        if not may:
            return
        self.find.set_visibility(state.scene.picture is not None and state.scene.objects is None)
        with self.marked:
            for item in state.scene.objects or ():
                html = f"{escape(item.id)} <span aria-hidden='true'>×</span>"
                ui.html(html, sanitize=False, tag="button").props(
                    f'type=button aria-label="{escape(item.id)}: take it off the list"'
                ).classes("plain-button small").on(
                    "click", lambda name=item.id: self.on_act("unmark", name), args=[]
                )

    def _build_people(self) -> None:
        from nicegui import ui

        # Without a value of the element's own: every update of the page would set it again,
        # over what a person is typing. `remember` fills the fields.
        def field(label: str, id: str, what: str, extra: str = "") -> Any:
            ui.html(f"<label for='{id}'>{label}</label>", sanitize=False)
            return (
                ui.element("input")
                .props(f'id={id} autocomplete=off maxlength=60 {extra}')
                .classes("plain-input")
                .on("change", lambda e: self.on_act(what, e.args),
                    js_handler="(e) => emit(e.target.value)")
            )  # fmt: skip

        with ui.element("section").classes("card people"):
            ui.html("Who is teaching", sanitize=False, tag="h2")
            with ui.element("div").classes("fields"):
                field("Type", "type-field", "type", "aria-describedby=type-words")
                self.types = ui.element("div").classes("type-chips")
                field("Name", "name-field", "demonstrator", 'placeholder="may be left out"')
                ui.html("<label for='next-field'>Next scene</label>", sanitize=False)
                with ui.element("select").props("id=next-field").classes("plain-input").on(
                    "change", lambda e: self.on_act("next_after", e.args),
                    js_handler="(e) => emit(e.target.value)",
                ):  # fmt: skip
                    for words, number in NEXT_AFTER.items():
                        mark = " selected" if number == self.state.next_after else ""
                        ui.html(escape(words), sanitize=False, tag="option").props(
                            f'value="{words}"{mark}'
                        )
            ui.html(
                "A type is a kind of person, such as careful. Its paths are understood together.",
                sanitize=False, tag="p",
            ).props("id=type-words").classes("soft type-words")  # fmt: skip

    def _build_paths(self) -> None:
        from nicegui import ui

        with ui.element("section").classes("card paths"):
            self.paths_heading = ui.html("", sanitize=False, tag="h2")
            self.list = ui.element("div").classes("path-list")
            ui.html(
                "<a class='plain-button' href='/api/export/rules' download='rules.json'>"
                "Save the rules</a>"
                "<a class='plain-button' href='/api/export/set.zip' download='set.zip'>"
                "Save the set</a>",
                sanitize=False, tag="p",
            ).classes("take")  # fmt: skip
            ui.html(
                "Every stroke is saved at once; the set is written to "
                f"<code>{escape(str(self.state.bench.out))}</code>.",
                sanitize=False, tag="p",
            ).classes("soft saved")  # fmt: skip

    def show(self) -> None:
        """Everything that needs no computing."""
        state, bench = self.state, self.state.bench
        state.shown_version = bench.version
        scene = state.scene
        standing = bench.standing
        place = list(standing.scenes).index(scene.scene_id)
        now = (scene.scene_id, len(standing.scenes), [o.id for o in scene.objects or ()])
        if self._shown_scene != now:
            self._shown_scene = now
            self._show_objects()
            url = (
                None
                if scene.picture is None
                else f"/api/scenes/{quote(scene.scene_id, safe='')}/picture.png"
            )
            self.picture.set_content(scene_svg(scene, picture_url=url))
            x, y, width, height = view_box(scene)
            self.pen.set_content(
                f'<svg id="pen" class="scene over" viewBox="{x:g} {y:g} {width:g} {height:g}" '
                f'style="--line-px:{max(width, height) / 200:g}px" tabindex="0" role="application" '
                'aria-label="Draw a path from the circle to the star. With the keyboard: '
                'arrow keys bend a path, Enter draws it."></svg>'
            )
            self.stage.style(f"--wide:{width:g};--high:{height:g}")
            self.stage._props["data-scene"] = json.dumps(
                {
                    "id": scene.scene_id,
                    "start": scene.start[:2],
                    "goal": scene.goal[:2],
                    "width": width,
                }
            )
        self.stage._props["data-hint"] = state.hint
        self.stage.update()
        total = len(standing.scenes)
        self.heading.set_content(
            f"Scene {escape(scene.scene_id)} <span class='soft'>{place + 1} of {total}</span>"
        )
        self._show_marks()
        self._show_list()
        self.show_advice()
        can_undo, can_redo = bench.journal.can(state.actor)
        judged = state.chosen is not None or state.asked is not None
        for button, on in (
            (self.accept, judged), (self.reject, judged), (self.delete, state.chosen is not None),
            (self.undo, can_undo), (self.redo, can_redo),
        ):  # fmt: skip
            button.props(remove="disabled") if on else button.props("disabled")
        self._show_types()

    def _show_types(self) -> None:
        """The types there are, one click each."""
        from nicegui import ui

        now = (self.state.bench.types, self.state.type)
        if now == self._shown_types:
            return
        self._shown_types = now
        self.types.clear()
        with self.types:
            for name in now[0] if now[0] != (now[1],) else ():
                ui.html(escape(name), sanitize=False, tag="button").props(
                    f"type=button aria-pressed={'true' if name == now[1] else 'false'}"
                ).classes("plain-button small").on(
                    "click", lambda name=name: self.on_act("type", name), args=[]
                )

    def _show_marks(self) -> None:
        state = self.state
        bench = state.bench
        rings = rings_svg(state.scene, state.understood.rule, bench.metres_per_unit, bench.units)
        parts = [rings, paths_svg(state.here, state.chosen)]
        if state.asked is not None and state.asked.points is not None:
            points = " ".join(f"{p[0]:.1f},{p[1]:.1f}" for p in state.asked.points)
            parts.append(f'<polyline class="halo" points="{points}"/>')
            parts.append(f'<polyline class="question-path" points="{points}"/>')
        parts.append(ends_svg(state.scene, words=len(parts) == 2 and not state.here))
        self.marks.set_content(marks_svg(state.scene, "".join(parts)))

    def _show_list(self) -> None:
        from nicegui import ui

        rows = rows_html(self.state.here, self.state.chosen)
        of = escape(self.state.type)
        self.paths_heading.set_content(
            f"Paths of {of} in this scene <span class='soft'>{len(rows)}</span>"
        )
        self.list.clear()
        with self.list:
            for name, html, chosen in rows[-MOST_ROWS:]:
                ui.html(html, sanitize=False, tag="button").props(
                    f"type=button aria-pressed={'true' if chosen else 'false'}"
                ).on("click", lambda name=name: self.on_act("pick", name), args=[])

    def show_understood(self, seconds: float) -> None:
        """Rule, rings, conflicts."""
        from nicegui import ui

        state, bench = self.state, self.state.bench
        self.words.set_content(
            understood_html(state.understood, bench.metres_per_unit, bench.units)
        )
        self.words.props(f"data-ms={1000 * seconds:.0f} data-version={bench.version}")
        self._show_marks()
        self.conflicts.clear()
        with self.conflicts:
            asked = culprits(state.conflicts)
            for some in asked[:3]:
                with ui.element("div").classes("conflict").props("role=group"):
                    alone = len(some) == 1
                    words = conflict_words(some[0]) if alone else culprit_words(some)
                    ui.html(words, sanitize=False, tag="p")
                    self._choice("Keep" if alone else "Keep all", "keep", some)
                    if alone:
                        name = some[0].demo_id
                        self._choice(f"Accept {short_name(name)}", "change", (name, True))
                    for other in some[0].against:
                        self._choice(f"Reject {short_name(other)}", "change", (other, False))
            if len(asked) > 3:
                ui.html(f"and {len(asked) - 3} more", sanitize=False, tag="p")

    def _choice(self, words: str, what: str, value: Any) -> None:
        from nicegui import ui

        ui.html(escape(words), sanitize=False, tag="button").props("type=button").classes(
            "plain-button small"
        ).on("click", lambda: self.on_act(what, value), args=[])

    def show_advice(self) -> None:
        """How many more would help."""
        state = self.state
        asked = "Is the green path acceptable? Accept or reject it."
        self.advice.set_content(escape(state.advice) if state.asked is None else asked)

    def tell(self, words: str) -> None:
        """One line under the scene."""
        from nicegui import ui

        ui.run_javascript(f"window.teachTell?.({json.dumps(words)})")

    def remember(self) -> None:
        """Lets the tab remember where it was, for a reload; shows the fields as they are."""
        from nicegui import ui

        state = self.state
        kept = state.to_remember()
        fields = {
            "type-field": state.type,
            "name-field": state.demonstrator,
            "next-field": kept["next_after"],
        }
        ui.run_javascript(f"window.teachRemember?.({json.dumps(kept)}, {json.dumps(fields)})")
