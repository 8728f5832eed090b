/* SPDX-License-Identifier: MIT */
#include "render/step.h"

#define FRAME_STEP_ROW(name) &step_##name,
static const struct frame_step *const steps[FRAME_STEP_COUNT] = {FRAME_STEPS(FRAME_STEP_ROW)};

const struct frame_step *frame_step_at(uint32_t index) { return index < FRAME_STEP_COUNT ? steps[index] : NULL; }

void steps_init(fnl_renderer *r) {
    for (uint32_t i = 0; i < FRAME_STEP_COUNT; i++)
        if (steps[i]->init) steps[i]->init(r);
}

fnl_result steps_check(const struct call *call, fnl_renderer *r, const fnl_frame *frame) {
    for (uint32_t i = 0; i < FRAME_STEP_COUNT; i++)
        if (steps[i]->check) TRY(steps[i]->check(call, r, frame));
    return FNL_OK;
}

fnl_result steps_prepare(fnl_renderer *r, const fnl_frame *frame) {
    for (uint32_t i = 0; i < FRAME_STEP_COUNT; i++)
        if (steps[i]->prepare) TRY(steps[i]->prepare(r, frame));
    return FNL_OK;
}

void steps_counted(fnl_renderer *r, uint32_t slot) {
    for (uint32_t i = 0; i < FRAME_STEP_COUNT; i++)
        if (steps[i]->counted) steps[i]->counted(r, slot);
}

fnl_result steps_begin_frame(struct frame_state *shared) {
    for (uint32_t i = 0; i < FRAME_STEP_COUNT; i++)
        if (steps[i]->begin_frame) TRY(steps[i]->begin_frame(shared));
    return FNL_OK;
}

fnl_result steps_begin_view(struct frame_state *f) {
    for (uint32_t i = 0; i < FRAME_STEP_COUNT; i++)
        if (steps[i]->begin_view) TRY(steps[i]->begin_view(f));
    return FNL_OK;
}

void steps_begin_light(struct frame_state *views, uint32_t count) {
    for (uint32_t i = 0; i < FRAME_STEP_COUNT; i++)
        if (steps[i]->begin_light) steps[i]->begin_light(views, count);
}

void steps_light_view(struct frame_state *f) {
    for (uint32_t i = 0; i < FRAME_STEP_COUNT; i++)
        if (steps[i]->light_view) steps[i]->light_view(f);
}

void steps_end_light(struct frame_state *views, uint32_t count) {
    for (uint32_t i = 0; i < FRAME_STEP_COUNT; i++)
        if (steps[i]->end_light) steps[i]->end_light(views, count);
}

void steps_finish_view(struct frame_state *f) {
    for (uint32_t i = 0; i < FRAME_STEP_COUNT; i++)
        if (steps[i]->finish_view) steps[i]->finish_view(f);
}

void steps_submitted(fnl_renderer *r, const fnl_frame *frame) {
    for (uint32_t i = 0; i < FRAME_STEP_COUNT; i++)
        if (steps[i]->submitted) steps[i]->submitted(r, frame);
}

void steps_forget(fnl_renderer *r) {
    for (uint32_t i = FRAME_STEP_COUNT; i-- > 0;)
        if (steps[i]->forget) steps[i]->forget(r);
}

void steps_grow(fnl_renderer *r, const struct frame_counts *counts) {
    for (uint32_t i = 0; i < FRAME_STEP_COUNT; i++)
        if (steps[i]->grow) steps[i]->grow(r, counts);
}

void steps_destroy(fnl_renderer *r) {
    for (uint32_t i = FRAME_STEP_COUNT; i-- > 0;)
        if (steps[i]->destroy) steps[i]->destroy(r);
}
