/* SPDX-License-Identifier: MIT */
/**
 * Light lists: which lights reach which pixel. A builder turns bounds (struct gpu_entity_bounds) and a view into a struct light_list; every
 * shading order reads it through shaders/lights/iterate.glsl and never knows which builder made it. Bounds may be those of lights, of decals,
 * or of anything else that fills part of space: all builders serve them alike.
 *
 * All builders keep the contract: lists ascend by light index, hold every light whose volume touches a pixel's surface, are counted
 * exactly, and a cell that the pool cannot hold uses the spare list in that frame: coarse masks over all lights, which need no pool.
 * A frame that holds several lists (of views, of decals) adds each under names of its own (graph_push_names).
 */
#ifndef FNL_PASSES_LIGHT_LIST_H
#define FNL_PASSES_LIGHT_LIST_H

#include "graph/graph.h"
#include "lighting/lighting_shared.h"

/** Lights, or the bounds of other entities that lists are built over, on the device. */
struct light_set {
    graph_buffer buffer;      /* lights, bounds, shapes and planes, for their hazards: what changes one of them changes this */
    VkDeviceAddress entities; /* struct gpu_entity_bounds[local_count] */
    VkDeviceAddress shapes;   /* where gpu_entity_bounds.shape counts from; 0: none has a shape */
    VkDeviceAddress planes;   /* of hulls; 0: none has one */
    VkDeviceAddress lights;   /* struct gpu_light[directional_count + local_count], for shading; 0: no light is among the bounds */
    VkDeviceAddress lobes;    /* for area lights (shaders/lights/area.glsl): shaders get GPU_LIGHTING_AREA_LIGHTS; 0: there are none */
    VkDeviceAddress masks;    /* uint[directional_count + local_count], 8 bits each: shaders get GPU_LIGHTING_MASKS; 0: all lights affect all surfaces */
    VkDeviceAddress profiles; /* of lights that have one (shaders/lights/profile.glsl): shaders get GPU_LIGHTING_PROFILES; 0: none has */
    uint32_t directional_count, local_count; /* local_count: bounds */
    uint32_t unlit_count;     /* places without a light, and hidden lights */
    bool simple;              /* every light is a sphere or a cone without a hull: shaders get GPU_LIGHTING_SIMPLE */
    VkDeviceAddress address;  /* struct gpu_light_set, from light_set_send(); 0: each list sends its own */
};
/** Sends a complete set to the device, for all lists of a frame. */
void light_set_send(gpu_device *device, struct light_set *set);
/** The block that light_set_send() sends. */
struct gpu_light_set light_set_block(const struct light_set *set);

/** What a list is built from. */
struct light_input {
    struct light_set set;
    uint32_t kinds;         /* bits 1 << GPU_ENTITY_…: what the list is for; bounds of other kinds are left out */
    VkDeviceAddress view;   /* struct gpu_view */
    uint32_t width, height; /* pixels */
    bool keep_unseen;       /* lights out of the view count as in view */
    bool scattered;         /* points may be shaded off the surfaces that depth shows (MSAA): shaders get GPU_LIST_SCATTERED */
    bool spheres_only;      /* no builder tests cones, rectangles on the screen, or which way cells face: no reaches */
    enum graph_queue queue; /* that GPU builders run on: async pays where nothing of the frame is waited for */
};

struct light_list {
    uint32_t kind;           /* GPU_LIST_…, with GPU_LIST_SCATTERED: part of the specialization constant LIGHTING_ID */
    VkDeviceAddress header;  /* struct gpu_light_list */
    graph_buffer lights;     /* light_set.buffer */
    graph_buffer cells, ids; /* id 0: none, or not made by the GPU */
    graph_buffer extra;      /* or id 0 */
    graph_buffer bounds;     /* of cells, where scattered points compare themselves with them; or id 0 */
    graph_buffer spare;      /* the spare list, or id 0 */
    uint32_t cell_count;
    uint64_t byte_count;  /* of cells and pool */
    uint64_t fixed_bytes; /* the part of byte_count that does not depend on the number of entries */
    uint32_t entry_bytes; /* what an entry of the pool takes */
    graph_buffer cones,
        culled; /* of backface lists: struct gpu_cone of each tile; one uint, lights behind all that they touch. Or id 0 */
    /* Where the counts of this frame are found: on the GPU in `totals` (struct light_totals), or already known. */
    graph_buffer totals;
    bool totals_known;
    struct light_totals {
        uint32_t in_view, entries, overflow_cells;
    } known;
};

