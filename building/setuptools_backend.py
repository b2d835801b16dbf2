"""The build backend (PEP 517, PEP 660): setuptools builds the package, after the engine in it was
compiled.
"""

import shutil
import tempfile
from contextlib import chdir
from pathlib import Path
from typing import Any

from engine_library import ENGINE, ROOT, build, missing_requirements
from setuptools import build_meta
from setuptools.build_meta import (
    build_sdist,
    prepare_metadata_for_build_editable,
    prepare_metadata_for_build_wheel,
)
from setuptools.command.bdist_wheel import bdist_wheel

__all__ = ["build_sdist", "prepare_metadata_for_build_editable", "prepare_metadata_for_build_wheel"]

# What a wheel is built from.
NEEDED = ("pyproject.toml", "setup.py", "README.md", "LICENSE", "cyclemap/**/*", "figures/**/*")

Settings = dict[str, Any] | None


def get_requires_for_build_wheel(config_settings: Settings = None) -> list[str]:
    """Return what a build needs besides pyproject.toml's list: a C compiler, where none works."""
    return missing_requirements()


get_requires_for_build_editable = get_requires_for_build_wheel


def build_wheel(
    wheel_directory: str, config_settings: Settings = None, metadata_directory: str | None = None
) -> str:
    """Build a wheel in a copy of the sources: they may be read-only, and builds at once do not
    meet.
    """
    wheel_directory = str(Path(wheel_directory).resolve())
    with tempfile.TemporaryDirectory(prefix="cyclemap-", ignore_cleanup_errors=True) as folder:
        copy_sources(Path(folder))
        build(Path(folder) / ENGINE.relative_to(ROOT))
        with chdir(folder):
            return build_meta.build_wheel(wheel_directory, config_settings, metadata_directory)


def copy_sources(folder: Path) -> None:
    """Copy what a wheel is built from, all but the engine's library."""
    for path in (path for pattern in NEEDED for path in ROOT.glob(pattern)):
        if (
            path.is_file()
            and path.parent.name != "__pycache__"
            and not path.name.startswith("_engine.")
        ):
            copy = folder / path.relative_to(ROOT)
            copy.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(path, copy)


def build_editable(
    wheel_directory: str, config_settings: Settings = None, metadata_directory: str | None = None
) -> str:
    """Put the library beside its sources, and let the wheel point there."""
    build()
    return build_meta.build_editable(wheel_directory, config_settings, metadata_directory)


class PlatformWheel(bdist_wheel):  # type: ignore[misc]
    """A wheel that holds a library of one platform, for every Python 3."""

    def finalize_options(self) -> None:
        """Tell setuptools that there is more than Python in it."""
        self.distribution.has_ext_modules = lambda: True
        super().finalize_options()

    def get_tag(self) -> tuple[str, str, str]:
        """Return the tags of Python, of its C interface, which is not used, and of the platform."""
        return "py3", "none", super().get_tag()[2]
