/* SPDX-License-Identifier: MIT */
#include "cave/ranks.h"
#include "cave/hash.h"
#include "interrupt.h"
#include "json_text.h"
#include "print.h"

#include <dlfcn.h>
#include <limits.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#ifndef FANAL_MODULES
#define FANAL_MODULES "../lib/fanal" /* from the folder of the program */
#endif

/* Every message; `size` bytes follow in one of their own. */
enum message_kind { MESSAGE_GREETING, MESSAGE_WELCOME, MESSAGE_MOMENT, MESSAGE_RENDERED, MESSAGE_SWAP, MESSAGE_WRITTEN, MESSAGE_SETTLED, MESSAGE_OVER, MESSAGE_FAILED };
struct message {
    uint32_t version, kind;
    uint32_t good, padding;
    uint64_t frame, hash, size;
    double milliseconds, ev;
    char host[64];
    struct cave_greeting greeting;
    struct cave_moment moment;
};
enum { MESSAGE_VERSION = 0x43415645 };

static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec * 1e3 + (double)t.tv_nsec * 1e-6;
}

/* ---- the module ---- */

static const struct cave_transport *open_module(void) {
    /* Beside the program, as it is built, or where it is installed. */
    static const char *const folders[] = {"", FANAL_MODULES "/"};
    char program[PATH_MAX], path[PATH_MAX + 64];
    const ssize_t length = readlink("/proc/self/exe", program, sizeof program - 1);
    program[length > 0 ? length : 0] = 0;
    const char *slash = strrchr(program, '/');
    for (size_t i = 0; slash && i < sizeof folders / sizeof *folders; i++) {
        snprintf(path, sizeof path, "%.*s/%sfanal_mpi.so", (int)(slash - program), program, folders[i]);
        if (access(path, R_OK) != 0) continue;
        void *module = dlopen(path, RTLD_NOW | RTLD_GLOBAL); /* global: MPI opens modules of its own, which use it */
        void *symbol = module ? dlsym(module, "fanal_mpi_transport") : NULL;
        if (!symbol) {
            fprintf(stderr, "fanal: error: %s: cannot be loaded: %s\n", path, dlerror());
            return NULL;
        }
        cave_transport_find *find;
        memcpy(&find, &symbol, sizeof find);
        const struct cave_transport *transport = find();
        if (transport->version == CAVE_TRANSPORT_VERSION) return transport;
        fprintf(stderr, "fanal: error: %s: is of another version of fanal\n", path);
        return NULL;
    }
    fputs("fanal: error: mpirun has started several ranks, but this fanal was built without MPI: there is no fanal_mpi.so (Debian and Ubuntu: install libopenmpi-dev "
          "and build again)\n",
          stderr);
    return NULL;
}

bool cave_ranks_join(struct cave_ranks *r, double timeout, bool quiet) {
    *r = (struct cave_ranks){.count = 1, .timeout = timeout, .quiet = quiet};
    if (!getenv("OMPI_COMM_WORLD_SIZE") && !getenv("PMIX_RANK")) return true;
    const struct cave_transport *transport = open_module();
    if (!transport) return false;
    if (!transport->begin(&r->rank, &r->count)) {
        fputs("fanal: error: MPI does not start\n", stderr);
        return false;
    }
    r->transport = transport;
    if (r->count <= CAVE_RANKS) {
        interrupt_catch(true);
        return true;
    }
    if (r->rank == 0) fprintf(stderr, "fanal: error: %u ranks are too many; a CAVE has %d at most\n", r->count, CAVE_RANKS);
    transport->end();
    return false;
}

/* ---- messages ---- */

__attribute__((format(printf, 2, 3))) static void complain(const struct cave_ranks *r, const char *format, ...) {
    char text[1024];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    fprintf(stderr, "fanal: error: rank %u: %s\n", r->rank, text); /* at once, as several ranks may print */
}

static struct message make(const struct cave_ranks *r, enum message_kind kind, bool good) {
    struct message m;
    memset(&m, 0, sizeof m);
    m.version = MESSAGE_VERSION;
    m.kind = kind;
    m.good = good;
    m.frame = r->frame;
    gethostname(m.host, sizeof m.host - 1);
    return m;
}

static void send_all(const struct cave_ranks *r, const struct message *m) {
    for (uint32_t i = 1; i < r->count; i++) r->transport->send(i, m, sizeof *m);
}

/* Waits for a message. False after one line: it does not come, or this process was told to end. Others wait longer for rank 0 than it waits for them, so that
 * it can tell all of them who is missing. */
