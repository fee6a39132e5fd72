"""What do these demonstrations say? Simulated ones here; `read_set(FOLDER)` reads yours.

python examples/01_three_lines.py
"""

from demospec import learn_rules, simulate_set

data, _ = simulate_set(demonstrations=3, seed=1)
for user_type, rule in learn_rules(data).rules.items():
    print(f"{user_type}: {rule.sentence}")
