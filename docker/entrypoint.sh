#!/bin/bash
# Sources ROS, then becomes `aerial-gnss`, so that signals reach it.
set -e
. "/opt/ros/${ROS_DISTRO}/setup.bash"
export PATH="/opt/aerial_gnss/bin:${PATH}"
exec aerial-gnss "$@"