static bool await(struct cave_ranks *r, uint32_t from) {
    const double begun = now(), limit = r->timeout * 1e3 * (r->rank == 0 ? 1 : 2) + (r->rank == 0 ? 0 : 1000);
    bool told = r->frame == 0 || r->rank > 0 || r->quiet; /* the first frame makes pipelines */
    while (!r->transport->arrived(from)) {
        const double waited = now() - begun;
        if (interrupt_seen()) {
            complain(r, "told to end by a signal in frame %llu: another rank was lost, or somebody ended the run. Nothing of this frame is written", (unsigned long long)r->frame);
            r->state = CAVE_RANKS_INTERRUPTED;
            return false;
        }
        if (waited > limit) {
            complain(r, "rank %u has not answered for %.3g s in frame %llu (--timeout): it is lost, and all end. Nothing of this frame is written", from, waited / 1e3,
                     (unsigned long long)r->frame);
            r->state = CAVE_RANKS_LOST;
            return false;
        }
        if (waited > 1000 && !told) {
            fprintf(stderr, "fanal: warning: rank %u is late in frame %llu: all wait for it\n", from, (unsigned long long)r->frame);
            told = true;
        }
        nanosleep(&(struct timespec){.tv_nsec = waited < 5 ? 50000 : 500000}, NULL);
    }
    return true;
}

static bool receive(struct cave_ranks *r, uint32_t from, enum message_kind wanted, struct message *out) {
    if (!await(r, from)) return false;
    if (r->transport->receive(from, out, sizeof *out) && out->version == MESSAGE_VERSION && (out->kind == wanted || out->kind == MESSAGE_OVER || out->kind == MESSAGE_FAILED))
        return true;
    complain(r, "rank %u says something else than expected: it is another version of fanal", from);
    r->state = CAVE_RANKS_LOST;
    return false;
}

/* Rank 0 ends the run for all. */
static bool fail_all(struct cave_ranks *r) {
    const struct message m = make(r, MESSAGE_FAILED, false);
    if (r->state == CAVE_RANKS_RUN) r->state = CAVE_RANKS_FAILED;
    send_all(r, &m);
    return false;
}

/* What rank 0 says to go on; false: it says that the run has ended. */
static bool await_word(struct cave_ranks *r, enum message_kind wanted, struct message *m) {
    if (!receive(r, 0, wanted, m)) return false;
    if (m->kind == wanted) return true;
    r->state = m->kind == MESSAGE_OVER ? CAVE_RANKS_OVER : CAVE_RANKS_FAILED;
    return false;
}

bool cave_ranks_send(struct cave_ranks *r, const void *bytes, size_t size) { return r->transport->send(0, bytes, size); }

bool cave_ranks_receive(struct cave_ranks *r, uint32_t from, void *bytes, size_t size) { return await(r, from) && r->transport->receive(from, bytes, size); }

/* ---- the start ---- */

static const char *difference(const struct cave_greeting *a, const struct cave_greeting *b) {
    if (a->program != b->program) return "is another version of fanal";
    if (a->displays != b->displays) return "has other displays";
    if (a->settings != b->settings) return "was given other options";
    if (a->scene != b->scene) return "has another scene file";
    return NULL;
}

bool cave_ranks_greet(struct cave_ranks *r, const struct cave_greeting *own, double *ev) {
    struct message m = make(r, MESSAGE_GREETING, own->good);
    if (own->has_ev) *ev = own->ev;
    if (!r->transport) return own->good;
    m.greeting = *own;
    if (r->rank > 0) {
        if (!r->transport->send(0, &m, sizeof m) || !await_word(r, MESSAGE_WELCOME, &m)) return false;
        *ev = m.ev;
        return true;
    }
    bool good = own->good;
    for (uint32_t i = 1; i < r->count; i++) {
        struct message other;
        if (!receive(r, i, MESSAGE_GREETING, &other)) return fail_all(r);
        const char *problem = !own->good || !other.greeting.good ? NULL : difference(own, &other.greeting);
        if (problem) complain(r, "rank %u on %s %s than rank 0 on %s: all end", i, other.host, problem, m.host);
        if (!other.greeting.good) complain(r, "rank %u on %s could not begin: all end", i, other.host);
        if (other.greeting.has_ev) *ev = other.greeting.ev;
        good = good && !problem && other.greeting.good;
    }
    if (!good) return fail_all(r);
    m = make(r, MESSAGE_WELCOME, true);
    m.ev = *ev;
    send_all(r, &m);
    return true;
}

/* ---- a frame ---- */

