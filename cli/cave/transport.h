/* SPDX-License-Identifier: MIT */
/**
 * How bytes get from rank to rank: what the module fanal_mpi.so offers, which is opened only where a launcher has started several ranks. So `fanal` itself
 * neither links MPI nor needs it.
 */
#ifndef FNL_CLI_CAVE_TRANSPORT_H
#define FNL_CLI_CAVE_TRANSPORT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { CAVE_TRANSPORT_VERSION = 1 };

struct cave_transport {
    uint32_t version;
    /** Joins the others. */
    bool (*begin)(uint32_t *rank, uint32_t *count);
    /** Starts to send; the bytes are copied. Messages of one rank to another arrive in their order. */
    bool (*send)(uint32_t to, const void *bytes, size_t size);
    /** Whether a message of this rank is there. */
    bool (*arrived)(uint32_t from);
    /** Takes the next message of this rank, which has `size` bytes; waits for it. */
    bool (*receive)(uint32_t from, void *bytes, size_t size);
    /** Waits until all that was sent has gone, and leaves. */
    void (*end)(void);
    /** Ends all ranks at once. */
    void (*abort)(int status);
};

/** The module's only symbol, "fanal_mpi_transport", is one of these. */
typedef const struct cave_transport *cave_transport_find(void);

#endif