/** The kind without the bits beside it. */
static inline uint32_t list_kind(const struct light_list *list) { return list->kind & GPU_LIST_KINDS; }

/** Declares that a pass iterates over the list in fragment or compute shaders. */
void light_list_use(struct graph_pass *pass, const struct light_list *list, enum graph_use use);

/** The reference: every light, every pixel. */
struct light_list light_list_all_add(struct graph *graph, gpu_device *device, const struct light_input *input);

/** The bounds that are in view, shared by all builders of a view. */
struct lights_in_view {
    graph_buffer sums;    /* local_count + 1; the last is the number in view */
    graph_buffer ids;     /* places of the bounds, ascending */
    graph_buffer bounds;  /* struct gpu_bound: their spheres in view space */
    graph_buffer reaches; /* struct gpu_reach, view space; or id 0 */
};
struct lights_in_view lights_in_view_add(struct graph *graph, gpu_device *device, const struct light_input *input);

/** How a sphere is tested against a tile. */
enum tile_bounds {
    TILE_PLANES,    /* four side planes and two depths (ES-38) */
    TILE_BOX,       /* the planes, then the box round the tile's piece of the view (ES-39) */
    TILE_RECTANGLE, /* the sphere's rectangle on the screen against the tile's, and two depths (ES-15) */
};

/**
 * Keeps the counts of a list for the statistics: the last of `sum_count` prefix sums is the number of entries, overflow[0] that of cells
 * that did not fit. For builders. The pass is called "`what` totals".
 */
graph_buffer light_totals_add(struct graph *graph, const char *what, const struct light_input *input,
                              const struct lights_in_view *in_view, graph_buffer sums, uint32_t sum_count,
                              graph_buffer overflow);

/**
 * Makes the spare list of lights_shared.h for lists with these headers if overflow[0] is not 0, or always. For builders. Cost: 16 bytes a
 * light; 128 tests of whole numbers for each light where it is made, next to nothing where it is not. The pass is called "`what` spare".
 */
graph_buffer light_spare_add(struct graph *graph, const char *what, const struct light_input *input,
                             const struct lights_in_view *in_view, graph_buffer overflow,
                             struct gpu_light_list *const headers[], const VkDeviceAddress addresses[], uint32_t header_count,
                             bool always);

struct tiled_params {
    uint32_t tile_size;        /* pixels, a multiple of 8; default 16 */
    enum tile_bounds bounds;   /* default TILE_BOX */
    bool min_depth, max_depth; /* cull lights in front of the nearest / behind the farthest pixel (ES-43); default true */
    bool cone_tests;           /* spots and wedges whose sphere touches are tested as cones (ES-40); default true */
    uint32_t pool_capacity;    /* entries that the ids of all tiles may take; default 2^20 */
    /**
     * For the list of blended surfaces (ES-44): the depth of the nearest of them, with as many samples as `depth`. Tiles then reach from
     * the nearest blended surface that shows to the farthest opaque one behind such surfaces, or to infinity where there is sky; tiles
     * without any are empty. id 0 (default): a list of what `depth` holds.
     */
    graph_image front;
};
struct tiled_params tiled_params_default(void);
/**
 * Tiles of the screen (Olsson & Assarsson 2011, Harada 2012). `depth` is the depth of everything opaque (id 0: none, then tiles reach
 * from the viewer to infinity); single- or multisampled.
 */
struct light_list tiled_add(struct graph *graph, gpu_device *device, const struct light_input *input,
                            const struct lights_in_view *in_view, graph_image depth, const struct tiled_params *params);

