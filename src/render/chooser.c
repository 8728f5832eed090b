/* SPDX-License-Identifier: MIT */
#include "render/chooser.h"

#include "render/traits.h"

#include <inttypes.h>
#include <stdio.h>

enum {
    PREPASS_LIGHTS = 8, /* up to here a G-buffer often costs more than it saves: docs/techniques/auto.md has times */
    FEW_LIGHTS = 64,     /* up to here visiting all may be best */
    MANY_LIGHTS = 16384, /* beyond, some lists that test blocks of cells against each light are not tried */
    SETTLE_FRAMES = 240, /* a decision stands at least as long when only the view changes */
    SLOW_FRAMES = 30,    /* so many frames in a row that are slower by SLOW_FACTOR end a decision */
};
#define SLOW_FACTOR 1.6

/* ---- what is tried ---- */

static bool is_deferred(fnl_shading shading) { return shading_is(shading, SHADING_GBUFFER); }

/* Whether a pair is worth a try in this case, and gives the very same picture. */
static bool worth(const struct choice_case *at, struct choice c) {
    if (!fnl_shading_supports(c.shading, c.lists, at->msaa)) return false;
    if (c.lists == FNL_LISTS_WORLD && at->moves) return false; /* the processor would build them for each frame */
    /* Edges are lit at other points of their pixels than with forward shading: taken only if asked for. */
    if (is_deferred(c.shading) && at->msaa > 1 && at->asked.shading == FNL_SHADING_AUTO) return false;
    bool splits = c.lists == FNL_LISTS_HALFZ || c.lists == FNL_LISTS_25D || c.lists == FNL_LISTS_BACKFACE;
    /* Without depth beforehand these are others by another name. */
    bool prepass = shading_is(c.shading, SHADING_PREPASS) || (at->depth_first && shading_is(c.shading, SHADING_MAY_PREPASS));
    bool early = shading_is(c.shading, SHADING_LISTS_FIRST) && !prepass;
    if (early && (splits || c.lists == FNL_LISTS_FINE || c.lists == FNL_LISTS_SPARSE)) return false;
    return c.lists != FNL_LISTS_BACKFACE || is_deferred(c.shading); /* needs normals */
}

/* Lists in the order of their chances. */
static const fnl_light_lists none[] = {FNL_LISTS_ALL}; /* of no lights: all are equal, and this kind needs no pool */
static const fnl_light_lists few[] = {FNL_LISTS_ALL,  FNL_LISTS_TILED,    FNL_LISTS_CLUSTERED, FNL_LISTS_ZBIN,
                                      FNL_LISTS_FINE, FNL_LISTS_BACKFACE, FNL_LISTS_ENHANCED,  FNL_LISTS_WORLD};
static const fnl_light_lists some[] = {FNL_LISTS_TILED,  FNL_LISTS_CLUSTERED, FNL_LISTS_ZBIN,
                                       FNL_LISTS_WORLD,  FNL_LISTS_FINE,      FNL_LISTS_BACKFACE,
                                       FNL_LISTS_SPARSE, FNL_LISTS_HALFZ,     FNL_LISTS_25D};
static const fnl_light_lists many[] = {FNL_LISTS_HALFZ, FNL_LISTS_CLUSTERED, FNL_LISTS_ZBIN,
                                       FNL_LISTS_WORLD, FNL_LISTS_TILED,     FNL_LISTS_FINE,
                                       FNL_LISTS_BVH,   FNL_LISTS_SPARSE,    FNL_LISTS_CLUSTERED_CPU};

static const fnl_light_lists *lists_for(const struct choice_case *at, uint32_t *count) {
    if (at->light_count == 0) {
        *count = COUNT_OF(none);
        return none;
    }
    if (at->light_count <= FEW_LIGHTS) {
        *count = COUNT_OF(few);
        return few;
    }
    if (at->light_count <= MANY_LIGHTS) {
        *count = COUNT_OF(some);
        return some;
    }
    *count = COUNT_OF(many);
    return many;
}

static fnl_light_lists likely_lists(const struct choice_case *at, fnl_shading shading) {
    uint32_t count;
    const fnl_light_lists *lists = lists_for(at, &count);
    for (uint32_t i = 0; i < count; i++)
        if ((lists[i] != FNL_LISTS_ALL || at->light_count <= 8) && worth(at, (struct choice){shading, lists[i]}))
            return lists[i];
    return fnl_shading_supports(shading, FNL_LISTS_CLUSTERED, at->msaa) ? FNL_LISTS_CLUSTERED : FNL_LISTS_ALL;
}

