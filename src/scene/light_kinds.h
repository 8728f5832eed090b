/* SPDX-License-Identifier: MIT */
/**
 * The kinds of lights, one row each: fanal/light_kinds.h, and members that only the library needs. Shapes on the device: src/render/device/light_shapes.c;
 * strength at a point: src/ray/light.c and shaders/lights/kinds.glsl.
 */
#ifndef FNL_SCENE_LIGHT_KINDS_H
#define FNL_SCENE_LIGHT_KINDS_H

#include "base/maths.h"
#include "fanal/light_kinds.h"

/** Illuminance in lux that a scattered light would give at its range without the window. */
#define SCATTER_ILLUMINANCE 4.0f

/** Random numbers for the shape of a scattered light. */
struct scatter_numbers {
    float cone;     /* half angle of a spot, radians */
    float parts[3]; /* 0 .. 1; not for punctual kinds */
};

struct light_outline {
    fnl_vec3 *points;
    uint32_t capacity, count;
};

struct light_kind {
    fnl_light_kind_info info;
    const char *type; /* in KHR_lights_punctual; for kinds it lacks, the type that other programs show instead */
    bool punctual;    /* KHR_lights_punctual has it */
    bool has_maps;    /* shadow maps can hold its shadows; others need rays */
    float (*range)(const fnl_light_params *light); /* for kinds without a range parameter; NULL: the parameter, or derived from the intensity */
    /* Shapes a light whose position, direction, range and intensity are set, about as large as the sphere of a point light. NULL: cannot be scattered. */
    void (*scatter)(fnl_light_params *light, const struct scatter_numbers *numbers);
    void (*outline)(struct light_outline *out, const fnl_light_params *light, float length); /* NULL: none */
};

extern const struct light_kind light_kinds[FNL_LIGHT_KIND_COUNT];

/** Whether the light has a profile and its kind uses profiles. */
static inline bool light_is_profiled(const fnl_light_params *light) { return light->profile.generation && light_kinds[light->kind].info.has_profile; }
static inline bool light_has_direction(const fnl_light_params *light) { return light_kinds[light->kind].info.has_direction || light_is_profiled(light); }
static inline bool light_has_up(const fnl_light_params *light) { return light_kinds[light->kind].info.has_up || light_is_profiled(light); }

/** The value of a member: floats, or a bool if it is a switch. */
static inline void *light_value(fnl_light_params *light, const fnl_light_member *member) { return (char *)light + member->offset; }
static inline const void *light_value_of(const fnl_light_params *light, const fnl_light_member *member) { return (const char *)light + member->offset; }
/** Bytes of the member. */
static inline size_t light_member_size(const fnl_light_member *member) {
    return member->unit == FNL_LIGHT_UNIT_SWITCH ? sizeof(bool) : member->count * sizeof(float);
}
/** The key in files: `name` in camel case. */
enum { LIGHT_KEY = 32 };
const char *light_member_key(const fnl_light_member *member, char key[LIGHT_KEY]);
/** The member of a kind by name. The kind must have it. */
const fnl_light_member *light_member_find(const fnl_light_kind_info *kind, const char *name);

#endif
