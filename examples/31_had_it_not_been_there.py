"""One rejected path: would it be accepted had the glass not been there?

python examples/31_had_it_not_been_there.py
"""

from __future__ import annotations

from demospec import learn_rules, simulate_set
from demospec.causal import but_for

data, _ = simulate_set(demonstrations=8, seed=8)
rules = learn_rules(data)
bad = next(d for d in data.demonstrations if d.type == "normal" and not d.valid)
print(but_for(rules, data.scene(bad.scene_id), bad.points, "normal").sentence)
