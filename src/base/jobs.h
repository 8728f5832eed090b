/* SPDX-License-Identifier: MIT */
/** Spreading loops over threads: the host's parallel_for, or a pool of our own. */
#ifndef FNL_BASE_JOBS_H
#define FNL_BASE_JOBS_H

#include "base/base.h"

struct jobs;

/** A pool of host->thread_count threads (0: one per processor), or a thin wrapper of the host's parallel_for. */
fnl_result jobs_create(const fnl_host *host, struct jobs **out);
void jobs_destroy(struct jobs **jobs);

/** Number of threads that work at once, the caller included; at least 1. */
uint32_t jobs_thread_count(const struct jobs *jobs);

/**
 * Calls run(context, i) for each i below count and returns when all are done. Which thread takes which index is not
 * fixed: results must not depend on it. The calling thread works too; calls may not nest. Allocates nothing.
 */
void jobs_parallel_for(struct jobs *jobs, uint32_t count, void (*run)(void *context, uint32_t index), void *context);

#endif
