/* SPDX-License-Identifier: MIT */
/**
 * What the kinds of lights have, as rows: for editors, reports and files that treat all kinds alike. A row costs a look into a table.
 *
 * Loop over the members of a kind instead of naming them: a kind that comes later is then edited and reported without a change. Draw fnl_light_outline() round
 * a selected light, and a circle of its range where the kind has one.
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
    FNL_LIGHT_UNIT_SWITCH, /**< a bool, all others are floats */
    FNL_LIGHT_UNIT_COUNT
} fnl_light_unit;

/** A member of fnl_light_params that only some kinds have. All strings live as long as the program. */
typedef struct fnl_light_member {
    const char *name;      /**< such as "wedge_angles"; files call it wedgeAngles */
    const char *labels[3]; /**< of each value, for user interfaces, such as "horizontal angle" */
    const char *hint;      /**< one line for user interfaces; "": the labels say it all */
    fnl_light_unit unit;
    uint32_t offset; /**< in fnl_light_params, bytes */
    uint32_t count;  /**< values; 3: an fnl_vec3 */
    float low, high; /**< the range of each value; switches: 0, 1 */
    bool above_low;  /**< `low` itself is out of range */
    float useful_low; /**< files and user interfaces raise values to this, at least `low`; below it a light is hard to see */
    const char *at_most; /**< the name of a member of the same kind that this one must not exceed; or NULL */
    float defaults[3];   /**< in fnl_light_params_default(); of switches 0 or 1 */
} fnl_light_member;

typedef struct fnl_light_kind_info {
    /* Which members of fnl_light_params have a meaning; all kinds have a color, an intensity, a mask and those of shadows. */
    bool has_position, has_direction, has_up, has_range, has_source_radius, has_source_angle;
    bool has_profile; /**< it can have a profile, which gives it a direction and `up` too */
    bool parallel;    /**< its light has one direction, and its intensity is in lux instead of candela */
    bool area;        /**< all of its surface shines */
    uint32_t member_count;
    const fnl_light_member *members;
} fnl_light_kind_info;

/** The row of a kind, which lives as long as the program; NULL if there is no such kind. */
FNL_API const fnl_light_kind_info *fnl_light_kind_find(fnl_light_kind kind);

/**
 * Lines that show the shape of a light: the walls of a box, the border of a panel and a ray from its middle, the tip of a cone or pyramid, the segment of a
 * capsule. Each line is two world-space points. `length`, metres, > 0, is that of the edges of cones and pyramids, which have any. Direction and up are
 * unit vectors at right angles, as fnl_scene_query_light() returns them. Writes the first `capacity` points and returns the count of all: a multiple of 2, 0 for
 * points, directional lights, and NULL (logged). `points` may be NULL if `capacity` is 0.
 */
FNL_API uint32_t fnl_light_outline(const fnl_light_params *params, float length, uint32_t capacity, fnl_vec3 *points);

#ifdef __cplusplus
}
#endif
#endif
