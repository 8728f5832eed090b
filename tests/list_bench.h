/* SPDX-License-Identifier: MIT */
/**
 * Light lists for tests: built by their own passes from lights, a view and a depth that the test makes up, read back, and
 * compared with a slow evaluation in double precision. Runs on the device of render_harness.h.
 */
#ifndef FNL_TESTS_LIST_BENCH_H
#define FNL_TESTS_LIST_BENCH_H

#include "tests/render_harness.h"

enum list_builder { LIST_TILED, LIST_HALFZ, LIST_25D, LIST_ENHANCED, LIST_CLUSTERED, LIST_CLUSTERED_CPU, LIST_BVH };

/** What lists are built over: a light's shape and bounds, or those of something else that a test makes up. */
struct list_light {
    struct gpu_shape shape;
    struct gpu_entity_bounds bounds;
};
/** Of the light of a slot. */
struct list_light list_light_of(const fnl_light_params *light, uint32_t slot);
/** The bounds alone, in an array to be freed. */
struct gpu_entity_bounds *list_bounds_of(const struct list_light *lights, uint32_t count);

struct list_request {
    enum list_builder builder;
    struct gpu_view view;
    const struct list_light *lights;
    uint32_t light_count;
    const float *depth; /* reversed, one per pixel; NULL: none. For tiles */
    const float *front; /* of the nearest blended surfaces, likewise; NULL: the list is of opaque ones */
    struct tiled_params tiled;
    struct clustered_params clustered;
};
static inline bool list_is_tiled(const struct list_request *request) { return request->builder <= LIST_ENHANCED; }
/** Whether a tile has two lists, in front of and behind the middle of its depths. */
static inline bool list_has_halves(const struct list_request *request) { return request->builder == LIST_HALFZ && request->depth; }

struct list_copy {
    struct gpu_light_list grid; /* without its addresses */
    struct gpu_cell *cells;
    uint32_t *ids;   /* the whole pool */
    uint32_t *extra; /* or NULL */
    uint32_t cell_count;
    struct light_totals totals;
};

/** Buffers of a graph that are copied to the host at the end of its frame. */
enum { LIST_READS = 8 };
struct list_reads {
    struct gpu_buffer buffers[LIST_READS]; /* mapped, after the frame */
    uint32_t count;
};
void list_reads_add(struct graph *graph, const graph_buffer *buffers, uint32_t count, struct list_reads *out);
/** A copy of what was read, to be freed. */
void *list_reads_take(const struct list_reads *reads, uint32_t index);
void list_reads_free(struct list_reads *reads);

/**
 * A builder alone in a graph of its own:
 *
 *     struct list_lab lab = list_lab_open(&view, lights, count);
 *     … list_lab_image(&lab, …) …
 *     list_lab_begin(&lab);
 *     struct light_list list = x_add(lab.graph, harness_device(), &lab.input, &lab.in_view, …);
 *     list_lab_run(&lab, (graph_buffer[]){list.cells, list.ids}, 2);
 *     … lab.reads …
 *     list_lab_close(&lab);
 */
struct list_lab {
    struct graph *graph;
    struct gpu_view view;
    struct light_input input;
    struct lights_in_view in_view;
    struct list_reads reads;
    struct gpu_buffer lights; /* the lights by user index, then all shapes, then all bounds */
    struct gpu_image images[2];
    uint32_t image_count;
};
/** The lists are for lights, unless the test changes lab.input.kinds before it begins. */
struct list_lab list_lab_open(const struct gpu_view *view, const struct list_light *lights, uint32_t light_count);
/** An image of the view's size; without texels none. Before the frame begins. */
graph_image list_lab_image(struct list_lab *lab, VkFormat format, uint32_t texel_bytes, const void *texels);
static inline graph_image list_lab_depth(struct list_lab *lab, const float *depth) {
    return list_lab_image(lab, VK_FORMAT_R32_SFLOAT, 4, depth);
}
void list_lab_begin(struct list_lab *lab);
/** Compiles and runs the frame. */
void list_lab_run(struct list_lab *lab, const graph_buffer *reads, uint32_t read_count);
void list_lab_close(struct list_lab *lab);

/** Declares the copies of a list's cells, ids and totals to the host; only for lists whose buffers the graph owns. */
struct list_readback {
    struct list_reads reads;
    uint32_t cell_count;
};
void list_readback_add(struct graph *graph, const struct light_list *list, struct list_readback *out);
/** After the frame; frees the readback's buffers. `grid` comes from list_grid. */
struct list_copy list_readback_take(struct list_readback *readback, const struct gpu_light_list *grid);
struct list_copy list_copy_of_cpu(const struct clustered_cpu *builder, const struct gpu_light_list *grid);

struct gpu_light_list list_grid(const struct list_request *request);
struct list_copy list_build(const struct list_request *request);
void list_free(struct list_copy *list);

