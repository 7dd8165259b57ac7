"""``python -m cspcheck`` is ``cspcheck``."""

from cspcheck.cli import main

if __name__ == "__main__":
    main()
