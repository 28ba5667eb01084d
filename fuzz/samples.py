# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Good files of every kind, which cases then damage, and words that have hurt parsers before."""

from __future__ import annotations

import functools

from aerial_gnss_ros.resources import config_path

YAML_WORDS = (
    "2001-13-45", "!!int abc", "!!float x", "!!python/object:os.system x", "&a [1, 2]", "*a",
    "&a [*a, *a]", "[" * 3000, "{" * 500, "- " * 400, "? x", "<<: *a", "%YAML 9.9", "---", "...",
    "|", ">", "'", '"', "\t", "~", "null", "yes", ".nan", ".inf", "-.inf", "1e400", "0x1F", "0o17",
    "1_000", "12:30:45", "9" * 400, "!!binary x", "!!timestamp 1", "!!set {a}", "!!omap [a: 1]",
    "\u2028", "\x00", "\ufeff", "robots: {a: {class: aqua, start: [1, 2]}}", "estimator:",
    "ros__parameters:", "/**:", "fix: 1", "fix.topic: x", "source: constant", "type: range", "[]",
    "{}", "a: &x [l, l, l]\nb: &y [*x, *x, *x]\nc: &z [*y, *y, *y]\nd: [*z, *z, *z]",
    "a: &a\n  b: *a", "true", "1.5", "-1", "robots.x.start: [91, 0]",
)  # fmt: skip
CSV_WORDS = (
    "", "nan", "inf", "-inf", "1e999", "-1", "0", "9" * 400, '"', '""', "a", "1,2", "\x00", "=1+1",
    "True", "false", "0x10", "1_000", "１２", "²", "12:30:45", "1h 2m 3s", "99999999999h 1m 2s",
    "9999-12-31 23:59:59.999999", "2022-02-30", "0001-01-01T00:00:00+23:59",
    "9999-12-31T23:59:59-23:59", "12/31/9999 11:59:59.99 PM", "1e308", "-1e308", "sep=;",
    "x" * 200_000, "OSD.latitude", "OSD.height [ft]", "GIMBAL.yaw", "isVideo", "\u2028", "-", "+",
    ".", "1.2.3",
)  # fmt: skip
SRT_WORDS = (
    "", "nan", "-1", "9" * 400, "00:00:00,000 --> 00:00:00,033", f"{'9' * 400}:00:00,000 --> 1",
    "99:99:99,999 -->", "-00:00:01,000 --> 0", "GPS (181, 91, 3)", "GPS(0,0,0)", "[latitude: 91]",
    "[longtitude: -181]", "[rel_alt: -1.5 abs_alt: 2]", "H -1.50m", "BAROMETER:-4.2",
    "dzoom_ratio: 0", "focal_len: 1e9", "F.PRY (1°, 2°, 3°)", "[gb_yaw: 1 gb_pitch: 2 gb_roll: 3]",
    "\x00", "<font size=\"36\">", "１２", "1" + "0" * 320, "-->", "x" * 200_000, "²", "\u2028",
)  # fmt: skip
JSON_WORDS = (
    "NaN", "Infinity", "-Infinity", "1e999", "null", "true", "[]", "{}", "9" * 5000, "-1", '"a"',
    "[" * 3000, '{"a":' * 500, '"\\ud800"', '"\\u0000"', "\x00", '"' + "a" * 5000 + '"', "0",
    '"version": 2', '"robots": {}', '"numbers": []', '"class": 1', '"sigma_m": -1',
    '"latitude_deg": 91', '"last_seen_ns": 1.5', '"__"', '"/"', '"a b"',
)  # fmt: skip
CSV = (
    """sep=,
CUSTOM.date [local],CUSTOM.updateTime [local],OSD.flyTime,OSD.flyTime [s],OSD.latitude,\
OSD.longitude,OSD.height [ft],OSD.altitude [ft],OSD.pitch,OSD.roll,OSD.yaw,OSD.yaw [360],\
GIMBAL.mode,GIMBAL.pitch,GIMBAL.roll,GIMBAL.yaw,GIMBAL.yaw [360],CAMERA.isVideo
7/10/2022,7:59:42.21 PM,0m 1.0s,1.0,13.2,-59.6,100.0,140.0,0,0,-90,270,Follow,-30,0,-135,225,
7/10/2022,7:59:42.31 PM,0m 1.1s,1.1,13.2,-59.6,100.0,140.0,0,0,-90,270,Follow,-30,0,-135,225,True
7/10/2022,7:59:42.41 PM,0m 1.2s,1.2,13.2,-59.6,100.0,140.0,0,0,-90,270,Follow,-30,0,-135,225,True
""",
    """CUSTOM.dateTime,OSD.flyTime,OSD.latitude,OSD.longitude,OSD.height,OSD.altitude,\
OSD.pitch,OSD.roll,OSD.yaw,GIMBAL.mode,GIMBAL.pitch,GIMBAL.roll,GIMBAL.yaw,CAMERA.isVideo
2022-07-10T19:59:42.210Z,1.0,13.2,-59.6,30.48,42.7,0,0,-90,YawFollow,-30,0,-135,false
2022-07-10T19:59:42.310Z,1.1,13.2,-59.6,30.48,42.7,0,0,-90,YawFollow,-30,0,-135,true
2022-07-10T19:59:42.410Z,1.2,13.2,-59.6,30.48,42.7,0,0,-90,YawFollow,-30,0,-135,true
""",
    """time(millisecond),datetime(utc),latitude,longitude,height_above_takeoff(feet),\
altitude_above_seaLevel(feet),speed(mph), compass_heading(degrees), pitch(degrees), roll(degrees),\
isPhoto,isVideo,gimbal_heading(degrees),gimbal_pitch(degrees),gimbal_roll(degrees)
1000,2022-07-10 19:59:42,13.2,-59.6,100,140,0,270,0,0,0,0,225,-30,0
1100,2022-07-10 19:59:42,13.2,-59.6,100,140,0,270,0,0,0,1,225,-30,0
1200,2022-07-10 19:59:43,13.2,-59.6,100,140,0,270,0,0,0,1,225,-30,0
""",
    """OSD.latitude,OSD.longitude,OSD.height [m],OSD.pitch,OSD.yaw,GIMBAL.pitch,GIMBAL.yaw
13.25,-59.5,20,10,90,-90,85
13.25,-59.5,21,0,180,-30,175
13.25,-59.5,22,0,200,-30,195
""",
)
_SRT_TEXTS = (
    "GPS(-59.6,13.2,15) BAROMETER:30.5",
    "F/2.8, SS 500, ISO 100, EV 0, GPS (-59.6, 13.2, 15), D 3.0m, H 30.48m, H.S 0.0m/s",
    "RTK (-59.6, 13.2, 20), H 30.5m, F.PRY (1.0°, 2.0°, 3.0°), G.PRY (-30.0°, 0.0°, -135.0°)",
    """[iso : 100] [latitude: 13.2] [longtitude: -59.6] [altitude: 30.5]
[Drone: Yaw:1.0, Pitch:2.0, Roll:3.0] dzoom_ratio: 10000""",
    """[focal_len: 24.00] [dzoom_ratio: 1.00], [latitude: 13.2] [longitude: -59.6]
[rel_alt: 30.500 abs_alt: 42.700] [gb_yaw: -135.0 gb_pitch: -30.0 gb_roll: 0.0]""",
)
SRT = tuple(
    "".join(
        f"{i + 1}\n00:00:0{i},000 --> 00:00:0{i + 1},000\n"
        f'<font size="28">FrameCnt: {i}, 2022-07-10 19:59:4{i}.210\n{text}</font>\n\n'
        for i in range(3)
    )
    for text in _SRT_TEXTS
)
CAMERA = (
    """image_width: 1280
image_height: 720
camera_name: front
distortion_model: plumb_bob
camera_matrix:
  rows: 3
  cols: 3
  data: [850.0, 0.0, 643.0, 0.0, 850.0, 357.0, 0.0, 0.0, 1.0]
distortion_coefficients:
  rows: 1
  cols: 5
  data: [-0.045, 0.018, 0.0004, -0.0003, -0.004]
""",
    """header: {stamp: {sec: 1, nanosec: 0}, frame_id: camera}
height: 720
width: 1280
distortion_model: rational_polynomial
d: [0.1, -0.05, 0.0, 0.0, 0.01, 0.1, -0.05, 0.0]
k: [850.0, 0.0, 643.0, 0.0, 850.0, 357.0, 0.0, 0.0, 1.0]
---
""",
    """width: 1280
height: 720
distortion_model: equidistant
d: [0.01, -0.005, 0.001, 0.0]
k: [600.0, 0.0, 640.0, 0.0, 600.0, 360.0, 0.0, 0.0, 1.0]
""",
)
STATE = """{
  "numbers": {"aqua": 2, "boat": 1},
  "robots": {
    "aqua_1": {"class": "aqua", "last_seen_ns": 1735689610000000000, "latitude_deg": 13.1939,
      "longitude_deg": -59.6415, "sigma_m": 1.2},
    "leader": {"class": "boat", "last_seen_ns": 1735689620000000000, "latitude_deg": 13.194,
      "longitude_deg": -59.6416, "sigma_m": 0.8}
  },
  "version": 1
}
"""
POSITIONS = """stamp_ns,robot_id,class_id,latitude_deg,longitude_deg,altitude_m,var_east_m2,\
cov_east_north_m2,var_north_m2,velocity_east_mps,velocity_north_mps,state
1735689610000000000,aqua_1,aqua,13.1939000000,-59.6415000000,-40.0000,1.44,0.01,1.44,0.1,0.0,confirmed
1735689610100000000,aqua_1,aqua,13.1939100000,-59.6415000000,nan,1.44,0.01,1.44,0.1,0.0,coasting
"""
DRONES = """\
stamp_ns,drone,agreement,shared_robots,offset_east_m,offset_north_m,sigma_east_m,sigma_north_m,\
disagrees,fault,latitude_deg,longitude_deg,sees
1735689600000000000,a,nan,0,0.0,0.0,1.2,1.2,0,,13.193973650,-59.641450574,
1735689600500000000,a,1.02,2,0.5,-0.25,0.3,0.3,1,compass,13.193973651,-59.641450575,aqua_1 aqua_2
1735689600500000000,b,0.98,2,-0.5,0.25,0.3,0.3,0,,13.193823063,-59.641541387,aqua_1
"""
REJECTED = """stamp_ns,reason,u_px,v_px
1735689610000000000,above_horizon,640.000,12.000
1735689610100000000,low_score,640.000,12.000
"""
NAMES = ("{0: 'aqua', 1: 'boat'}", '{"0": "aqua"}', "['aqua', 'boat']", "{0: 'aqua_red'}")


@functools.cache
def parameters() -> tuple[str, ...]:
    """Return parameter files: the shipped profiles, and short ones of one's own."""
    profiles = sorted(config_path("vehicles").glob("*.yaml"))
    texts = [path.read_text(encoding="utf-8") for path in profiles]
    return (
        *("\n".join(line.partition(" #")[0] for line in text.split("\n")) for text in texts),
        "fix:\n  topic: f\n  max_gap: 2.5\ntracks: {max_speed: 1.5}\nnoise: {set: rtk}\n",
        """/drone1/estimator:
  ros__parameters:
    use_sim_time: true
    robots:
      leader: {class: aqua, start: [13.19394, -59.64151]}
/**/detector:
  ros__parameters: {model: a.onnx, image: {topic: x}}
""",
    )