/** Sum of all counts; cells that overflowed are not counted. */
uint64_t list_entries(const struct list_copy *list);
uint32_t list_longest(const struct list_copy *list);
bool list_holds(const struct list_copy *list, uint32_t cell, uint32_t light);
/** Fails unless every cell's ids ascend, are lights, and offsets follow each other; and the totals say the same. */
void list_check_form(const struct list_copy *list, uint32_t light_count);
bool list_equal(const struct list_copy *a, const struct list_copy *b);
/** The cells in which a point on this pixel may look itself up: two where the depth is on a slice's border. */
void list_cells_of(const struct list_copy *list, uint32_t x, uint32_t y, double view_depth, uint32_t out[2]);

/** The slice of clusters that a view depth falls into. */
uint32_t list_slice_at(const struct gpu_light_list *grid, double view_depth);

/* ---- the reference, in double: list_reference.c ---- */

struct reference_cell {
    double planes[4][4], low[3], high[3];
    double edges[4]; /* left, right, bottom, top: x or y divided by view depth (orthographic: x or y) */
    bool empty;
};

/** View-space bounds of the cell; near and far are moved apart by `slack`, relatively. */
struct reference_cell reference_cell_of(const struct list_request *request, const struct gpu_light_list *grid, uint32_t cell,
                                        double slack);
/** The light's bounding sphere against the four planes (and near and far), and with `box` against the box too. */
bool reference_touches(const struct reference_cell *cell, const struct list_request *request, uint32_t light, double slack,
                       bool box);
/** Least and greatest x / depth of the part of a disk that lies beyond the near plane, found among all points where they can be. */
void reference_slopes(double x, double depth, double radius, double near, double out[2]);
/** The light's screen rectangle and depth range against the cell's, when r->tiled.bounds says so; else planes, with or without the box. */
bool reference_takes(const struct reference_cell *cell, const struct list_request *request, uint32_t light, double slack);
/**
 * How far apart a spot's cone and the cell are at least, metres: positive only where a plane lies between them. 0: they may touch, or
 * the light has no cone.
 */
double reference_cone_gap(const struct reference_cell *cell, const struct list_request *request, uint32_t light);
/** Whether the sphere touches the frustum of the view, near plane included. */
bool reference_in_view(const struct list_request *request, uint32_t light);

/**
 * Fails unless each list holds all lights that touch its cell by the test that the request asks for, and none that a slightly wider
 * test would reject. With cone tests a light may be missing where a plane lies between its cone and the cell. Cells that overflowed
 * are left out.
 */
void reference_check(const struct list_request *request, const struct list_copy *list);

/* ---- made-up views, lights and depths ---- */

enum { LIST_VIEWS = 5 };
extern const char *const list_view_names[LIST_VIEWS];
/** A camera of the given kind (perspective, orthographic, off-axis, mirrored, wide) somewhere near the origin. */
struct gpu_view list_random_view(uint32_t kind, struct random_state *random, uint32_t width, uint32_t height);
/** Points and spots of all sizes before, around and behind the viewer; some with rim or centre on the edge of a tile. */
void list_random_lights(const struct gpu_view *view, struct random_state *random, uint32_t count, fnl_light_params *params,
                        struct list_light *lights);
/** The same, but every third is a capsule, a wedge, a box, or a very narrow spot. */
void list_random_shapes(const struct gpu_view *view, struct random_state *random, uint32_t count, fnl_light_params *params,
                        struct list_light *lights);
/** Slanted surfaces with jumps, and sky; reversed. To be freed. */
float *list_random_depth(const struct gpu_view *view, struct random_state *random);

/** Whether the volume of a light of any shape (without a hull) holds a world-space point. */
bool light_reaches(const fnl_light_params *light, const double point[3]);
void world_to_view(const struct gpu_view *view, const double from[3], double out[3]);
void view_to_world(const struct gpu_view *view, const double from[3], double out[3]);
/** View-space position of a point on the screen (pixels from the top left) at a view depth. */
void view_of_pixel(const struct gpu_view *view, double x, double y, double view_depth, double out[3]);
/** The reversed depth that the view stores for a view depth. */
float depth_of_view_depth(const struct gpu_view *view, double view_depth);
/** And back. */
double view_depth_of_depth(const struct gpu_view *view, float depth);
/** World-space position of the middle of a pixel of a depth image; false: sky. */
bool list_position_of(const struct gpu_view *view, const float *depth, uint32_t x, uint32_t y, double out[3]);

/** Normals as the G-buffer has them: octahedral, unsigned 16 bits a part, 0 .. 1 is -1 .. 1. */
void pack_normal(const double normal[3], uint16_t out[4]);
void unpack_normal(const uint16_t in[4], double out[3]);

#endif
