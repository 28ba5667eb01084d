# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A mesh of one's own: axes, colours, faces outward, and files that cannot be a robot."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from aerial_gnss_ros.cli import main
from aerial_gnss_ros.core.values.errors import ConfigError
from aerial_gnss_ros.simulation.mesh_file import MOST_FACES, read_mesh
from aerial_gnss_ros.simulation.robot_models import robot_model
from aerial_gnss_ros.training.layout import open_dataset

trimesh = pytest.importorskip("trimesh", reason="needs the extra [mesh]")
SIZE = (1.2, 0.4, 0.3)
NOSE, BLUE = "v 0.6 0 0", (1.0, 0.0, 0.0)


@pytest.fixture(name="obj")
def _obj(tmp_path: Path) -> Path:
    """A closed keel of 1.2 x 0.4 x 0.3 m: its bottom red of level 188, its sides without paint."""
    (tmp_path / "keel.mtl").write_text("newmtl red\nKd 0.7372549 0 0\n")
    path = tmp_path / "keel.obj"
    path.write_text(
        "mtllib keel.mtl\nv 0.6 0 0\nv -0.6 0.2 0\nv -0.6 -0.2 0\nv -0.6 0 0.3\n"
        "f 1 2 4\nf 3 1 4\nf 2 3 4\nusemtl red\nf 1 3 2\n"
    )
    return path


def _volume(mesh) -> float:
    corner = mesh.vertices[mesh.faces]
    return float(np.einsum("ij,ij->", corner[:, 0], np.cross(corner[:, 1], corner[:, 2])) / 6)


def test_an_obj_is_read_as_it_stands(obj: Path) -> None:
    model = robot_model(str(obj))
    assert (model.name, model.size) == ("keel", pytest.approx(SIZE))
    paint = ((0.1, 0.2, 0.3), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    mesh = model.build(0.0, paint)
    assert mesh.vertices[mesh.vertices[:, 0] > 0].tolist() == [[0.6, 0.0, 0.0]] * 2
    red = np.isclose(mesh.colours, (0.0, 0.0, 0.5029), atol=1e-3).all(axis=1)  # blue, green, red
    assert red.sum() == 1
    assert np.isclose(mesh.colours[~red], paint[0]).all()


@pytest.mark.parametrize("inside_out", [False, True])
def test_gltf_is_turned_into_our_axes_with_its_faces_outward(
    tmp_path: Path, inside_out: bool
) -> None:
    """In glTF the nose points to z, up is y: a box 1.2 m long, moved 2 cm up by its node."""
    body = trimesh.creation.box((0.4, 0.3, 1.2))
    body.visual = trimesh.visual.TextureVisuals(
        material=trimesh.visual.material.PBRMaterial(baseColorFactor=[0, 0, 128, 255])
    )
    if inside_out:
        body.invert()
    up = trimesh.transformations.translation_matrix([0.0, 0.02, 0.0])
    scene = trimesh.Scene()
    scene.add_geometry(body, transform=up)
    scene.export(tmp_path / "crate.glb")
    mesh, coloured = read_mesh(tmp_path / "crate.glb")
    np.testing.assert_allclose(np.ptp(mesh.vertices, axis=0), SIZE, atol=1e-6)
    assert mesh.vertices[:, 2].max() == pytest.approx(0.17)
    assert _volume(mesh) == pytest.approx(np.prod(SIZE), rel=1e-5)
    assert not mesh.two_sided.any()
    assert coloured.all()
    # Factors of glTF are linear already.
    np.testing.assert_allclose(mesh.colours, np.tile((128 / 255, 0.0, 0.0), (12, 1)), atol=0.005)


def test_an_open_sheet_is_seen_from_both_sides(tmp_path: Path) -> None:
    path = tmp_path / "sheet.obj"
    path.write_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n")
    mesh, coloured = read_mesh(path)
    assert mesh.two_sided.all()
    assert not coloured.any()


def _grid(side: int) -> str:
    points = [f"v {i / side} {j / side} 0" for i in range(side) for j in range(side)]
    faces = [
        f"f {i * side + j + 1} {i * side + j + 2} {i * side + j + 1 + side}\n"
        f"f {i * side + j + 2} {i * side + j + 2 + side} {i * side + j + 1 + side}"
        for i in range(side - 1) for j in range(side - 1)
    ]  # fmt: skip
    return "\n".join(points + faces) + "\n"


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("none.obj", None, "does not exist"),
        ("empty.obj", "", "has no triangles; export the robot as a mesh"),
        ("cut.obj", "v 0 0 0\nv 1 0 0\nf 1 2 9\n", "cannot be read as a mesh"),
        ("cut.glb", "glTF", "cannot be read as a mesh"),
        ("mm.obj", "v 0 0 0\nv 457 0 0\nv 0 338 0\nf 1 2 3\n", "457 x 338 x 0 m .* scale it"),
        ("nan.obj", "v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "has no triangles"),
        ("fine.obj", _grid(102), rf"20402 triangles.* to {MOST_FACES} or less"),
        ("aqua.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "rename the file"),
        ("my robot.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "rename the file"),
    ],
)
def test_what_is_no_robot_is_refused(tmp_path: Path, name: str, content: str | None, words: str):
    path = tmp_path / name
    if content is not None:
        path.write_text(content)
    with pytest.raises(ConfigError, match=words):
        robot_model(str(path))


def test_data_sets_and_flights_have_its_class(obj: Path, tmp_path: Path) -> None:
    folder = tmp_path / "set"
    arguments = ["simulate", "--dataset", str(folder), "--count", "2", "--val", "0"]
    assert main([*arguments, "--occupied", "1", "--robot-model", str(obj)]) == 0
    assert open_dataset(folder).names == ("keel",)
    with (folder / "meta.csv").open(encoding="utf-8") as file:
        assert {row["robot_id"][:5] for row in csv.DictReader(file)} == {"keel_"}
    bag = tmp_path / "flight"
    arguments = ["simulate", "-o", str(bag), "--duration", "1", "--rate", "1", "--no-images"]
    assert main([*arguments, "--robots", "2", "--robot-model", f"{obj},aqua"]) == 0
