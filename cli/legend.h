/* SPDX-License-Identifier: MIT */
#ifndef FNL_CLI_LEGEND_H
#define FNL_CLI_LEGEND_H

#include "fanal/legend.h"

/** What the colours of a debug view mean, on one line without its end: "1 (#472d7b) to 256 and more (#fde725): lights that ..."; "" for none. */
void legend_print(fnl_debug_view view, char *text, size_t capacity);

#endif
