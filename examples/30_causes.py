"""Which kinds of things *cause* rejection? Interventions on scenes, with intervals and a placebo.

python examples/30_causes.py
"""

from __future__ import annotations

from demospec import find_causes, learn_rules, simulate_set

data, _ = simulate_set(train_scenes=12, test_scenes=1, demonstrations=8, seed=7)
findings = find_causes(learn_rules(data), data.of_split("train").scenes)
for effect in findings.effects:
    low, high = effect.interval
    added = f"{effect.type:>10} + {effect.symbol:<8}"
    mark = "CAUSAL" if effect.causal else ""
    print(f"{added} {effect.effect:+.3f} [{low:+.3f}, {high:+.3f}] {mark}")
print(*findings.sentences, sep="\n")
