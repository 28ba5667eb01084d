# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Runs the rosidl generators: from .msg files to C, C++ and Python sources."""

from __future__ import annotations

import json
import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import rosidl_generator_c
from rosidl_adapter.msg import convert_msg_to_idl
from rosidl_generator_py.generate_py_impl import generate_py
from rosidl_generator_type_description import generate_type_hash
from rosidl_typesupport_fastrtps_c import generate_typesupport_fastrtps_c
from rosidl_typesupport_introspection_c import generate_c as generate_introspection_c

from build_messages import dispatch

# Packages whose types the message texts mention; their type descriptions enter the type hashes.
DEPENDENCIES = ("builtin_interfaces", "std_msgs", "geometry_msgs")
# Fast DDS needs both: the first to serialise, the second to announce the type's description.
TYPE_SUPPORTS = ("rosidl_typesupport_fastrtps_c", "rosidl_typesupport_introspection_c")


def ros_prefix() -> Path:
    """Return the folder that holds include/, lib/ and share/ of the ROS wheels."""
    return Path(rosidl_generator_c.__file__).resolve().parents[4]


@dataclass(frozen=True)
class Generator:
    """The generators' common arguments for one package.

    Two folders for C, because the introspection generator writes files of the same names as
    the generator of the structures.
    """

    package: str
    names: list[str]
    folder: Path

    @property
    def idl(self) -> Path:
        """Where the .msg and .idl files lie."""
        return self.folder / "idl" / self.package

    @property
    def structures(self) -> Path:
        """Output of the structures, type hashes and serialisation."""
        return self.folder / "structures" / self.package

    @property
    def introspection(self) -> Path:
        """Output of the introspection type support."""
        return self.folder / "introspection" / self.package

    @property
    def python(self) -> Path:
        """Output of the Python modules: the package as it will be installed."""
        return self.folder / "py" / self.package

    def arguments(self, generator: str, output: Path, **more: Any) -> str:
        """Write a generator's argument file and return its path."""
        path = self.folder / f"{self.package}.{generator}.json"
        values = {
            "package_name": self.package,
            "output_dir": str(output),
            "template_dir": str(ros_prefix() / "share" / generator / "resource"),
            "idl_tuples": [f"{self.idl}:msg/{name}.idl" for name in self.names],
            "target_dependencies": [],
            "ros_interface_dependencies": [],
            **more,
        }
        path.write_text(json.dumps(values), encoding="utf-8")
        return str(path)


def generate_all(packages: dict[str, list[Path]], folder: Path) -> Path:
    """Generate the sources of all packages afresh.

    Args:
        packages: The .msg files of each package.
        folder: Is emptied first, so that no message that was taken out lives on.

    Returns:
        The same folder.
    """
    shutil.rmtree(folder, ignore_errors=True)
    for package, files in packages.items():
        generator = Generator(package, [path.stem for path in files], folder)
        _translate(generator, files)
        _generate_structures(generator)
        _generate_type_supports(generator)
        _generate_python(generator)
    return folder


def _translate(generator: Generator, files: list[Path]) -> None:
    """Translate .msg to .idl, the only language that the generators read."""
    folder = generator.idl / "msg"
    folder.mkdir(parents=True)
    for path in files:
        shutil.copy(path, folder)
        convert_msg_to_idl(generator.idl, generator.package, Path("msg") / path.name, folder)


def _generate_structures(generator: Generator) -> None:
    """Generate type hashes and the C structures that carry them."""
    output = generator.structures
    share = ros_prefix() / "share"
    texts = [str(generator.idl / f"msg/{name}.msg") for name in generator.names]
    (output / "msg").mkdir(parents=True)
    generate_type_hash(
        generator.arguments(
            "rosidl_generator_type_description",
            output,
            include_paths=[f"{name}:{share / name}" for name in DEPENDENCIES],
        )
    )
    rosidl_generator_c.generate_c(
        generator.arguments(
            "rosidl_generator_c",
            output,
            type_description_tuples=[
                f"msg/{name}.idl:{output}/msg/{name}.json" for name in generator.names
            ],
            ros_interface_files=texts,
        )
    )


def _generate_type_supports(generator: Generator) -> None:
    """Generate both type supports, what chooses between them, and their visibility headers."""
    output = generator.structures
    generate_typesupport_fastrtps_c(generator.arguments(TYPE_SUPPORTS[0], output))
    generate_introspection_c(generator.arguments(TYPE_SUPPORTS[1], generator.introspection))
    text = dispatch.source(generator.package, generator.names)
    (output / "dispatch.c").write_text(text, encoding="utf-8")
    for owner in ("rosidl_generator_c", *TYPE_SUPPORTS):
        name = f"{owner}__visibility_control.h"
        template = ros_prefix() / "share" / owner / "resource" / f"{name}.in"
        text = template.read_text(encoding="utf-8").replace("@PROJECT_NAME@", generator.package)
        text = text.replace("@PROJECT_NAME_UPPER@", generator.package.upper())
        (output / "msg" / name).write_text(text, encoding="utf-8")


def _generate_python(generator: Generator) -> None:
    """Generate the Python classes and the C functions that convert them."""
    generator.python.mkdir(parents=True)
    (generator.python / "__init__.py").touch()
    arguments = generator.arguments("rosidl_generator_py", generator.python)
    generate_py(arguments, ["rosidl_typesupport_c"])
