/* SPDX-License-Identifier: MIT */
/**
 * The processes of a CAVE. Rank 0 predicts each moment and sends it to all; every rank renders its views of that moment and says so, with a hash of what it
 * rendered from; when all have said the same, rank 0 lets all go on: the swap. A process alone is rank 0 of 1, and all of this costs nothing.
 */
#ifndef FNL_CLI_CAVE_RANKS_H
#define FNL_CLI_CAVE_RANKS_H

#include "cave/cave.h"
#include "cave/transport.h"

enum cave_ranks_state {
    CAVE_RANKS_RUN,
    CAVE_RANKS_OVER,       /* the last frame is through */
    CAVE_RANKS_FAILED,     /* all ranks know, and leave together */
    CAVE_RANKS_LOST,       /* one does not answer: leaving together would wait forever */
    CAVE_RANKS_INTERRUPTED /* by a signal, which the launcher sends when a rank is lost */
};

struct cave_ranks {
    const struct cave_transport *transport; /* NULL: alone */
    uint32_t rank, count;                   /* alone: 0 and 1 */
    double timeout;
    bool quiet;
    enum cave_ranks_state state;
    uint64_t frame;
    uint64_t expected_hash;                /* of rank 0 */
    double begun, waited;                  /* of the frame, milliseconds; at its swap, for other ranks */
    double milliseconds[CAVE_RANKS];       /* on rank 0: what each took for the frame */
};

/** What has to be the same everywhere, and what comes from one rank alone. */
struct cave_greeting {
    uint64_t program, displays, settings, scene;
    bool good;   /* the rank is ready */
    bool has_ev; /* it has metered */
    double ev;
};

/** Joins, where a launcher (mpirun) has started this process. False with a message: there is no module, or it fails. */
bool cave_ranks_join(struct cave_ranks *ranks, double timeout, bool quiet);
/** Compares with rank 0. `ev`: of the rank that metered. All return the same; rank 0 prints the reason. */
bool cave_ranks_greet(struct cave_ranks *ranks, const struct cave_greeting *own, double *ev);
/** Rank 0 hands the moment out, NULL: it was the last one; the others receive it. False: there is none any more (state). */
bool cave_ranks_begin(struct cave_ranks *ranks, const struct cave_moment *own, struct cave_moment *out);
/**
 * After rendering `rendered`: waits for all. On rank 0 `reports`, an array, gets those of all ranks (each an array, whose elements are appended);
 * the own one is taken over. False: some rank has failed, or is lost, and no picture of this frame may be written.
 */
bool cave_ranks_swap(struct cave_ranks *ranks, bool good, const struct cave_moment *rendered, json_t *own, json_t *reports);
/** After the pictures were written; false: some were not, and those of this frame are to be removed. */
bool cave_ranks_settle(struct cave_ranks *ranks, bool good);
/** Sends bytes to rank 0, and takes them there: pictures, between swap and settle. */
bool cave_ranks_send(struct cave_ranks *ranks, const void *bytes, size_t size);
bool cave_ranks_receive(struct cave_ranks *ranks, uint32_t from, void *bytes, size_t size);
/** Leaves. */
void cave_ranks_leave(struct cave_ranks *ranks);

#endif
