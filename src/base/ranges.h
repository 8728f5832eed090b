/* SPDX-License-Identifier: MIT */
/** Which parts of a pool are taken: runs of whole numbers that come and go. */
#ifndef FNL_BASE_RANGES_H
#define FNL_BASE_RANGES_H

#include "base/base.h"

#define RANGES_NONE UINT32_MAX

struct range {
    uint32_t first, count;
};

/** All zero: nothing is taken. Free with ranges_finish. */
struct ranges {
    ARRAY(struct range) gaps; /* free runs below `end`, ascending, none beside another or empty */
    uint32_t end;             /* everything from here on is free */
};

void ranges_finish(const fnl_host *host, struct ranges *ranges);
/** Takes the lowest free run of `count` (> 0) numbers; RANGES_NONE where it would end above 2^32 - 2. Time: linear in the gaps. */
uint32_t ranges_take(struct ranges *ranges, uint32_t count);
/** Gives a taken run, or a part of one, back. If there is no memory to note it the run stays taken. */
void ranges_give(const fnl_host *host, struct ranges *ranges, uint32_t first, uint32_t count);

#endif
