"""The packages of the distribution; everything else about it is in pyproject.toml."""

from setuptools import find_packages, setup

setup(
    packages=[
        *find_packages(include=["cyclemap*"]),
        *(f"cyclemap.{name}" for name in find_packages(include=["figures*"])),
    ],
    package_dir={"cyclemap.figures": "figures"},
)
