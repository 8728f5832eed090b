/* SPDX-License-Identifier: MIT */
/**
 * Describes each kind of light in a row, for editors, reports and files that treat all kinds alike. Finding a row is a table look-up.
 *
 * Loop over the members of a kind instead of naming them: your program then handles kinds that are added later without a change. Around a selected light, draw
 * fnl_light_outline(), and a circle of its range if the kind has a range.
 */
#ifndef FANAL_LIGHT_KINDS_H
#define FANAL_LIGHT_KINDS_H

#include "fanal/light.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum fnl_light_unit {
    FNL_LIGHT_UNIT_METERS = 0,
    FNL_LIGHT_UNIT_RADIANS,
    FNL_LIGHT_UNIT_FRACTION,
    FNL_LIGHT_UNIT_SWITCH, /**< a bool; members with other units are floats */
    FNL_LIGHT_UNIT_COUNT
} fnl_light_unit;

/** A member of fnl_light_params that only some kinds have. All strings live as long as the program. */
typedef struct fnl_light_member {
    const char *name;      /**< such as "wedge_angles"; files call it wedgeAngles */
    const char *labels[3]; /**< one for each value, for user interfaces, such as "horizontal angle" */
    const char *hint;      /**< one line for user interfaces; "": the labels are enough */
    fnl_light_unit unit;
    uint32_t offset; /**< in fnl_light_params, bytes */
    uint32_t count;  /**< number of values; 3: an fnl_vec3 */
    float low, high; /**< range of each value; 0, 1 for switches */
    bool above_low;  /**< `low` itself is out of range */
    float useful_low; /**< >= `low`; smaller values in files and user interfaces are raised to it, because such a light is hard to see */
    const char *at_most; /**< name of the member of the same kind that this one must not exceed; or NULL */
    float defaults[3];   /**< as in fnl_light_params_default(); 0 or 1 for switches */
} fnl_light_member;

typedef struct fnl_light_kind_info {
    /* Members of fnl_light_params that apply. Color, intensity, mask and the shadow members apply to all kinds. */
    bool has_position, has_direction, has_up, has_range, has_source_radius, has_source_angle;
    bool has_profile; /**< may have a profile; with a profile, direction and `up` apply too */
    bool parallel;    /**< all its light has one direction; intensity in lux instead of candela */
    bool area;        /**< its whole surface emits light */
    uint32_t member_count;
    const fnl_light_member *members;
} fnl_light_kind_info;

/** Returns the row of a kind, which lives as long as the program; NULL if there is no such kind. */
FNL_API const fnl_light_kind_info *fnl_light_kind_find(fnl_light_kind kind);

/**
 * Writes lines that show the shape of a light: the edges of a box, the border of a rectangle and a ray from its center, the tip of a cone or pyramid, the
 * segment of a capsule. Each line is two world-space points. `length` sets how far the edges of cones and pyramids are drawn, in meters, > 0. Direction and up
 * must be perpendicular unit vectors, as fnl_scene_query_light() returns them. Writes at most `capacity` points and returns the count of all points: a multiple
 * of 2; 0 for point lights, directional lights and NULL (logged). `points` may be NULL if `capacity` is 0.
 */
FNL_API uint32_t fnl_light_outline(const fnl_light_params *params, float length, uint32_t capacity, fnl_vec3 *points);

#ifdef __cplusplus
}
#endif
#endif
