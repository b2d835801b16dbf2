"""`python -m cyclemap`: the same as the command `cyclemap`."""

from cyclemap.cli.main import main

if __name__ == "__main__":
    main()
