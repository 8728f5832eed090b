/* SPDX-License-Identifier: MIT */
/** The values of public enums, as tables of options need them. */
#ifndef FNL_BASE_VALUES_H
#define FNL_BASE_VALUES_H

#include "base/base.h"
#include "fanal/values.h"

/** How many values an enum has: 0 .. count - 1. */
uint32_t value_count(fnl_enum type);
/** Its name in C, such as "fnl_shading". */
const char *value_type(fnl_enum type);

#endif
