"""The program as a module: `python -m freebody`."""

from freebody.cli import main

if __name__ == "__main__":
    main()
