"""The pages Check and Demonstrations: what was taught, looked at again."""