/* From the likeliest on; those that are only close to the others stand last. */
static const fnl_shading orders[] = {FNL_SHADING_DEFERRED, FNL_SHADING_FORWARD_PREPASS, FNL_SHADING_FORWARD, FNL_SHADING_VISIBILITY};
enum { EQUAL_ORDERS = 3 };

static uint32_t order_count(const struct choice_case *at) { return at->close ? COUNT_OF(orders) : EQUAL_ORDERS; }

uint32_t fnl_shading_likely(fnl_shading shading, fnl_light_lists lists, uint32_t light_count, uint32_t msaa) {
    uint32_t likely = 0;
    for (uint32_t i = 0; i < COUNT_OF(orders); i++)
        if (orders[i] == shading) likely |= i < EQUAL_ORDERS ? FNL_LIKELY_SHADING : FNL_LIKELY_CLOSE;
    if (shading_is(shading, SHADING_VOLUMES)) likely |= FNL_LIKELY_BLENDED;
    if ((uint32_t)shading >= FNL_SHADING_AUTO || (uint32_t)lists >= FNL_LISTS_AUTO) return likely;
    struct choice_case at = {.asked = {shading, FNL_LISTS_AUTO}, .light_count = light_count, .msaa = msaa};
    uint32_t count;
    const fnl_light_lists *tried = lists_for(&at, &count);
    for (uint32_t i = 0; i < count; i++)
        if (tried[i] == lists && worth(&at, (struct choice){shading, lists})) likely |= FNL_LIKELY_LISTS;
    return likely;
}

struct choice chooser_guess(const struct choice_case *at) {
    struct choice c = at->asked;
    if (c.shading == FNL_SHADING_AUTO) {
        c.shading = FNL_SHADING_FORWARD_PREPASS;
        for (uint32_t i = order_count(at); i-- > 0;) {
            struct choice pair = {orders[i], c.lists == FNL_LISTS_AUTO ? likely_lists(at, orders[i]) : c.lists};
            if (fnl_shading_supports(pair.shading, pair.lists, at->msaa) && !(is_deferred(pair.shading) && at->msaa > 1))
                c.shading = pair.shading;
        }
        const fnl_light_lists lists = c.lists == FNL_LISTS_AUTO ? likely_lists(at, FNL_SHADING_FORWARD_PREPASS) : c.lists;
        if (at->light_count <= PREPASS_LIGHTS && fnl_shading_supports(FNL_SHADING_FORWARD_PREPASS, lists, at->msaa))
            c.shading = FNL_SHADING_FORWARD_PREPASS;
        /* It shades pixels of one surface once, whatever the samples. */
        const fnl_light_lists close = c.lists == FNL_LISTS_AUTO ? likely_lists(at, FNL_SHADING_VISIBILITY) : c.lists;
        if (at->close && at->msaa > 1 && fnl_shading_supports(FNL_SHADING_VISIBILITY, close, at->msaa)) c.shading = FNL_SHADING_VISIBILITY;
    }
    if (c.lists == FNL_LISTS_AUTO) c.lists = likely_lists(at, c.shading);
    return c;
}

static void add_candidate(struct chooser *c, struct choice choice) {
    for (uint32_t i = 0; i < c->candidate_count; i++)
        if (c->candidates[i].choice.shading == choice.shading && c->candidates[i].choice.lists == choice.lists) return;
    if (c->candidate_count < CHOOSER_CANDIDATES)
        c->candidates[c->candidate_count++] = (struct chooser_candidate){.choice = choice, .turns = CHOOSER_ROUNDS};
}

static void add_orders(struct chooser *c, const struct choice_case *at) {
    for (uint32_t i = 0; i < order_count(at); i++) {
        struct choice pair = {orders[i], at->asked.lists == FNL_LISTS_AUTO ? likely_lists(at, orders[i]) : at->asked.lists};
        if (fnl_shading_supports(pair.shading, pair.lists, at->msaa) && !(is_deferred(pair.shading) && at->msaa > 1))
            add_candidate(c, pair);
    }
}

