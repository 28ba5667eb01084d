# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Isolates ultralytics: no downloads, no telemetry, no files in the home folder."""

from __future__ import annotations

import importlib.util
import os
import shutil
import sys
from pathlib import Path

from aerial_gnss_ros.core.values.errors import ModelError
from aerial_gnss_ros.detection.offline import OFFLINE, QUIET, SETTINGS, settings_folder
from aerial_gnss_ros.resources import install_hint

# Third-party loggers that ultralytics starts by itself if they are installed.
_LOGGERS = ("clearml", "comet", "dvc", "mlflow", "raytune", "tensorboard", "wandb")
_FONTS = ("Arial.ttf", "Arial.Unicode.ttf")


def require_ultralytics(what: str) -> None:
    """Raise ModelError with installation advice if ultralytics is missing.

    Args:
        what: needs it.
    """
    for name in ("torch", "ultralytics"):
        if importlib.util.find_spec(name) is None:
            raise ModelError(f"{what} needs {name}; install it with {install_hint('ultralytics')}.")


def offline_environment(folder: Path) -> dict[str, str]:
    """Return environment variables for a process that imports ultralytics.

    Args:
        folder: for its settings, instead of the user's; made where it is missing.
    """
    fonts = folder / "Ultralytics"
    fonts.mkdir(parents=True, exist_ok=True)
    # Without a font of this name it downloads one, whatever YOLO_OFFLINE says.
    font = _a_font()
    for name in _FONTS:
        if not (fonts / name).exists():
            shutil.copyfile(font, fonts / name)
    return {
        **os.environ,
        SETTINGS: str(folder.resolve()),
        **OFFLINE,
        **dict.fromkeys(QUIET, "true"),  # a training logs its messages separately
        "MPLBACKEND": "Agg",
    }


def go_offline() -> None:
    """Give this process that environment; before anything imports ultralytics."""
    os.environ.update(offline_environment(settings_folder()))


def keep_to_itself(threads: int) -> None:
    """Import ultralytics, disable its reports and loggers, and limit its threads.

    The settings that this changes are those of `offline_environment`'s folder.

    Args:
        threads: of the CPU; 0: its default.
    """
    import ultralytics.models
    from ultralytics import settings

    if threads:
        # A constant that its modules import from each other; select_device gives it to torch.
        for name, module in list(sys.modules.items()):
            if name.startswith(ultralytics.__name__) and hasattr(module, "NUM_THREADS"):
                vars(module)["NUM_THREADS"] = threads
    wanted = {name: False for name in ("sync", *_LOGGERS) if name in settings}
    if any(settings[name] for name in wanted):
        settings.update(wanted)


def _a_font() -> Path:
    import matplotlib as mpl

    return Path(mpl.get_data_path()) / "fonts" / "ttf" / "DejaVuSans.ttf"