bool cave_ranks_begin(struct cave_ranks *r, const struct cave_moment *own, struct cave_moment *out) {
    r->begun = now();
    if (r->rank > 0) {
        struct message m;
        if (!await_word(r, MESSAGE_MOMENT, &m)) return false;
        r->begun = now();
        r->frame = m.moment.frame;
        *out = m.moment;
        return true;
    }
    struct message m = make(r, own ? MESSAGE_MOMENT : MESSAGE_OVER, true);
    if (own) {
        r->frame = own->frame;
        *out = m.moment = *own;
    } else {
        r->state = CAVE_RANKS_OVER;
    }
    if (r->transport) send_all(r, &m);
    r->expected_hash = own ? cave_moment_hash(own) : 0;
    return own != NULL;
}

/* What a rank has rendered, on rank 0. */
static bool take_rendered(struct cave_ranks *r, uint32_t from, json_t *reports) {
    struct message m;
    if (!receive(r, from, MESSAGE_RENDERED, &m)) return false;
    char *text = m.size > 0 && m.size < 1 << 24 ? malloc(m.size + 1) : NULL;
    if (m.size > 0 && (!text || !cave_ranks_receive(r, from, text, m.size))) {
        free(text);
        return false;
    }
    json_t *report = text ? json_loadb(text, m.size, 0, NULL) : NULL;
    if (report) json_array_extend(reports, report);
    json_decref(report);
    free(text);
    r->milliseconds[from] = m.milliseconds;
    if (!m.good) {
        complain(r, "rank %u on %s could not render frame %llu: all end", from, m.host, (unsigned long long)r->frame);
        return false;
    }
    if (m.frame == r->frame && m.hash == r->expected_hash) return true;
    complain(r, "at the swap rank %u on %s has frame %llu with pose %016llx, rank 0 frame %llu with %016llx: all end", from, m.host, (unsigned long long)m.frame,
             (unsigned long long)m.hash, (unsigned long long)r->frame, (unsigned long long)r->expected_hash);
    return false;
}

bool cave_ranks_swap(struct cave_ranks *r, bool good, const struct cave_moment *rendered, json_t *own, json_t *reports) {
    const double took = now() - r->begun;
    if (r->rank == 0) {
        r->milliseconds[0] = took;
        json_array_extend(reports, own);
        json_decref(own);
        for (uint32_t i = 1; i < r->count; i++) /* all, so that a failure names each that has failed */
            if (!take_rendered(r, i, reports)) {
                good = false;
                if (r->state != CAVE_RANKS_RUN) break;
            }
        r->waited = now() - r->begun - took;
        if (!r->transport) return good;
        if (!good) return fail_all(r);
        const struct message m = make(r, MESSAGE_SWAP, true);
        send_all(r, &m);
        return true;
    }
    struct message m = make(r, MESSAGE_RENDERED, good);
    char *text = json_text_write(own, JSON_COMPACT);
    m.hash = cave_moment_hash(rendered);
    m.frame = rendered->frame;
    m.milliseconds = took;
    m.size = text ? strlen(text) : 0;
    json_decref(own);
    const bool sent = r->transport->send(0, &m, sizeof m) && (m.size == 0 || r->transport->send(0, text, m.size));
    free(text);
    return sent && await_word(r, MESSAGE_SWAP, &m) && good;
}

bool cave_ranks_settle(struct cave_ranks *r, bool good) {
    struct message m = make(r, MESSAGE_WRITTEN, good);
    if (!r->transport) return good;
    if (r->rank > 0) return r->transport->send(0, &m, sizeof m) && await_word(r, MESSAGE_SETTLED, &m) && good;
    for (uint32_t i = 1; i < r->count; i++) {
        struct message other;
        if (!receive(r, i, MESSAGE_WRITTEN, &other)) return fail_all(r);
        if (!other.good) complain(r, "rank %u on %s could not write frame %llu: all end", i, other.host, (unsigned long long)r->frame);
        good = good && other.good;
    }
    if (!good) return fail_all(r);
    m = make(r, MESSAGE_SETTLED, true);
    send_all(r, &m);
    return true;
}

void cave_ranks_leave(struct cave_ranks *r) {
    if (!r->transport) return;
    fflush(stdout);
    if (r->state == CAVE_RANKS_LOST) {
        nanosleep(&(struct timespec){.tv_nsec = 200000000}, NULL); /* what was told to the others is on its way */
        r->transport->abort(2);
    } else if (r->state != CAVE_RANKS_INTERRUPTED) {
        r->transport->end();
    }
    r->transport = NULL;
}