static void add_lists(struct chooser *c, const struct choice_case *at, fnl_shading shading) {
    uint32_t count;
    const fnl_light_lists *lists = lists_for(at, &count);
    add_candidate(c, (struct choice){shading, c->choice.lists});
    for (uint32_t i = 0; i < count; i++) {
        struct choice pair = {shading, lists[i]};
        if (worth(at, pair)) add_candidate(c, pair);
    }
}

/* ---- memory ---- */

/* Counts of like size share a key: steps of a factor of two. */
static uint64_t step_of(uint64_t count) {
    uint64_t step = 0;
    while (count >>= 1) step++;
    return step;
}

uint64_t chooser_key(const struct choice_case *at) {
    uint64_t parts[] = {at->scene,
                        (uint64_t)at->asked.shading,
                        (uint64_t)at->asked.lists,
                        at->light_count > 0,
                        step_of(at->light_count),
                        step_of(at->pixel_count),
                        at->msaa,
                        at->depth_first,
                        at->close,
                        at->moves};
    return hash_bytes(parts, sizeof parts, HASH_SEED);
}

static void remember(struct chooser *c, struct remembered_choice entry) {
    uint32_t i = 0;
    while (i < c->memory_count && c->memory[i].key != entry.key) i++;
    if (i == CHOOSER_MEMORY) i--; /* the first entry is the oldest */
    bool known = i < c->memory_count && c->memory[i].key == entry.key;
    uint32_t first = known ? i : 0;
    if (known || c->memory_count == CHOOSER_MEMORY) {
        memmove(&c->memory[first], &c->memory[first + 1], (c->memory_count - first - 1) * sizeof entry);
        c->memory_count--;
    }
    c->memory[c->memory_count++] = entry;
}

static const struct remembered_choice *recall(const struct chooser *c, uint64_t key) {
    for (uint32_t i = 0; i < c->memory_count; i++)
        if (c->memory[i].key == key) return &c->memory[i];
    return NULL;
}

static void forget_trials(struct chooser *c, uint64_t key) {
    uint32_t count = 0;
    for (uint32_t i = 0; i < c->trial_count; i++)
        if (c->trials[i].key != key) c->trials[count++] = c->trials[i];
    c->trial_count = count;
}

static bool same_choice(struct choice a, struct choice b) { return a.shading == b.shading && a.lists == b.lists; }

static struct remembered_trial *find_trial(struct chooser *c, uint64_t key, struct choice choice) {
    for (uint32_t i = 0; i < c->trial_count; i++)
        if (c->trials[i].key == key && same_choice(c->trials[i].choice, choice)) return &c->trials[i];
    return NULL;
}

static void keep_trial(struct chooser *c, struct remembered_trial trial) {
    struct remembered_trial *known = find_trial(c, trial.key, trial.choice);
    if (!known && c->trial_count == CHOOSER_TRIALS) /* the first entry is the oldest */
        memmove(&c->trials[0], &c->trials[1], --c->trial_count * sizeof trial);
    *(known ? known : &c->trials[c->trial_count++]) = trial;
}

void chooser_keep(struct chooser *c) {
    for (uint32_t i = 0; i < c->candidate_count && c->state == CHOOSER_MEASURING; i++) {
        const struct chooser_candidate *k = &c->candidates[i];
        if (k->got == 0) continue;
        struct remembered_trial trial = {.key = chooser_key(&c->at), .choice = k->choice, .count = k->got};
        memcpy(trial.times, k->times, sizeof trial.times);
        keep_trial(c, trial);
    }
}

/* Appends to the text and to its length. */
static void add_text(char *text, size_t capacity, size_t *length, const char *format, ...) {
    size_t at = MIN(*length, capacity);
    va_list arguments;
    va_start(arguments, format);
    int n = text_format_list(text ? text + at : NULL, text ? capacity - at : 0, format, arguments);
    va_end(arguments);
    *length += n > 0 ? (size_t)n : 0;
}

