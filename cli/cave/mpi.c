/* SPDX-License-Identifier: MIT */
/* fanal_mpi.so: ranks by MPI. */
#include "cave/transport.h"

#include <mpi.h>
#include <stdlib.h>
#include <string.h>

enum { TAG = 7, PIECE = 1 << 30 }; /* MPI counts bytes with an int */

/* A message on its way. */
struct sending {
    struct sending *next;
    MPI_Request request;
    char bytes[];
};
static struct sending *sendings;

static void forget_sent(bool waits) {
    for (struct sending **place = &sendings; *place;) {
        struct sending *s = *place;
        int done = 1;
        if (waits)
            MPI_Wait(&s->request, MPI_STATUS_IGNORE);
        else
            MPI_Test(&s->request, &done, MPI_STATUS_IGNORE);
        if (!done) {
            place = &s->next;
            continue;
        }
        *place = s->next;
        free(s);
    }
}

static bool begin(uint32_t *rank, uint32_t *count) {
    int level, own, all;
    if (MPI_Init_thread(NULL, NULL, MPI_THREAD_FUNNELED, &level) != MPI_SUCCESS || level < MPI_THREAD_FUNNELED) return false;
    if (MPI_Comm_rank(MPI_COMM_WORLD, &own) != MPI_SUCCESS || MPI_Comm_size(MPI_COMM_WORLD, &all) != MPI_SUCCESS) return false;
    *rank = (uint32_t)own;
    *count = (uint32_t)all;
    return true;
}

static bool send(uint32_t to, const void *bytes, size_t size) {
    forget_sent(false);
    for (size_t sent = 0; sent < size;) {
        const size_t piece = size - sent < PIECE ? size - sent : PIECE;
        struct sending *s = malloc(sizeof *s + piece);
        if (!s) return false;
        memcpy(s->bytes, (const char *)bytes + sent, piece);
        if (MPI_Isend(s->bytes, (int)piece, MPI_BYTE, (int)to, TAG, MPI_COMM_WORLD, &s->request) != MPI_SUCCESS) {
            free(s);
            return false;
        }
        s->next = sendings;
        sendings = s;
        sent += piece;
    }
    return true;
}

static bool arrived(uint32_t from) {
    int there = 0;
    forget_sent(false);
    return MPI_Iprobe((int)from, TAG, MPI_COMM_WORLD, &there, MPI_STATUS_IGNORE) == MPI_SUCCESS && there;
}

static bool receive(uint32_t from, void *bytes, size_t size) {
    for (size_t got = 0; got < size;) {
        const size_t piece = size - got < PIECE ? size - got : PIECE;
        if (MPI_Recv((char *)bytes + got, (int)piece, MPI_BYTE, (int)from, TAG, MPI_COMM_WORLD, MPI_STATUS_IGNORE) != MPI_SUCCESS) return false;
        got += piece;
    }
    return true;
}

static void end(void) {
    forget_sent(true);
    MPI_Finalize();
}

static void stop_all(int status) { MPI_Abort(MPI_COMM_WORLD, status); }

const struct cave_transport *fanal_mpi_transport(void);
__attribute__((visibility("default"))) const struct cave_transport *fanal_mpi_transport(void) {
    static const struct cave_transport transport = {CAVE_TRANSPORT_VERSION, begin, send, arrived, receive, end, stop_all};
    return &transport;
}
