"""``python -m demospec.cli``."""

from demospec.cli._app import main

main()
