/* SPDX-License-Identifier: MIT */
/**
 * Undoes a lens: red, green and blue of each pixel of the display look in directions of their own (Oculus best practices; Vlachos, "Advanced VR
 * Rendering", GDC 2015). Directions come from a mesh that bends only what its corners show, or from the polynomial for each pixel. All layers are looked up in
 * one pass, each at its own resolution, and blended in linear light. Cost: three texels of each layer for each pixel of the display.
 */
#ifndef FNL_PASSES_LENS_H
#define FNL_PASSES_LENS_H

#include "fanal/compositor.h"
#include "graph/graph.h"
#include "passes/stereo/lens_shared.h"
#include "passes/stereo/reproject_shared.h"

enum { LENS_VERTICES = (LENS_QUADS + 1) * (LENS_QUADS + 1), LENS_CELLS = LENS_QUADS * LENS_QUADS };

/** What a display's tangents show in a channel. */
vec2 lens_bend(const fnl_lens *lens, vec2 at, uint32_t channel);
struct gpu_lens_eye lens_eye(const fnl_display_eye *eye, vec2 source_size);
void lens_mesh(const fnl_display_eye *eye, struct gpu_lens_vertex vertices[LENS_VERTICES]);
/** Writes the quads that show something: with `trim` not those all of whose triangles lie in what is never seen, for all channels. Returns their number. */
uint32_t lens_cells(const fnl_display_eye *eye, const struct gpu_lens_vertex vertices[LENS_VERTICES], bool trim, uint32_t cells[LENS_CELLS]);

/** Of a picture that was rendered for tangents `rendered` (left, right, down, up), looked at after a turn: `turn` takes directions of now to those of then. */
struct gpu_lens_layer lens_picture(vec4 rendered, const mat4 *turn);
/** Of a rectangle in the space of the eye; false where it is seen from behind or from the side. */
bool lens_quad(const mat4 *pose, float width, float height, struct gpu_lens_layer *out);

struct lens_params {
    const char *name;
    struct gpu_lens_eye eye;
    const struct gpu_lens_layer *layers; /* copied; the graph does not know of their images but for these: */
    graph_image images[FNL_LAYERS_MAX + 1]; /* id 0: `image` of the layer stays */
    uint32_t layer_count;
    VkDeviceAddress vertices, cells; /* of the mesh; 0: for each pixel */
    uint32_t cell_count;
    graph_buffer count; /* id 0: nothing is counted */
    uint32_t x, width;  /* of the eye's part of the target, whose height is the target's */
    uint32_t view;      /* fnl_display_view */
    bool encode, clear;
};
void lens_add(gpu_device *device, struct graph *graph, const struct lens_params *params, graph_image target);

/** A picture as it would be seen from where the eye is now; `to_new` takes points from the space of the eye then to that of now. RGBA16F. */
graph_image reproject_add(gpu_device *device, struct graph *graph, const char *name, const struct gpu_reproject_push *push, graph_image picture, graph_image depth);

#endif
