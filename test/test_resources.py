# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Where config/ and models/ are looked for; test_install.py does it with real installations."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from aerial_gnss_ros import resources
from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.resources import config_path, install_hint, model_path, resource_root

PREFIXES = {
    "virtual environment": "venv/lib/python3.11/site-packages",
    "user": "home/.local/lib/python3.12/site-packages",
    "Debian's own pip": "usr/local/lib/python3.12/dist-packages",
    "Debian, colcon": "install/aerial_gnss_ros/local/lib/python3.12/dist-packages",
    "colcon": "install/aerial_gnss_ros/lib/python3.12/site-packages",
    "colcon --merge-install": "install/lib/python3.12/site-packages",
    "pip --target": "vendor",
}


@pytest.mark.parametrize("site", PREFIXES.values(), ids=PREFIXES.keys())
def test_share_is_found_above_the_package(site: str, tmp_path: Path) -> None:
    package = tmp_path / site / "aerial_gnss_ros"
    package.mkdir(parents=True)
    prefix = tmp_path / (site.partition("/lib/")[0] if "/lib/" in site else site)
    share = prefix / "share" / "aerial_gnss_ros"
    share.mkdir(parents=True)
    assert resource_root(package) == share


def test_a_stray_config_folder_beside_the_package_is_not_ours(tmp_path: Path) -> None:
    site = tmp_path / "lib" / "python3.12" / "site-packages"
    (site / "aerial_gnss_ros").mkdir(parents=True)
    (site / "config").mkdir()
    (tmp_path / "share" / "aerial_gnss_ros").mkdir(parents=True)
    assert resource_root(site / "aerial_gnss_ros") == tmp_path / "share" / "aerial_gnss_ros"


def test_an_incomplete_installation_is_said(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="install the package with pip or colcon"):
        resource_root(tmp_path / "aerial_gnss_ros")


@pytest.mark.parametrize("find", [config_path, model_path])
def test_a_missing_file_is_named_with_what_there_is(find: object) -> None:
    with pytest.raises(InputError, match=r"comes without \w+/nothing_like_it\.x; .*holds"):
        find("nothing_like_it.x")


def test_the_licence_of_the_models_comes_with_them() -> None:
    assert "AFFERO" in model_path("LICENSE").read_text()


def test_an_extra_is_installed_from_this_folder_and_never_by_name():
    """A name alone is looked up on a public index, where anybody can register it."""
    root = Path(resources.__file__).resolve().parent.parent
    assert install_hint("mavlink") == f'`pip install ".[mavlink]"` in {root}'
    assert install_hint() == f"`pip install .` in {root}"
    setup = (root / "setup.py").read_text()
    here = re.compile(r"pip install (?:-[-\w]+ )*[\"']?(\.|\./interfaces)(?![\w])")
    files = [root / "README.md", root / "models/README.md"]
    files += [
        file for top in ("aerial_gnss_ros", "config", "docs") for file in (root / top).rglob("*")
    ]
    for file in files:
        if file.suffix not in (".py", ".html", ".yaml", ".md"):
            continue
        text = file.read_text(encoding="utf-8")
        for extra in re.findall(r"install_hint\(.(\w+).\)", text):
            assert f'"{extra}": ' in setup, (file, extra)
        for line in text.splitlines():
            if (
                re.search(r"pip install\b", line)
                and "pip install --user" not in line
                and "{what}" not in line
            ):
                # What a robot lacks beside apt, by names that others own, stands in the docs only.
                known = file.suffix == ".md" and ("rosbags>=" in line or "--no-deps" in line)
                assert known or here.search(line), (file, line)
            assert not re.search(r"aerial[_-]gnss[_-]ros\[", line), (file, line)