size_t chooser_print(const struct chooser *c, char *text, size_t capacity) {
    size_t length = 0;
    for (uint32_t i = 0; i < c->memory_count; i++) {
        const struct remembered_choice *m = &c->memory[i];
        add_text(text, capacity, &length, "%016" PRIx64 " %s %s %.4f\n", m->key, fnl_value_name(FNL_ENUM_SHADING, m->choice.shading),
                 fnl_value_name(FNL_ENUM_LISTS, m->choice.lists), m->milliseconds);
    }
    for (uint32_t i = 0; i < c->trial_count; i++) {
        const struct remembered_trial *t = &c->trials[i];
        add_text(text, capacity, &length, "trial %016" PRIx64 " %s %s", t->key, fnl_value_name(FNL_ENUM_SHADING, t->choice.shading),
                 fnl_value_name(FNL_ENUM_LISTS, t->choice.lists));
        for (uint32_t k = 0; k < t->count; k++) add_text(text, capacity, &length, " %.4f", t->times[k]);
        add_text(text, capacity, &length, "\n");
    }
    return length;
}

/* "key shading lists time …", of a decision one time, of a trial up to CHOOSER_TIMES. */
static void parse_line(struct chooser *c, const char *line) {
    static const char mark[] = "trial ";
    bool is_trial = strncmp(line, mark, sizeof mark - 1) == 0;
    if (is_trial) line += sizeof mark - 1;
    char shading[32], lists[32];
    struct remembered_trial entry = {.choice = {FNL_SHADING_COUNT, FNL_LISTS_COUNT}};
    int used = 0;
    if (sscanf(line, "%" SCNx64 " %31s %31s%n", &entry.key, shading, lists, &used) != 3) return;
    for (uint32_t i = 0; i < FNL_SHADING_AUTO; i++)
        if (strcmp(shading, fnl_value_name(FNL_ENUM_SHADING, (fnl_shading)i)) == 0) entry.choice.shading = (fnl_shading)i;
    for (uint32_t i = 0; i < FNL_LISTS_AUTO; i++)
        if (strcmp(lists, fnl_value_name(FNL_ENUM_LISTS, (fnl_light_lists)i)) == 0) entry.choice.lists = (fnl_light_lists)i;
    if (entry.choice.shading >= FNL_SHADING_AUTO || entry.choice.lists >= FNL_LISTS_AUTO) return;
    const char *at = line + used;
    for (char *rest; entry.count < CHOOSER_TIMES; at = rest) {
        const double time = number_read(at, &rest);
        if (rest == at) break;
        if (time >= 1e-4 && time < 1e9) entry.times[entry.count++] = time; /* less would be written as 0 */
    }
    if (entry.count == 0) return;
    if (is_trial)
        keep_trial(c, entry);
    else
        remember(c, (struct remembered_choice){entry.key, entry.choice, entry.times[0]});
}

void chooser_parse(struct chooser *c, const char *text, size_t length) {
    for (size_t at = 0; at < length;) {
        const char *end = memchr(text + at, '\n', length - at);
        size_t size = end ? (size_t)(end - (text + at)) : length - at;
        char line[192];
        if (size < sizeof line) {
            memcpy(line, text + at, size);
            line[size] = 0;
            parse_line(c, line);
        }
        at += size + 1;
    }
}

/* ---- deciding ---- */

static const char not_measured[] = "likely the best for this number of lights; not measured";

static double median_of(const struct chooser_candidate *candidate) {
    double t[CHOOSER_TIMES];
    uint32_t count = candidate->got;
    memcpy(t, candidate->times, sizeof t);
    for (uint32_t i = 1; i < count; i++) /* a handful: insertion */
        for (uint32_t k = i; k > 0 && t[k] < t[k - 1]; k--) {
            double swap = t[k];
            t[k] = t[k - 1];
            t[k - 1] = swap;
        }
    return count % 2 ? t[count / 2] : 0.5 * (t[count / 2 - 1] + t[count / 2]);
}

/* Times told so far; the first of each candidate is not kept. */
static uint32_t best_of(const struct chooser *c, uint32_t *out_second) {
    uint32_t best = CHOOSER_CANDIDATES, second = CHOOSER_CANDIDATES;
    for (uint32_t i = 0; i < c->candidate_count; i++) {
        if (c->candidates[i].got == 0) continue;
        double time = median_of(&c->candidates[i]);
        if (best == CHOOSER_CANDIDATES || time < median_of(&c->candidates[best])) {
            second = best;
            best = i;
        } else if (second == CHOOSER_CANDIDATES || time < median_of(&c->candidates[second])) {
            second = i;
        }
    }
    *out_second = second;
    return best;
}

