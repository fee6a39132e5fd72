"""The influence family (the paper's): T_min, T_object and F_max; problems, rules and answers."""
