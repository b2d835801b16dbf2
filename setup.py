"""The packages of the distribution; everything else about it is in pyproject.toml."""

from setuptools import find_packages, setup

setup(
    packages=[*find_packages(include=["cyclemap*"]), "cyclemap.figures"],
    package_dir={"cyclemap.figures": "figures"},
)
