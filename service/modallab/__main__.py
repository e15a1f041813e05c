"""The `modallab` command, and `python -m modallab`."""

import os


def main() -> None:
    """Run the command line."""
    # Before numpy is imported, here and in the worker processes, which inherit it: two threads a
    # process on cores that other processes keep busy cost three quarters of the throughput.
    for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ.setdefault(name, "1")
    # Here and not above: worker processes load this file too, and need none of it.
    from modallab_cli.app import app

    app(prog_name="modallab")


if __name__ == "__main__":
    main()
