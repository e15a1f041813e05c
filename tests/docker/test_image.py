"""The image, built by buildah on a base of Debian's packages in place of the one that a registry has."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.docker.image import DOCKERFILE, ROOT

TOOLS = ("buildah", "debootstrap")
LARGEST = 450.0  # MB, with a base of 133
BASE, IMAGE = "localhost/base", "localhost/modallab"
PACKAGES = "ca-certificates,python3,python3-pip,python3-venv"
UNUSED = ("var/lib/apt/lists", "var/cache/apt", "usr/share/doc", "usr/share/man", "usr/share/locale")
ARRAYS = "import h5py, meshio, numpy.linalg, psycopg, pyuff, scipy.io, scipy.signal, scipy.stats"

pytestmark = pytest.mark.skipif(
    sys.platform != "linux" or os.geteuid() != 0 or not all(map(shutil.which, TOOLS)),
    reason=f"NO IMAGE BUILT: needs Linux, root, {' and '.join(TOOLS)}",
)


class Builder:
    """Images in a folder, without an engine and without privileges beyond a chroot."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def __call__(self, *words: str) -> str:
        """Return what buildah says."""
        places = ["--root", str(self._folder / "storage"), "--runroot", str(self._folder / "run")]
        done = subprocess.run(
            ["buildah", "--storage-driver", "vfs", *places, *words],
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, f"{words}\n{done.stdout[-3000:]}\n{done.stderr[-3000:]}"
        return done.stdout.strip()

    def make_base(self) -> None:
        """Make the base; the test is skipped where Debian's packages are out of reach."""
        root = self._folder / "root"
        made = subprocess.run(
            ["debootstrap", "--variant=minbase", f"--include={PACKAGES}", "trixie", str(root)],
            capture_output=True,
            text=True,
            check=False,
        )
        if made.returncode != 0:
            pytest.skip(f"NO IMAGE BUILT: {made.stdout[-300:]}")
        for folder in UNUSED:
            shutil.rmtree(root / folder)
        container = self("from", "scratch")
        self("add", "--quiet", container, str(root), "/")
        self("config", "--env", "PATH=/usr/local/bin:/usr/bin:/bin", container)
        self("commit", "--quiet", "--rm", container, BASE)
        shutil.rmtree(root)

    def run(self, container: str, *words: str) -> str:
        """Return what a command prints in a container."""
        return self("run", "--isolation", "chroot", container, "--", *words)


def test_the_image_is_built_small_and_works(tmp_path: Path) -> None:
    build = Builder(tmp_path)
    build.make_base()
    of_file = ("--file", str(DOCKERFILE), "--tag", IMAGE, "--build-arg", f"BASE={BASE}", str(ROOT))
    certificates = "/etc/ssl/certs:/etc/ssl/certs:ro"  # of whatever stands between this machine and an index
    build("build", "--isolation", "chroot", "--format", "docker", "--volume", certificates, *of_file)
    size, unit = build("images", "--format", "{{.Size}}", IMAGE).split()
    assert unit == "MB"
    assert float(size) < LARGEST
    container = build("from", IMAGE)
    assert build.run(container, "id", "-u") == "10001"
    assert build.run(container, "modallab", "--version").startswith("modallab ")
    build.run(container, "python", "-c", ARRAYS)  # nothing is missing that was taken away
    build.run(container, "modallab", "init")
    assert "modallab.sqlite" in build.run(container, "ls", "/data")