static void drop_slow(struct chooser *c) {
    uint32_t second, best = best_of(c, &second);
    for (uint32_t i = 0; i < c->candidate_count; i++)
        if (c->candidates[i].got && median_of(&c->candidates[i]) > CHOOSER_DROP_FACTOR * median_of(&c->candidates[best]))
            c->candidates[i].dropped = true;
}

/* The candidates of a stage are listed: what an earlier run knows of them need not be measured again. What won the stage before runs `again`,
   so that all are measured at the same time. */
static void begin_stage(struct chooser *c, bool again) {
    c->waited = 0;
    c->last = CHOOSER_CANDIDATES;
    for (uint32_t i = 0; i < c->candidate_count; i++) {
        struct chooser_candidate *k = &c->candidates[i];
        k->asked = same_choice(k->choice, c->choice); /* frames are rendered with it */
        const struct remembered_trial *known = find_trial(c, chooser_key(&c->at), k->choice);
        if (!known || (again && k->asked)) continue;
        k->got = known->count;
        memcpy(k->times, known->times, sizeof k->times);
        k->turns = k->got < CHOOSER_TIMES ? CHOOSER_ROUNDS - k->got : 0;
    }
    drop_slow(c);
}

static void decide(struct chooser *c, const char *how) {
    c->state = CHOOSER_DECIDED;
    c->frames = c->slow_frames = c->pending_count = 0;
    c->last = CHOOSER_CANDIDATES;
    snprintf(c->reason, sizeof c->reason, "%s", how);
}

static void start(struct chooser *c, const struct choice_case *at, struct choice first) {
    c->state = CHOOSER_MEASURING;
    c->at = *at;
    c->choice = first;
    c->milliseconds = 0;
    c->before_count = c->candidate_count = c->pending_count = c->frames = c->measured_count = c->slow_frames = 0;
    c->lists_left = at->asked.shading == FNL_SHADING_AUTO && at->asked.lists == FNL_LISTS_AUTO && at->light_count > 0;
    if (at->asked.shading == FNL_SHADING_AUTO) {
        add_orders(c, at);
    } else if (at->light_count > 0) {
        add_lists(c, at, at->asked.shading);
    } else {
        decide(c, "there are no lights: brute force costs nothing");
        return;
    }
    begin_stage(c, false);
}

/* `out` has room for all candidates. */
static uint32_t list_candidates(const struct chooser *c, fnl_candidate *out) {
    for (uint32_t i = 0; i < c->candidate_count; i++) {
        const struct chooser_candidate *k = &c->candidates[i];
        out[i] = (fnl_candidate){.shading = k->choice.shading, .lists = k->choice.lists, .frames = k->got};
        if (k->got > 0) out[i].milliseconds = median_of(k);
    }
    return c->candidate_count;
}

uint32_t chooser_list(const struct chooser *c, fnl_candidate out[CHOOSER_ROWS]) {
    uint32_t count = 0;
    fnl_candidate now[CHOOSER_CANDIDATES];
    const uint32_t now_count = list_candidates(c, now);
    for (uint32_t i = 0; i < c->before_count; i++) { /* the winner is measured again with its rivals in lists */
        bool again = false;
        for (uint32_t k = 0; k < now_count; k++) again |= now[k].shading == c->before[i].shading && now[k].lists == c->before[i].lists;
        if (!again) out[count++] = c->before[i];
    }
    for (uint32_t i = 0; i < now_count; i++) out[count++] = now[i];
    if (count == 0 && c->milliseconds > 0) /* remembered */
        out[count++] = (fnl_candidate){.shading = c->choice.shading, .lists = c->choice.lists, .milliseconds = c->milliseconds};
    for (uint32_t i = 0; i < count; i++)
        out[i].chosen = c->state == CHOOSER_DECIDED && out[i].shading == c->choice.shading && out[i].lists == c->choice.lists;
    return count;
}

