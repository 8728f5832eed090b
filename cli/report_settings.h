/* SPDX-License-Identifier: MIT */
#ifndef FNL_CLI_REPORT_SETTINGS_H
#define FNL_CLI_REPORT_SETTINGS_H

#include "render.h"

#include <jansson.h>

/** Every option of `fanal render` by its name, - as _, with its value: the default where it was not given, null where that depends on the scene. */
json_t *report_settings(const struct render_options *options);

#endif
