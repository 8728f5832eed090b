/* SPDX-License-Identifier: MIT */
/** What the files of the built-in city share: its measures in metres, and its meshes. */
#ifndef FNL_SCENE_BUILTIN_CITY_H
#define FNL_SCENE_BUILTIN_CITY_H

#include "scene/builtin_mesh.h"

enum {
    CITY_BAYS = 16,
    CITY_CORNER_BAYS = 3,
    CITY_STYLES = 4,
    CITY_WINDOWS = 7,
    CITY_SHOPS = 4,
    CITY_PAINTS = 6,
    CITY_SIGNS = 6,
    CITY_SHELLS = 3,
};

#define CITY_BAY 3.5f                            /* width of a window's or shop's piece of wall */
#define CITY_BLOCK (CITY_BAY * CITY_BAYS)        /* facade to facade */
#define CITY_DEPTH (CITY_BAY * CITY_CORNER_BAYS) /* of a building */
#define CITY_PAVEMENT 4.0f
#define CITY_ROAD 12.0f
#define CITY_PITCH (CITY_BLOCK + 2 * CITY_PAVEMENT + CITY_ROAD)
#define CITY_KERB 0.15f   /* height of the pavement */
#define CITY_GROUND 4.2f  /* height of the ground floor */
#define CITY_FLOOR 3.4f   /* of the others */
#define CITY_STRING 18.0f /* length of a string of lights */

struct city_meshes {
    /* Pieces of wall: X along it from the middle, Y up from the floor, facing +Z. Windows 0 and 1 are dark. */
    uint32_t windows[CITY_STYLES][CITY_WINDOWS], shops[CITY_STYLES][CITY_SHOPS], cornices[CITY_STYLES];
    uint32_t balcony, roof, back, party;
    uint32_t road, crossing, pavement;
    /* Things that stand at their origin; where they have a front it is +Z. */
    uint32_t lamp, lantern, tree[3], bench, bin, bollard, planter, traffic_light[2], manhole;
    uint32_t signs[CITY_SIGNS], string[2], cars[CITY_PAINTS], car_lights;
    /* What is only seen from far away. */
    uint32_t shells[CITY_SHELLS], far_lamp, far_tree, far_block, tower;
};

extern const vec3 city_sign_colors[CITY_SIGNS];

void city_make_facades(struct builtin *b, struct city_meshes *meshes);
void city_make_street(struct builtin *b, struct city_meshes *meshes);
void city_make_vehicles(struct builtin *b, struct city_meshes *meshes);
void city_make_skyline(struct builtin *b, struct city_meshes *meshes);

/** Where the light of bulb `i` of a string hangs, from its left end at (-CITY_STRING / 2, 0, 0). */
enum { CITY_BULBS = 18 };
vec3 city_bulb(uint32_t i);

#endif
