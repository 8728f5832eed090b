/* SPDX-License-Identifier: MIT */
/**
 * `auto`: picks the shading order and the light lists by measuring them on the scene at hand. Knows nothing of the GPU: it is asked for
 * a choice before each frame, is told the time of each frame later, and decides.
 *
 * Each candidate's pipelines are asked for before its first turn, and made in the background. Until they are all there frames take what is
 * likely the best and are not measured, as making pipelines takes time from them; after CHOOSER_PATIENCE such frames the candidates
 * that have theirs are measured all the same, and the others left out.
 *
 * Candidates take turns, so that a moving camera is fair to all. Each gets CHOOSER_ROUNDS frames, of which the first is not counted (pools
 * grow after it, and drivers do things late); one that takes more than DROP_FACTOR times the best so far gets no more turns. The least median
 * wins. With both `auto` the order is chosen first, with the lists that are likely good, then the lists. A decision falls within 60 measured
 * frames. What was measured before the end is kept, for another run to go on from there.
 */
#ifndef FNL_RENDER_CHOOSER_H
#define FNL_RENDER_CHOOSER_H

#include "base/base.h"
#include "base/maths.h"
#include "fanal/renderer.h"

enum {
    CHOOSER_ROUNDS = 4,
    CHOOSER_TIMES = CHOOSER_ROUNDS - 1, /* that count */
    CHOOSER_CANDIDATES = 9,
    CHOOSER_PENDING = 8,
    CHOOSER_MEMORY = 256,
    CHOOSER_TRIALS = 64, /* of candidates that no decision has come of yet */
    CHOOSER_PATIENCE = 1000,
    CHOOSER_ROWS = 2 * CHOOSER_CANDIDATES, /* of chooser_list */
};
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
    bool close;       /* the path may be one whose picture is only close to that of the others */
    bool moves;       /* lights have changed in one of the last frames */
    vec3 eye, forward;
    float scene_size; /* diagonal of the scene's bounds, metres */
};

/** A decision of an earlier run. */
struct remembered_choice {
    uint64_t key;
    struct choice choice;
    double milliseconds;
};

/** What an earlier run measured of a candidate. */
struct remembered_trial {
    uint64_t key;
    struct choice choice;
    uint32_t count;
    double times[CHOOSER_TIMES];
};

/** Pipelines made in the background: how many were asked for so far, and how many of them are there (gpu_pipeline_stats). */
struct chooser_background {
    uint64_t asked, done;
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
        bool asked;      /* for its pipelines, which are there when the background has done `ticket` */
        uint64_t ticket;
        uint32_t turns, given, got; /* frames that it is to get, and got in this run; times known, those of earlier runs among them */
        bool warm, dropped;
        double times[CHOOSER_TIMES];
    } candidates[CHOOSER_CANDIDATES];
    fnl_candidate before[CHOOSER_CANDIDATES]; /* the shading orders, when lists are being chosen or were */
    uint32_t before_count;
    uint32_t frames; /* measured for the decision, or since it fell */
    uint32_t waited; /* frames that were not measured as pipelines were being made */
    uint32_t last;   /* candidate of the last pick; CHOOSER_CANDIDATES: none */
    struct chooser_pending {
        uint64_t frame;
        uint32_t candidate;
        double cpu_milliseconds;
    } pending[CHOOSER_PENDING];
    uint32_t pending_count;
    uint32_t slow_frames; /* in a row, since the decision */
    /* memory */
    struct remembered_choice memory[CHOOSER_MEMORY];
    struct remembered_trial trials[CHOOSER_TRIALS];
    uint32_t memory_count, trial_count;
    bool memory_changed;
};

/**
 * The pair to render the next frame with. Unless the frame `measures` nobody gets a turn: the choice stays, or is the remembered one, the
 * best of what has been measured so far, or the likely one.
 */
struct choice chooser_pick(struct chooser *chooser, const struct choice_case *at, bool measures,
                           struct chooser_background background);
/** After a pick of a frame that measures: whether a candidate wants its pipelines asked for; then say that it was done. */
bool chooser_asks(const struct chooser *chooser, struct choice *out);
/** `ticket` is 0 where they are all there already. Where they are not the frame of the last pick does not count any more. */
void chooser_asked(struct chooser *chooser, uint64_t ticket);
/** The frame of the last pick was submitted under this number, and is timed. Processor and GPU work side by side: the longer time counts. */
void chooser_note(struct chooser *chooser, uint64_t frame, double cpu_milliseconds);
/** Oldest frame whose time is still wanted; 0: none. */
uint64_t chooser_wants(const struct chooser *chooser);
/** Whether the time of a pass, which may stand in a scope ("view 1/gbuffer"), is part of what is compared. */
bool chooser_counts(const struct choice *asked, fnl_pass_role role);
/** Time of that frame's passes, negative: it is not known and never will be; and of those among them that are not compared. */
void chooser_feed(struct chooser *chooser, double gpu_milliseconds, double left_out);

/** What has been or will be measured for the choice, from the first on; returns how many there are. */
uint32_t chooser_list(const struct chooser *chooser, fnl_candidate out[CHOOSER_ROWS]);

/** Of what a decision is remembered by: cases of like size share it. */
uint64_t chooser_key(const struct choice_case *at);
/** The pair that is likely good, by rules; what frames take while nothing has been measured. */
struct choice chooser_guess(const struct choice_case *at);

/** Remembers what is being measured; for the end of a run. */
void chooser_keep(struct chooser *chooser);
/** Text of the memory, one decision or candidate a line; returns the length it wants. Parsing skips lines that it does not understand. */
size_t chooser_print(const struct chooser *chooser, char *text, size_t capacity);
void chooser_parse(struct chooser *chooser, const char *text, size_t length);

#endif