/**
 * Tiles with two lists each, for the nearer and the farther half of their depth range (the "HalfZ" of AMD's TiledLighting11 sample, 2014);
 * a pixel takes the list of its half. Bounds of depth are always on. Without depth these are plain tiles. So do the next ones.
 */
struct light_list halfz_add(struct graph *graph, gpu_device *device, const struct light_input *input,
                            const struct lights_in_view *in_view, graph_image depth, const struct tiled_params *params);
/** Tiles that drop lights which touch none of the 32 depth cells that hold pixels (Harada 2012). */
struct light_list tiled25d_add(struct graph *graph, gpu_device *device, const struct light_input *input,
                               const struct lights_in_view *in_view, graph_image depth, const struct tiled_params *params);
/**
 * Tiles whose entries carry the depths between which the light is in the tile; a pixel visits those that hold its own (Bezrati 2014). Needs
 * no depth; of the parameters only tile size, cone tests and pool count. Cost: 8 bytes an entry.
 */
struct light_list enhanced_add(struct graph *graph, gpu_device *device, const struct light_input *input,
                               const struct lights_in_view *in_view, const struct tiled_params *params);

struct clustered_params {
    uint32_t tile_size; /* pixels; default 64 */
    uint32_t slices;    /* 1 .. 1024; default 32 */
    float near,
        far; /* view depths, metres, 0 < near < far: slice 0 is all nearer than its end, the last all beyond its start; default 0.5, 100 */
    bool linear;     /* slices of equal depth between near and far; default false: each as many times deeper as the last */
    bool cone_tests; /* spots and wedges whose sphere touches are tested as cones; default true */
    uint32_t pool_capacity; /* default 2^20 */
};
struct clustered_params clustered_params_default(void);
/** Clusters (Olsson et al. 2012; Persson 2013), counted and filled on the GPU. Needs no depth. */
struct light_list clustered_add(struct graph *graph, gpu_device *device, const struct light_input *input,
                                const struct lights_in_view *in_view, const struct clustered_params *params);

struct zbin_params {
    uint32_t tile_size;     /* pixels; default 16. Doubled while the table would take more than 64 MiB */
    uint32_t bins;          /* 1 .. 65536; default 128 */
    float near, far;        /* view depths, metres, as those of clusters; default 0.5, 100 */
    bool linear;            /* equal depths; default false: each is as many times deeper as the last */
    uint32_t pool_capacity; /* words of 32 lights that the masks of all tiles and bins may take; default 2^20 */
};
struct zbin_params zbin_params_default(void);
/**
 * Tiles times bins of depth, each a bit mask over the lights in view (Drobot 2017): a pixel visits what is in both. Needs no depth. Cost:
 * two atomic operations for each tile of each zone and each bin that a light touches; per pixel two reads for each 32 lights that its tile, in
 * its zone, and its bin share. In the source lights are numbered by depth, so that a bin is a range of numbers; here they keep the order of their index, which all
 * lists promise, so a bin is a mask as well.
 */
struct light_list zbin_add(struct graph *graph, gpu_device *device, const struct light_input *input,
                           const struct lights_in_view *in_view, const struct zbin_params *params);

/** Zones of neighbouring bins, of which each tile has a mask each: 1 with few lights, more with more, at most 16. */
uint32_t zbin_zones(const struct light_input *input, const struct zbin_params *params);

/** The header of a list, with only its lights and view; builders give it the addresses of their buffers by graph_put_address. NULL: no memory. */
struct gpu_light_list *light_list_header(gpu_device *device, const struct light_input *input, VkDeviceAddress *out_address);

/** Whether any list of these kinds may hold it, wherever the viewer is: what lights_in_view_add() asks first, for builders on the CPU. */
static inline bool bounds_are_listed(const struct gpu_entity_bounds *bounds, uint32_t kinds) {
    return bounds->radius > 0 && (kinds >> bounds->kind & 1);
}

#endif