static void finish_stage(struct chooser *c) {
    uint32_t second, best = best_of(c, &second);
    if (best < CHOOSER_CANDIDATES) {
        c->choice = c->candidates[best].choice;
        c->milliseconds = median_of(&c->candidates[best]);
    }
    for (uint32_t i = 0; i < c->candidate_count; i++) c->measured_count += c->candidates[i].got > 0;
    if (c->lists_left) {
        c->lists_left = false;
        chooser_keep(c);
        c->before_count = list_candidates(c, c->before);
        c->candidate_count = 0;
        add_lists(c, &c->at, c->choice.shading);
        begin_stage(c, true);
        c->measured_count--;
        return;
    }
    char how[192], next[80] = "";
    if (best == CHOOSER_CANDIDATES) { /* no time was ever told */
        decide(c, "not measured: the device gives no times");
        return;
    }
    if (second < CHOOSER_CANDIDATES)
        text_format(next, sizeof next, "; next %s + %s %.2f ms", fnl_value_name(FNL_ENUM_SHADING, c->candidates[second].choice.shading),
                    fnl_value_name(FNL_ENUM_LISTS, c->candidates[second].choice.lists), median_of(&c->candidates[second]));
    text_format(how, sizeof how, "fastest of %u measured over %u frames: %.2f ms%s", c->measured_count, c->frames,
                c->milliseconds, next);
    remember(c, (struct remembered_choice){chooser_key(&c->at), c->choice, c->milliseconds});
    forget_trials(c, chooser_key(&c->at));
    c->memory_changed = true;
    decide(c, how);
}

static bool ratio_beyond(double a, double b, double factor) { return a > b * factor || b > a * factor; }

/* Other things are asked for, or the work is of another size. */
static bool case_differs(const struct choice_case *a, const struct choice_case *b) {
    return a->asked.shading != b->asked.shading || a->asked.lists != b->asked.lists || a->scene != b->scene ||
           a->msaa != b->msaa || a->depth_first != b->depth_first || a->close != b->close || a->moves != b->moves ||
           (a->light_count > 0) != (b->light_count > 0) ||
           ratio_beyond((double)a->light_count + 8, (double)b->light_count + 8, 2) ||
           ratio_beyond((double)a->pixel_count, (double)b->pixel_count, 1.5);
}

static bool view_differs(const struct choice_case *a, const struct choice_case *b) {
    vec3 way = vec3_sub(a->eye, b->eye);
    return vec3_dot(a->forward, b->forward) < 0.5f || vec3_length(way) > 0.25f * b->scene_size;
}

/* What frames take that nobody's turn it is: the best known. */
static struct choice pick_best(struct chooser *c) {
    uint32_t second, best = best_of(c, &second);
    if (best == CHOOSER_CANDIDATES) {
        snprintf(c->reason, sizeof c->reason, "%s", not_measured);
        return c->choice;
    }
    text_format(c->reason, sizeof c->reason, "fastest of those measured so far: %.2f ms", median_of(&c->candidates[best]));
    return c->candidates[best].choice;
}

/* Whose turn it is: the one that had the fewest of those that have some left. */
static uint32_t next_turn(const struct chooser *c, uint64_t done) {
    uint32_t next = CHOOSER_CANDIDATES;
    for (uint32_t i = 0; i < c->candidate_count; i++) {
        const struct chooser_candidate *k = &c->candidates[i];
        if (k->dropped || !k->asked || k->ticket > done || k->given >= k->turns) continue;
        if (next == CHOOSER_CANDIDATES || k->given < c->candidates[next].given) next = i;
    }
    return next;
}

/* Is there one that cannot take its turns yet? */
static bool some_wait(const struct chooser *c, uint64_t done) {
    struct choice unused;
    for (uint32_t i = 0; i < c->candidate_count; i++)
        if (c->candidates[i].ticket > done && c->waited < CHOOSER_PATIENCE) return true;
    return chooser_asks(c, &unused);
}

static struct choice pick_turn(struct chooser *c, struct chooser_background background) {
    if (background.done < background.asked && c->waited < CHOOSER_PATIENCE) {
        c->waited++;
        struct choice choice = pick_best(c);
        snprintf(c->reason, sizeof c->reason, "pipelines are being made, to be measured then");
        return choice;
    }
    while (c->state == CHOOSER_MEASURING) {
        snprintf(c->reason, sizeof c->reason, "measuring");
        uint32_t next = c->pending_count < CHOOSER_PENDING ? next_turn(c, background.done) : CHOOSER_CANDIDATES;
        if (next < CHOOSER_CANDIDATES) {
            c->last = next;
            return c->candidates[next].choice;
        }
        if (c->pending_count > 0 || some_wait(c, background.done)) break; /* times are still on their way */
        finish_stage(c);
    }
    return c->choice;
}

