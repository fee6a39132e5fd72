"""What the words and signs of a report mean; only those that it uses are listed."""

from __future__ import annotations

from collections.abc import Iterable

from demospec.report._view import Lines, Section, Table, Text

WORDS = (
    ("clearance", "The least distance that a person keeps from the outline of an object.",
     ("clearance",)),
    ("type", "A kind of person with one preference, such as careful. Its paths are learned from "
     "together.", ("type",)),
    ("allowed", "In brackets: every clearance between the two ends explains the answers.",
     ("allowed",)),
    ("95 % interval", "Where the same were done again and again, the true number would lie in "
     "such brackets in 95 of 100 times.", ("95 %",)),
    ("bit", "What a yes-or-no answer tells at most: it halves what is left open.", (" bit",)),
    ("E[p(v)]", "The share of random paths between start and goal that are accepted.",
     ("E[p(v)]",)),
    ("causal", "Putting one such object on the table changes the share of accepted paths, more "
     "than chance and more than the stated least effect.", ("causal",)),
    ("placebo", "A change that must do nothing: a moved patch of bare table. It shows that the "
     "test does not see effects everywhere.", ("placebo",)),
    ("balanced accuracy", "Mean of the shares judged rightly among accepted and among rejected "
     "paths; 50 % is guessing.", ("balanced accuracy",)),
    ("T_min, radius", "The paper's parameters: nothing may come within T_min of any centre; "
     "within an object's radius a path may spend little time.", ("T_min",)),
    ("L", "T_min plus what each radius adds: the number that the paper makes least and greatest.",
     (" L ", "L =")),
    ("hull", "Least and greatest value of a parameter over all that are consistent with the "
     "labels.", ("hull",)),
    ("†", "The value lies at the bound that the solver was given, not where data put it.",
     ("†",)),
    ("repair", "A rejected path, moved until the model accepts it.", ("epair",)),
)  # fmt: skip


def glossary_of(sections: Iterable[Section]) -> tuple[tuple[str, str], ...]:
    """(term, meaning) of the words that the sections use."""
    text = " ".join(_texts(sections)).replace("\u00a0", " ")
    return tuple((term, words) for term, words, signs in WORDS if any(s in text for s in signs))


def _texts(sections: Iterable[Section]) -> Iterable[str]:
    for section in sections:
        yield from (section.title, section.lead)
        for block in section.blocks:
            if isinstance(block, Text):
                yield block.words
            elif isinstance(block, Lines):
                yield from block.sentences
            elif isinstance(block, Table):
                yield from (block.caption, block.note, *block.header)
                yield from (cell for row in block.rows for cell in row)
            else:
                yield block.caption
