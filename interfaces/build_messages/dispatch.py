# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The C source that hands a middleware the type support that it asks for.

A usual ROS build has one library for each type support and looks it up by file name at run time.
Here everything is in the Python extension itself, so the choice is a comparison of two names.
"""

from __future__ import annotations

HEAD = """\
#include <string.h>
#include "rosidl_runtime_c/message_type_support_struct.h"
#include "rosidl_typesupport_c/identifier.h"
#include "rosidl_typesupport_interface/macros.h"
typedef rosidl_message_type_support_t support_t;
#define HANDLE(kind, name) \\
  ROSIDL_TYPESUPPORT_INTERFACE__MESSAGE_SYMBOL_NAME(kind, PACKAGE, msg, name)
"""

# The type hash and description are the same in both; the first is the one that gives them.
MESSAGE = """
const support_t * HANDLE(rosidl_typesupport_fastrtps_c, NAME)(void);
const support_t * HANDLE(rosidl_typesupport_introspection_c, NAME)(void);
static const support_t * choose_NAME(const support_t * handle, const char * wanted)
{
  if (strcmp(wanted, "rosidl_typesupport_fastrtps_c") == 0) {
    return HANDLE(rosidl_typesupport_fastrtps_c, NAME)();
  }
  if (strcmp(wanted, "rosidl_typesupport_introspection_c") == 0) {
    return HANDLE(rosidl_typesupport_introspection_c, NAME)();
  }
  return strcmp(wanted, handle->typesupport_identifier) == 0 ? handle : NULL;
}
const support_t * HANDLE(rosidl_typesupport_c, NAME)(void)
{
  static support_t handle;
  if (handle.func == NULL) {
    handle = *HANDLE(rosidl_typesupport_fastrtps_c, NAME)();
    handle.typesupport_identifier = rosidl_typesupport_c__typesupport_identifier;
    handle.func = choose_NAME;
  }
  return &handle;
}
"""


def source(package: str, names: list[str]) -> str:
    """Return the C source for all messages of one package."""
    text = HEAD + "".join(MESSAGE.replace("NAME", name) for name in names)
    return text.replace("PACKAGE", package)
