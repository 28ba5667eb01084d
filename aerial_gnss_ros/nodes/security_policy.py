# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Writes SROS2 policies that allow exactly what each node publishes, subscribes to and serves.

python3 -m aerial_gnss_ros.nodes.security_policy --vehicle anafi --namespace drone1 > drone1.xml
python3 -m aerial_gnss_ros.nodes.security_policy --fleet --params fleet.yaml > fleet.xml
python3 -m aerial_gnss_ros.nodes.security_policy --all config/security
"""

from __future__ import annotations

import argparse
import contextlib
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import cast
from xml.sax.saxutils import escape, quoteattr

from aerial_gnss_ros.adapters.feed import Feed, Inputs
from aerial_gnss_ros.adapters.fleet_messages import PARAMETERS, REQUEST
from aerial_gnss_ros.adapters.fleet_overview import DRONES
from aerial_gnss_ros.adapters.overview import OVERVIEW
from aerial_gnss_ros.adapters.parameter_files import read
from aerial_gnss_ros.adapters.results import CURRENT, MAP_DATUM, MARKERS
from aerial_gnss_ros.adapters.sighting_messages import SIGHTINGS
from aerial_gnss_ros.adapters.transforms import TF, TF_STATIC
from aerial_gnss_ros.adapters.vehicles import vehicle_file, vehicle_names
from aerial_gnss_ros.core.config.estimator import EstimatorConfig, estimator_config
from aerial_gnss_ros.core.config.fleet import FleetConfig, fleet_config
from aerial_gnss_ros.core.values.errors import AerialGnssError, ConfigError
from aerial_gnss_ros.detection.config import detector_config
from aerial_gnss_ros.nodes.schemas import DETECTOR, ESTIMATOR, FLEET, SCHEMAS

ENCLAVE = "/aerial_gnss"
"""Enclave path of the shipped policies, above those of the nodes."""

RESULTS = tuple(
    f"robots/*/{kind}"
    for kind in (
        "geo_pose", "fix", "odom", "position_update", "covariance_shared", "covariance_white"
    )
)  # fmt: skip
_EVERY_PUBLISHED = ("/rosout", "/parameter_events", "/diagnostics")
_EVERY_SUBSCRIBED = ("/clock", "/parameter_events")
_PARAMETERS = (
    "describe_parameters", "get_parameter_types", "get_parameters", "get_type_description",
    "list_parameters", "set_parameters", "set_parameters_atomically",
)  # fmt: skip
_LIFECYCLE = (
    "change_state", "get_available_states", "get_available_transitions", "get_state",
    "get_transition_graph",
)  # fmt: skip


def policy(files: Sequence[Path] = (), namespace: str = "/", enclave: str = ENCLAVE) -> str:
    """Return the policy of both nodes as XML.

    Args:
        files: their parameter files, which name the topics.
        namespace: of the nodes.
        enclave: path above those of both nodes.

    Raises:
        ConfigError: a parameter cannot be used.
    """
    values = read(files, SCHEMAS, namespace, lambda _: None)
    detector = detector_config(values[DETECTOR])
    images = (detector.image.full_topic, detector.camera_info.topic)
    published = (
        detector.detections.topic, detector.annotated.full_topic, "~/transition_event"
    )  # fmt: skip
    estimator = estimator_config(values[ESTIMATOR])
    # Only for its topics; it receives no messages.
    feed = Feed(estimator, cast(Inputs, None))
    heard = [one.topic for one in feed.subscriptions]
    heard += [f"{one.topic}_v*" for one in feed.subscriptions if one.versioned]
    in_fleet = bool(estimator.sightings.drone)
    told, asked = ((SIGHTINGS[0], PARAMETERS[0]), (REQUEST[0],)) if in_fleet else ((), ())
    lines = [
        *_enclave(f"{enclave}/{DETECTOR}", namespace, DETECTOR, published, images, _LIFECYCLE),
        *_enclave(
            f"{enclave}/{ESTIMATOR}", namespace, ESTIMATOR,
            (CURRENT, MAP_DATUM, MARKERS[0], OVERVIEW[0], *RESULTS, *_transforms(estimator), *told),
            (*heard, *asked), (),
        ),
    ]  # fmt: skip
    return _whole(lines)


def fleet_policy(files: Sequence[Path] = (), namespace: str = "/", enclave: str = ENCLAVE) -> str:
    """Return the policy of the fleet as XML; any drone's if the parameters name none.

    Args:
        files: its parameter files, which name the drones.
        namespace: of the node.
        enclave: path above its own.

    Raises:
        ConfigError: a parameter cannot be used.
    """
    config = fleet_config(read(files, SCHEMAS, namespace, lambda _: None)[FLEET])
    drones = config.drones or ("/*",)
    published = (
        CURRENT, MAP_DATUM, MARKERS[0], OVERVIEW[0], DRONES[0], *RESULTS, *_transforms(config),
        *(f"{drone}/{REQUEST[0]}" for drone in drones),
    )  # fmt: skip
    heard = [f"{drone}/{topic}" for drone in drones for topic in (SIGHTINGS[0], PARAMETERS[0])]
    return _whole(_enclave(f"{enclave}/{FLEET}", namespace, FLEET, published, heard, ()))


def _whole(lines: Sequence[str]) -> str:
    body = "\n".join(f"    {line}" for line in lines)
    return f'<policy version="0.2.0">\n  <enclaves>\n{body}\n  </enclaves>\n</policy>\n'


def _transforms(config: EstimatorConfig | FleetConfig) -> list[str]:
    wanted = {TF: config.map.publish_tf, TF_STATIC: config.map.publish_earth_tf}
    return [topic for topic, published in wanted.items() if published]


def texts() -> dict[str, str]:
    """Return the shipped files' names with their contents.

    A profile that needs a user's values first, such as a mast's position, has none.
    """
    found = {}
    for name in vehicle_names():
        with contextlib.suppress(ConfigError):
            found[f"{name}.policy.xml"] = document(name)
    found["fleet.policy.xml"] = _document(
        "SROS2 policy of the fleet in the root namespace, for drones in any namespaces.",
        fleet_policy(),
    )
    return found


def document(vehicle: str) -> str:
    """Return the shipped policy of a vehicle profile."""
    return _document(
        f"SROS2 policy of detector and estimator with the vehicle profile {vehicle}, in the root "
        "namespace.",
        policy([vehicle_file(vehicle)]),
    )


def _document(about: str, text: str) -> str:
    """Return a shipped policy with its comment."""
    comment = (
        f"{about} In another one: replace ns. Made by `python3 -m "
        "aerial_gnss_ros.nodes.security_policy`, which also makes that of your own parameters: "
        "see docs/howto/security.md."
    ).replace("--", "- -")
    head = '<?xml version="1.0" encoding="UTF-8"?>'
    return f"{head}\n<!-- {comment} -->\n{text}"


def _enclave(
    path: str,
    namespace: str,
    node: str,
    published: Sequence[str],
    subscribed: Sequence[str],
    services: Sequence[str],
) -> list[str]:
    absolute = "/" + namespace.strip("/")
    rules = [
        *_rule("topics", "publish", (*published, *_EVERY_PUBLISHED)),
        *_rule("topics", "subscribe", (*subscribed, *_EVERY_SUBSCRIBED)),
        *_rule("services", "reply", [f"~/{name}" for name in sorted((*_PARAMETERS, *services))]),
    ]
    return [
        f"<enclave path={quoteattr(path)}>",
        "  <profiles>",
        f"    <profile ns={quoteattr(absolute)} node={quoteattr(node)}>",
        *(f"      {rule}" for rule in rules),
        "    </profile>",
        "  </profiles>",
        "</enclave>",
    ]


def _rule(kind: str, verb: str, names: Iterable[str]) -> list[str]:
    single = kind.removesuffix("s")
    inner = [f"  <{single}>{escape(name)}</{single}>" for name in dict.fromkeys(names)]
    return [f'<{kind} {verb}="ALLOW">', *inner, f"</{kind}>"]


def main(argv: Sequence[str] | None = None) -> int:
    """Write the policy for given parameters, or all shipped ones; return the exit status."""
    parser = argparse.ArgumentParser(prog="security_policy", description=__doc__.splitlines()[0])
    parser.add_argument("--vehicle", help=f"profile: {', '.join(vehicle_names())}, or a file")
    parser.add_argument("--fleet", action="store_true", help="of the fleet, not of a drone")
    parser.add_argument("--params", type=Path, nargs="+", default=[], help="parameter files")
    parser.add_argument("--namespace", default="/", help="of both nodes, such as drone1")
    parser.add_argument("--enclave", default=ENCLAVE, help="above those of both (%(default)s)")
    parser.add_argument("--all", type=Path, metavar="FOLDER", help="write the shipped ones there")
    args = parser.parse_args(argv)
    try:
        if args.all:
            for name, text in texts().items():
                (args.all / name).write_text(text, encoding="utf-8")
            return 0
        files = [vehicle_file(args.vehicle)] if args.vehicle else []
        made = fleet_policy if args.fleet else policy
        sys.stdout.write(made([*files, *args.params], args.namespace, args.enclave))
    except (AerialGnssError, OSError) as error:
        sys.stderr.write(f"security_policy: {error}\n")
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
