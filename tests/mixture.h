/* SPDX-License-Identifier: MIT */
/**
 * Frames with options that nobody thought of together: bytes choose the size, the shading path, the light list, one view or two eyes, and values for some of the other
 * options, from all that fnl_option_query names. The library refuses a part of them; what it renders has no NaN, draws no message of the validation
 * layers, and is the picture of the same frame without what must not change it (fnl_option.exact).
 */
#ifndef FNL_TESTS_MIXTURE_H
#define FNL_TESTS_MIXTURE_H

#include "fanal/frame.h"
#include "fanal/options.h"
#include "tests/frame_plain.h"

#include <math.h>
#include <stdio.h>

struct mixture {
    const uint8_t *bytes; /* what chooses; zeros follow */
    size_t size;
    fnl_frame frame;
    fnl_camera eyes[2]; /* frame.views points here */
    char text[1024];    /* "KEY=VALUE …", as for `fanal render --set` */
};

static inline uint32_t mixture_pick(struct mixture *m, uint32_t count) {
    uint32_t value = 0;
    for (int i = 0; i < 2; i++) {
        value = value << 8 | (m->size ? *m->bytes : 0u);
        m->bytes += m->size > 0;
        m->size -= m->size > 0;
    }
    return value % count;
}

static inline void mixture_set(struct mixture *m, const char *key, const char *value) {
    const size_t length = strlen(m->text);
    if (fnl_frame_set(NULL, &m->frame, key, value) == FNL_OK) snprintf(m->text + length, sizeof m->text - length, "%s%s=%s", length ? " " : "", key, value);
}

/* What measures, remembers earlier frames, or shows something else than the picture; and sizes, which are chosen apart. */
static inline bool mixture_leaves_out(const char *key) {
    static const char *const keys[] = {"width", "height", "shading", "lists", "debug", "exposure", "ev", "tonemap", "timers", "pin-choice", "choose-close", "reset-history",
                                       "shadow.denoise", "shadow.guide", "shadow.page-rays", "stereo.eyes", "multiview", "studio", "background-blur", "shade-cost",
                                       "texturing.atlas-size", "ground"};
    for (size_t i = 0; i < sizeof keys / sizeof *keys; i++)
        if (strcmp(key, keys[i]) == 0) return true;
    return false;
}

static inline void mixture_value(struct mixture *m, const fnl_option *o, char text[64]) {
    uint32_t count = 0;
    if (o->kind == FNL_OPTION_SWITCH) snprintf(text, 64, "%s", mixture_pick(m, 2) ? "on" : "off");
    if (o->kind == FNL_OPTION_NAME) {
        while (fnl_value_name(o->names, count)) count++;
        snprintf(text, 64, "%s", fnl_value_name(o->names, mixture_pick(m, count)));
    }
    if (o->kind == FNL_OPTION_COUNT) { /* small ones: they cost less, and limits are near */
        uint32_t value = o->choice_count ? o->choices[mixture_pick(m, o->choice_count)] : (uint32_t)o->low + mixture_pick(m, (uint32_t)fmin(o->high - o->low, 8) + 1);
        if (o->power_of_two) value = 1u << mixture_pick(m, 12);
        snprintf(text, 64, "%u", value);
    }
    if (o->kind == FNL_OPTION_NUMBER) {
        static const double parts[] = {0, 0.01, 0.1, 0.5, 1};
        snprintf(text, 64, "%g", o->low + fmin(o->high - o->low, 8) * parts[mixture_pick(m, 5)]);
    }
}

static inline void mixture_place_eyes(struct mixture *m) {
    const fnl_camera *head = &m->frame.camera;
    const float dx = head->target.x - head->position.x, dz = head->target.z - head->position.z, length = sqrtf(dx * dx + dz * dz);
    for (int i = 0; i < 2; i++) {
        const float side = (i ? 0.032f : -0.032f) / (length > 0 ? length : 1);
        m->eyes[i] = *head;
        m->eyes[i].position.x -= side * dz, m->eyes[i].target.x -= side * dz;
        m->eyes[i].position.z += side * dx, m->eyes[i].target.z += side * dx;
    }
    m->frame.views = m->eyes;
    m->frame.view_count = m->frame.stereo.eyes = 2;
}

/** Makes `m->frame`: `base`, changed as the bytes say. `m` stays where it is while the frame is used. */
static inline void mixture_make(struct mixture *m, const uint8_t *bytes, size_t size, const fnl_frame *base) {
    fnl_option option;
    uint32_t count = 0;
    char text[64];
    *m = (struct mixture){.bytes = bytes, .size = size, .frame = *base};
    m->frame.width = 1 + mixture_pick(m, 48);
    m->frame.height = 1 + mixture_pick(m, 32);
    mixture_set(m, "shading", fnl_value_name(FNL_ENUM_SHADING, mixture_pick(m, FNL_SHADING_AUTO)));
    mixture_set(m, "lists", fnl_value_name(FNL_ENUM_LISTS, mixture_pick(m, FNL_LISTS_AUTO)));
    const bool in_stereo = mixture_pick(m, 3) == 0;
    if (mixture_pick(m, 2)) mixture_set(m, "shadows", fnl_value_name(FNL_ENUM_SHADOWS, mixture_pick(m, 5)));
    if (mixture_pick(m, 3) == 0) mixture_set(m, "msaa", "4");
    while (fnl_option_query(count, &option)) count++;
    for (uint32_t changes = mixture_pick(m, 8); changes > 0; changes--) {
        fnl_option_query(mixture_pick(m, count), &option);
        if (mixture_leaves_out(option.key)) continue;
        mixture_value(m, &option, text);
        mixture_set(m, option.key, text);
    }
    const size_t length = strlen(m->text);
    snprintf(m->text + length, sizeof m->text - length, " %ux%u%s", m->frame.width, m->frame.height, in_stereo ? " stereo" : "");
    if (in_stereo) mixture_place_eyes(m);
}

/** The same frame with what must not change a bit of it as it is by default, and brute force for its lights. */
static inline fnl_frame mixture_plainest(const struct mixture *m) {
    const fnl_frame plain = frame_plain();
    fnl_frame frame = m->frame;
    fnl_option option;
    char text[64];
    for (uint32_t i = 0; fnl_option_query(i, &option); i++)
        if (option.exact && fnl_frame_get(&plain, option.key, text, sizeof text) < sizeof text) fnl_frame_set(NULL, &frame, option.key, text);
    frame.stereo.eyes = m->frame.stereo.eyes;
    frame.lists = FNL_LISTS_ALL;
    frame.occlusion = FNL_OCCLUSION_OFF;
    return frame;
}

#endif
