/* SPDX-License-Identifier: MIT */
/**
 * `auto`: picks the shading order and the light lists by measuring them on the scene at hand. Knows nothing of the GPU: it is asked for
 * a choice before each frame, is told the time of each frame later, and decides.
 *
 * Candidates take turns, so that a moving camera is fair to all. Each gets ROUNDS frames, of which the first is not counted (pipelines
 * are made in it); one that takes more than DROP_FACTOR times the best so far gets no more turns. The least median wins. With both
 * `auto` the order is chosen first, with the lists that are likely good, then the lists. A decision falls within 60 frames.
 */
#ifndef FNL_RENDER_CHOOSER_H
#define FNL_RENDER_CHOOSER_H

#include "base/base.h"
#include "base/maths.h"
#include "fanal/renderer.h"

enum { CHOOSER_ROUNDS = 4, CHOOSER_CANDIDATES = 9, CHOOSER_PENDING = 8, CHOOSER_MEMORY = 256 };
#define CHOOSER_DROP_FACTOR 2.0

struct choice {
    fnl_shading shading;
    fnl_light_lists lists;
};

/** What a choice depends on. */
struct choice_case {
    struct choice asked; /* one of them, or both, is auto */
    uint64_t scene;      /* hash of what is drawn */
    uint32_t light_count, msaa;
    uint64_t pixel_count;
    bool depth_first; /* deferred: with a prepass */
    vec3 eye, forward;
    float scene_size; /* diagonal of the scene's bounds, metres */
};

/** A decision of an earlier run. */
struct remembered_choice {
    uint64_t key;
    struct choice choice;
    double milliseconds;
};

struct chooser {
    enum { CHOOSER_IDLE, CHOOSER_MEASURING, CHOOSER_DECIDED } state;
    struct choice_case at; /* decided or being decided for */
    struct choice choice;  /* the best known */
    double milliseconds;   /* of the choice; 0: not measured */
    char reason[192];
    /* measuring */
    bool lists_left; /* the lists come after the shading order */
    uint32_t candidate_count, measured_count;
    struct chooser_candidate {
        struct choice choice;
        uint32_t given, got; /* frames asked for, times told */
        bool warm, dropped;
        double times[CHOOSER_ROUNDS];
    } candidates[CHOOSER_CANDIDATES];
    uint32_t frames; /* since the decision began, or fell */
    uint32_t last;   /* candidate of the last pick; CHOOSER_CANDIDATES: none */
    struct chooser_pending {
        uint64_t frame;
        uint32_t candidate;
    } pending[CHOOSER_PENDING];
    uint32_t pending_count;
    uint32_t slow_frames; /* in a row, since the decision */
    /* memory */
    struct remembered_choice memory[CHOOSER_MEMORY];
    uint32_t memory_count;
    bool memory_changed;
};

/**
 * The pair to render the next frame with. `pinned`: nothing is measured; the choice stays, or is the remembered or the likely one.
 */
struct choice chooser_pick(struct chooser *chooser, const struct choice_case *at, bool pinned);
/** The frame of the last pick was submitted under this number, and is timed. */
void chooser_note(struct chooser *chooser, uint64_t frame);
/** Oldest frame whose time is still wanted; 0: none. */
uint64_t chooser_wants(const struct chooser *chooser);
/** Time of that frame; negative: it is not known and never will be. */
void chooser_feed(struct chooser *chooser, double milliseconds);

/** The pair that is likely good, by rules; what pinned frames and the first frame use. */
struct choice chooser_guess(const struct choice_case *at);

/** Text of the memory, one decision a line; returns the length it wants. Parsing skips lines that it does not understand. */
size_t chooser_print(const struct chooser *chooser, char *text, size_t capacity);
void chooser_parse(struct chooser *chooser, const char *text, size_t length);

#endif