struct choice chooser_pick(struct chooser *c, const struct choice_case *at, bool measures,
                           struct chooser_background background) {
    c->last = CHOOSER_CANDIDATES;
    bool other = c->state == CHOOSER_IDLE || case_differs(&c->at, at);
    bool moved = c->state == CHOOSER_DECIDED && c->frames > SETTLE_FRAMES && view_differs(&c->at, at);
    bool slow = c->state == CHOOSER_DECIDED && c->slow_frames > SLOW_FRAMES;
    if (other) {
        chooser_keep(c);
        const struct remembered_choice *known = recall(c, chooser_key(at));
        if (known && fnl_shading_supports(known->choice.shading, known->choice.lists, at->msaa)) {
            c->at = *at;
            c->choice = known->choice;
            c->milliseconds = known->milliseconds;
            c->before_count = c->candidate_count = 0;
            char how[96];
            text_format(how, sizeof how, "remembered: %.2f ms when it was measured", known->milliseconds);
            decide(c, how);
        } else {
            start(c, at, chooser_guess(at));
        }
    } else if (measures && (moved || slow)) {
        start(c, at, c->choice);
    }
    if (c->state == CHOOSER_DECIDED) {
        c->frames++;
        return c->choice;
    }
    return measures ? pick_turn(c, background) : pick_best(c);
}

bool chooser_asks(const struct chooser *c, struct choice *out) {
    for (uint32_t i = 0; i < c->candidate_count && c->state == CHOOSER_MEASURING; i++) {
        const struct chooser_candidate *k = &c->candidates[i];
        if (k->asked || k->dropped || k->turns == 0) continue;
        *out = k->choice;
        return true;
    }
    return false;
}

void chooser_asked(struct chooser *c, uint64_t ticket) {
    for (uint32_t i = 0; i < c->candidate_count; i++) {
        struct chooser_candidate *k = &c->candidates[i];
        if (k->asked || k->dropped || k->turns == 0) continue;
        k->asked = true;
        k->ticket = ticket;
        if (ticket) c->last = CHOOSER_CANDIDATES;
        return;
    }
}

void chooser_note(struct chooser *c, uint64_t frame, double cpu_milliseconds) {
    bool measures = c->last < CHOOSER_CANDIDATES || c->state == CHOOSER_DECIDED;
    if (!measures || c->pending_count == CHOOSER_PENDING) return;
    if (c->last < CHOOSER_CANDIDATES) {
        c->candidates[c->last].given++;
        c->frames++;
    }
    c->pending[c->pending_count++] = (struct chooser_pending){frame, c->last, cpu_milliseconds};
}

uint64_t chooser_wants(const struct chooser *c) { return c->pending_count ? c->pending[0].frame : 0; }

/* Where only lists are chosen, drawing the surfaces costs the same with all of them: its jitter would only blur the comparison. */
bool chooser_counts(const struct choice *asked, fnl_pass_role role) { return asked->shading == FNL_SHADING_AUTO || role != FNL_PASS_GEOMETRY; }

void chooser_feed(struct chooser *c, double gpu_milliseconds, double left_out) {
    if (c->pending_count == 0) return;
    const struct chooser_pending frame = c->pending[0];
    uint32_t index = frame.candidate;
    memmove(&c->pending[0], &c->pending[1], --c->pending_count * sizeof c->pending[0]);
    if (gpu_milliseconds < 0) return;
    const double milliseconds = MAX(gpu_milliseconds, frame.cpu_milliseconds) - left_out;
    if (index >= CHOOSER_CANDIDATES) { /* after the decision: is it still good? */
        bool slow = c->milliseconds > 0 && milliseconds > c->milliseconds * SLOW_FACTOR;
        c->slow_frames = slow && c->state == CHOOSER_DECIDED ? c->slow_frames + 1 : 0;
        return;
    }
    struct chooser_candidate *k = &c->candidates[index];
    if (!k->warm) { /* the first is not counted */
        k->warm = true;
        return;
    }
    if (k->got < CHOOSER_TIMES) k->times[k->got++] = milliseconds;
    drop_slow(c);
}
