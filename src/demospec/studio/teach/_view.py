"""The elements of the Teach page, and how they show a tab's state."""

from __future__ import annotations

import json
from collections.abc import Callable, Coroutine
from typing import Any
from urllib.parse import quote

from markupsafe import Markup

from demospec.frames import describe_length
from demospec.report import (
    VERDICTS,
    ends_svg,
    joined,
    over_svg,
    paths_svg,
    points_of,
    rings_svg,
    scene_svg,
    short_name,
    view_box,
)
from demospec.scene import Scene
from demospec.studio.server._elements import element, fill
from demospec.studio.teach._conflicts import Conflict
from demospec.studio.teach._state import NEXT_AFTER, TeachState
from demospec.studio.teach._text import (
    conflict_words,
    rows_html,
    understood_html,
)

MOST_ROWS = 60
"""Paths listed for one scene; more are counted."""

MOST_SIDES = 4
"""Paths of one contradiction that are drawn beside each other."""

Act = Callable[..., Coroutine[Any, Any, None]]


def picture_url(scene: Scene) -> str | None:
    """Where the browser finds a scene's picture."""
    if scene.picture is None:
        return None
    return f"/api/scenes/{quote(scene.scene_id, safe='')}/picture.png"


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
        self._shown_conflicts: tuple[Any, ...] | None = None

    def build(self) -> None:
        """Builds the page inside the current element."""
        from nicegui import ui

        with ui.element("div").classes("teach"):
            with ui.element("section").classes("teach-stage").props('aria-label="Scene"'):
                self._build_scene_bar()
                # The script finds the scene's geometry in `data-scene`.
                self.stage = ui.element("div").props("id=stage").classes("stage")
                with self.stage:
                    self.picture = element()
                    self.marks = element().classes("marks")
                    self.pen = element().classes("marks")
                element().props('id=hint role="status"').classes("hint soft")
                self._build_actions()
            with ui.element("aside").classes("teach-side").props('aria-label="Understanding"'):
                self._build_understood()
                self._build_people()
                self._build_table()
                self._build_paths()

    def _button(self, words: str | Markup, what: str, *, key: str = "", look: str = "") -> Any:
        hint = Markup("<kbd>{}</kbd>").format(key) if key else ""
        button = element(joined([words, hint]), "button").props("type=button")
        return button.classes(f"plain-button {look}").on(
            "click", lambda: self.on_act(what), args=[]
        )

    def _build_scene_bar(self) -> None:
        from nicegui import ui

        with ui.element("div").classes("scene-bar"):
            self.heading = element(tag="h2")
            previous = Markup("←<span class='out-of-sight'>Previous scene</span>")
            self._button(previous, "previous")
            self._button("Next scene", "next", key="N")
            element(
                Markup(
                    "<label class='plain-button' tabindex='-1'>Add a picture…<input "
                    "id='picture-file' class='out-of-sight' type='file' "
                    "accept='image/png,image/jpeg,image/webp'></label>"
                )
            )

    def _build_actions(self) -> None:
        from nicegui import ui

        with ui.element("div").classes("actions").props('role="toolbar" aria-label="Actions"'):
            self.accept = self._button("Accept", "accept", key="A", look="accept")
            self.reject = self._button("Reject", "reject", key="R", look="reject")
            self.undo = self._button("Undo", "undo", key="U")
            self.redo = self._button("Redo", "redo", key="⇧U")
            self.delete = self._button("Delete", "delete", key="Del")
            element(Markup("Replay<kbd>Space</kbd>"), "button").props(
                "id=replay type=button"
            ).classes("plain-button")
            element(
                Markup(
                    "<label class='speed'><span class='soft'>Speed</span> <select id='speed' "
                    "class='plain-input'><option value='0.5'>½</option>"
                    "<option value='1' selected>1</option><option value='2'>2</option>"
                    "<option value='4'>4</option></select></label>"
                )
            )

    def _build_understood(self) -> None:
        from nicegui import ui

        with ui.element("section").classes("card understood"):
            element("Understood so far", "h2")
            self.words = element(Markup("<p class='soft'>Looking at what is there…</p>"))
            self.words.props('aria-live="polite"')
            self.conflicts = ui.element("div").classes("conflicts")
            with ui.element("div").classes("ask"):
                self.ask = self._button("Ask me", "ask", key="Q", look="ask-button")
                self.advice = element().classes("soft")

    def _build_table(self) -> None:
        """What is known of the table, and the way to change it."""
        from nicegui import ui

        with ui.element("section").classes("card table-card"):
            element("This table", "h2")
            self.table = element()

    def _show_table(self) -> None:
        bench, scene = self.state.bench, self.state.scene
        scale = bench.scale_of(scene.scene_id)
        what = "objects not listed" if scene.objects is None else (
            "1 object" if len(scene.objects) == 1 else f"{len(scene.objects)} objects"
        )  # fmt: skip
        wide = "width not known"
        if scale is not None and scene.size_px is not None:
            wide = f"{describe_length(scene.size_px[0] * scale, 1.0, 'm')} wide"
        fill(
            self.table,
            Markup("<p>{}, {}. <a href='/table?scene={}'>Change it</a></p>").format(
                what, wide, quote(scene.scene_id, safe="")
            ),
        )

    def _build_people(self) -> None:
        from nicegui import ui

        # Without a value of the element's own: every update of the page would set it again,
        # over what a person is typing. `remember` fills the fields.
        def field(label: str, id: str, what: str, extra: str = "") -> Any:
            element(Markup("<label for='{}'>{}</label>").format(id, label))
            return (
                ui.element("input")
                .props(f"id={id} autocomplete=off maxlength=60 {extra}")
                .classes("plain-input")
                .on("change", lambda e: self.on_act(what, e.args),
                    js_handler="(e) => emit(e.target.value)")
            )  # fmt: skip

        with ui.element("section").classes("card people"):
            element("Whose preference?", "h2")
            self.types = ui.element("div").classes("type-chips").props("role=group")
            self.types.props["aria-label"] = "Whose preference?"
            element(
                Markup(
                    "<details id='new-person'><summary>Somebody else…</summary>"
                    "<div class='new-person'><label for='type-field'>Who?</label>"
                    "<input id='type-field' class='plain-input' autocomplete='off' maxlength='60' "
                    "placeholder='grandmother' aria-describedby='type-words'>"
                    "<button type='button' id='add-person' class='plain-button'>Add</button></div>"
                    "<p id='type-words' class='soft'>A person, or a kind of person such as "
                    "careful. The paths of each are understood apart.</p></details>"
                )
            )
            with ui.element("div").classes("fields"):
                field("Drawn by", "name-field", "demonstrator", 'placeholder="may be left out"')
                element(Markup("<label for='next-field'>Next scene</label>"))
                with ui.element("select").props("id=next-field").classes("plain-input").on(
                    "change", lambda e: self.on_act("next_after", e.args),
                    js_handler="(e) => emit(e.target.value)",
                ):  # fmt: skip
                    for words, number in NEXT_AFTER.items():
                        mark = " selected" if number == self.state.next_after else ""
                        element(words, "option").props(f'value="{words}"{mark}')

    def _build_paths(self) -> None:
        from nicegui import ui

        with ui.element("section").classes("card paths"):
            self.paths_heading = element(tag="h2")
            self.list = ui.element("div").classes("path-list")
            element(
                Markup("<a class='plain-button' href='/results'>Plan, report and download</a>"),
                "p",
            ).classes("take")
            element(
                Markup(
                    "Every stroke is saved at once; the set is written to <code>{}</code>."
                ).format(self.state.bench.out),
                "p",
            ).classes("soft saved")

    def show(self) -> None:
        """Everything that needs no computing."""
        state, bench = self.state, self.state.bench
        state.shown_version = bench.version
        scene = state.scene
        standing = bench.standing
        place = list(standing.scenes).index(scene.scene_id)
        now = (scene.scene_id, len(standing.scenes), scene.objects, scene.start, scene.goal)
        if self._shown_scene != now:
            self._shown_scene = now
            # What people outlined is always seen; what a picture shows by itself, on hovering.
            marked = bench.may_mark(scene.scene_id)
            look = "scene outlined" if marked else "scene"
            url = picture_url(scene)
            fill(self.picture, scene_svg(scene, picture_url=url, look=look, names=marked))
            x, y, width, height = view_box(scene)
            fill(
                self.pen,
                Markup(
                    '<svg id="pen" class="scene over" viewBox="{:g} {:g} {:g} {:g}" '
                    'style="--line-px:{:g}px" tabindex="0" role="application" '
                    'aria-label="Draw a path from the circle to the star. With the keyboard: '
                    'arrow keys bend a path, Enter draws it."></svg>'
                ).format(x, y, width, height, max(width, height) / 200),
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
        fill(
            self.heading,
            Markup("Scene {} <span class='soft'>{} of {}</span>").format(
                scene.scene_id, place + 1, total
            ),
        )
        self._show_table()
        self._show_marks()
        self._show_list()
        self._show_conflicts()
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
        """The people there are, one click each."""
        state = self.state
        known = tuple(dict.fromkeys([*state.bench.types, state.type]))
        if (known, state.type) == self._shown_types:
            return
        self._shown_types = (known, state.type)
        self.types.clear()
        with self.types:
            for name in known:
                button = element("you" if name == "me" else name, "button")
                button.props("type=button").props["aria-pressed"] = (
                    "true" if name == state.type else "false"
                )
                button.classes("plain-button small").on(
                    "click", lambda name=name: self.on_act("type", name), args=[]
                )

    def _show_marks(self) -> None:
        state = self.state
        bench = state.bench
        scale = bench.scale_of(state.scene_id)
        rule = None
        if state.computed is not None and state.computed[2] == state.basis:
            rule = state.understood.rule_at(bench.units, scale)
        rings = rings_svg(state.scene, rule, scale, bench.units)
        parts = [rings, paths_svg(state.here, state.chosen)]
        if state.asked is not None and state.asked.points is not None:
            points = points_of(state.asked.points)
            for look in ("halo", "question-path"):
                parts.append(Markup('<polyline class="{}" points="{}"/>').format(look, points))
        parts.append(ends_svg(state.scene, words=len(parts) == 2 and not state.here))
        fill(self.marks, over_svg(state.scene, joined(parts)))

    def _show_list(self) -> None:
        rows = rows_html(self.state.here, self.state.chosen)
        fill(
            self.paths_heading,
            Markup("{} in this scene <span class='soft'>{}</span>").format(
                "Your paths" if self.state.type == "me" else f"Paths of {self.state.type}",
                len(rows),
            ),
        )
        self.list.clear()
        with self.list:
            for name, words, chosen in rows[-MOST_ROWS:]:
                element(words, "button").props(
                    f"type=button aria-pressed={'true' if chosen else 'false'}"
                ).on("click", lambda name=name: self.on_act("pick", name), args=[])

    def show_understood(self, seconds: float) -> None:
        """Rule, rings, conflicts."""

        state, bench = self.state, self.state.bench
        fill(self.words, understood_html(state.understood, state.alone))
        self.words.props(f"data-ms={1000 * seconds:.0f} data-version={bench.version}")
        self._show_marks()
        self._show_conflicts()

    def _show_conflicts(self) -> None:
        """One contradiction, both sides of it drawn; the others a click away."""
        from nicegui import ui

        state = self.state
        asked = state.conflicts
        state.doubt = min(state.doubt, max(len(asked) - 1, 0))
        now = (state.bench.version, state.type, state.doubt, asked)
        if now == self._shown_conflicts:
            return
        self._shown_conflicts = now
        self.conflicts.clear()
        if not asked:
            return
        group = asked[state.doubt]
        with self.conflicts, ui.element("div").classes("conflict").props("role=group") as card:
            card.props["aria-label"] = "Contradiction"
            if len(asked) > 1:
                with ui.element("div").classes("conflict-which"):
                    element(f"Contradiction {state.doubt + 1} of {len(asked)}", "span")
                    for sign, words, by in (("←", "Previous", -1), ("→", "Next", 1)):
                        button = self._choice(sign, "doubt", by)
                        button.props["aria-label"] = f"{words} contradiction"
            element(conflict_words(group, state.type), "p")
            self._show_sides(group)
            alone = len(group) == 1
            for other in group[0].against:
                self._choice(f"Reject {short_name(other)}", "change", (other, False))
            if alone:
                name = group[0].demo_id
                self._choice(f"Accept {short_name(name)}", "change", (name, True))
            rejected = tuple(c.demo_id for c in group)
            words = "Both are right" if alone and group[0].against else "All are right"
            self._choice(words if group[0].against else "It is right", "keep", rejected)

    def _show_sides(self, group: tuple[Conflict, ...]) -> None:
        """The paths that contradict each other, side by side; a click chooses one."""
        from nicegui import ui

        bench = self.state.bench
        demos = bench.standing.demonstrations
        names = dict.fromkeys([*group[0].against, *(c.demo_id for c in group)])
        with ui.element("div").classes("sides"):
            for name in list(names)[:MOST_SIDES]:
                demo = demos[name]
                scene = bench.scene(demo.scene_id)
                drawn = scene_svg(scene, paths_svg([demo]), picture_url=picture_url(scene))
                words = f"{short_name(name)} {VERDICTS[demo.valid]}"
                button = element(Markup("{}<span>{}</span>").format(drawn, words), "button")
                button.props("type=button").classes("side").on(
                    "click", lambda name=name: self.on_act("pick", name), args=[]
                )

    def _choice(self, words: str, what: str, value: Any) -> Any:
        return (
            element(words, "button")
            .props("type=button")
            .classes("plain-button small")
            .on("click", lambda: self.on_act(what, value), args=[])
        )

    def show_advice(self) -> None:
        """How many more would help."""
        state = self.state
        asked = "Is the green path acceptable? Accept or reject it."
        fill(self.advice, state.advice if state.asked is None else asked)

    def show_steps(self) -> None:
        """The ticks of the way."""
        from nicegui import ui

        state = self.state
        told = json.dumps([[vars(s) for s in state.steps], state.scene_id, state.type])
        ui.run_javascript(f"window.teachSteps?.(...{told})")

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
            "name-field": state.demonstrator,
            "next-field": kept["next_after"],
        }
        ui.run_javascript(f"window.teachRemember?.({json.dumps(kept)}, {json.dumps(fields)})")
