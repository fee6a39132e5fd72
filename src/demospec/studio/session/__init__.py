"""A session: journal, replay, workspace, models, uploaded pictures, cached distances."""
