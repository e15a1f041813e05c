"""The `modallab` command, and `python -m modallab`."""


def main() -> None:
    """Run the command line."""
    # Here and not above: worker processes load this file too, and need none of it.
    from modallab.api.cli import app

    app()


if __name__ == "__main__":
    main()
