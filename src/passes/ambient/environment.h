/* SPDX-License-Identifier: MIT */
/**
 * Light from all around, made of a picture by longitude and latitude: a cube map whose mips hold what surfaces of growing roughness mirror,
 * prefiltered by the GGX lobe seen from the front; what diffuse surfaces reflect, as nine spherical harmonics; and a table of how much of it the
 * specular lobe reflects, so that the two parts of the integral are multiplied (Karis 2013, "Real Shading in Unreal Engine 4"). Shaders find it by
 * shaders/environment.glsl. Samples are at fixed places: the same picture gives the same bytes.
 *
 * Cost: nothing in frames that make none. Memory: 64 bytes for each texel of a face; compressed 8.
 */
#ifndef FNL_PASSES_AMBIENT_ENVIRONMENT_H
#define FNL_PASSES_AMBIENT_ENVIRONMENT_H

#include "environment_shared.h"
#include "graph/graph.h"
#include "lighting/lighting_shared.h"

enum { ENVIRONMENT_MIPS_MOST = 8 }; /* of the cube */

/** On the device. */
struct environment_maps {
    struct gpu_image cube;  /* RGBA16F or BC6H; the last mip has 8 texels a side */
    struct gpu_image table; /* RGBA16F: reflectance, which mip of the cube, and the reflectance of fibres */
    struct gpu_image levels; /* RGBA16F: the picture as a cube map with all mips; only until frames that filter it are over */
    struct gpu_image parts[6 * ENVIRONMENT_MIPS_MOST]; /* of levels: its mips, in each of them the faces; so too, and only where the cube is compressed */
    struct gpu_image picture; /* RGBA16F; so too */
    struct gpu_buffer light; /* struct gpu_environment */
    /* The cube, the light and the table as bytes, mapped: of maps that were made before, or where a frame that filters puts them; until such frames are over. */
    struct gpu_buffer kept;
    bool is_kept; /* `kept` holds them: there is nothing to filter */
    uint32_t side;
    uint32_t table_mip; /* the last mip that the table is for; 0: not yet made */
};

/** Reflection probes, as one view sees them. */
struct environment_reflections {
    VkDeviceAddress set; /* struct gpu_reflection_set; 0: there are none */
    graph_buffer reflections, bounds, diffuse;
    graph_buffer cells, ids, spare; /* of their list; or id 0 */
};

/** For passes that shade: environment_use(). ids 0: there is none; `table` may be alone. */
struct environment_light {
    graph_image cube, table;
    graph_buffer light;
    graph_buffer blocks; /* of the cube, where it is compressed and filtered in this frame (passes/compress/bc6h.h) */
    graph_buffer texels; /* of the cube, as environment_maps_shared.h lays them out; id 0 in frames that do not filter */
    struct environment_reflections reflections;
    bool conserving; /* surfaces conserve energy (FNL_ENERGY_CONSERVING), by the table */
};
/** What shaders are told of it: bits beside the kind of a list. */
static inline uint32_t environment_kind(const struct environment_light *light) {
    return (light->cube.id ? GPU_LIGHTING_ENVIRONMENT : 0) | (light->reflections.set ? GPU_LIGHTING_REFLECTIONS : 0) |
           (light->conserving ? GPU_LIGHTING_CONSERVING : 0);
}

/** Sides of the cube map for a picture of this width: a power of two, 128 .. 1024. */
uint32_t environment_side(uint32_t picture_width);
/**
 * The perceptual roughness that a mip is filtered for. Between two mips shading blends so that the mean cosine of directions to the lobe's axis is
 * right (the table has the mip for each roughness): then light that changes slowly is blended exactly.
 */
float environment_roughness(uint32_t mip, uint32_t last_mip);
/** The last mip that shading reads. */
static inline uint32_t environment_last_mip(uint32_t side) { return (uint32_t)log2f((float)side) - 3; }

/**
 * Outside of frames: makes the images, and sends the picture: halves, RGBA, `width` times `height`. What was there goes when its frames are over.
 * `compressed`: the cube is of BC6H, where fnl_device_info.texture_compression.
 */
fnl_result environment_prepare(gpu_device *device, const uint16_t *pixels, uint32_t width, uint32_t height, bool compressed,
                               struct environment_maps *maps);
/** The bytes of `kept`, for a cube of `side` texels. */
uint64_t environment_kept_bytes(uint32_t side, bool compressed);
/**
 * Instead of filtering a picture: outside of frames, makes room in `kept` for the bytes that a frame that filtered left there. The caller writes them,
 * from the first on, and sets is_kept; or calls environment_prepare().
 */
fnl_result environment_prepare_kept(gpu_device *device, uint32_t side, bool compressed, struct environment_maps *maps);
/** After environment_prepare(): the frame that filters leaves its maps in `kept`. */
fnl_result environment_keep(gpu_device *device, struct environment_maps *maps);
/** Changes where the same picture may give other bytes than before. */
uint64_t environment_version(void);
/** The cube alone, of `side` texels, a power of two of at least 16, and what filtering it needs: for reflection probes. */
fnl_result environment_prepare_cube(gpu_device *device, uint32_t side, bool compressed, struct environment_maps *maps);
/** Memory of the cube. */
uint64_t environment_cube_bytes(const struct environment_maps *maps);
/** The table alone, for layered materials and reflection probes where there is no environment. */
fnl_result environment_prepare_table(gpu_device *device, struct environment_maps *maps);
void environment_finish_maps(gpu_device *device, struct environment_maps *maps);
/** What only filtering needs. Frames that are under way may still use it. */
void environment_release(gpu_device *device, struct environment_maps *maps);

/** Declares what a frame shades with; `make`: the maps are made in this frame, or copied from `kept`. */
struct environment_light environment_add(struct graph *graph, gpu_device *device, struct environment_maps *maps, bool make);
/** Of the table alone; `fill`: it is made in this frame. */
struct environment_light environment_add_table(struct graph *graph, struct environment_maps *maps, bool fill);
/** What six cameras see: radiance, and its largest component, by which the cube's halves are scaled. */
struct environment_faces {
    graph_buffer radiances, peak;
};
struct environment_faces environment_faces_create(struct graph *graph, uint32_t side);
/** A face (+X, -X, +Y, -Y, +Z, -Z) from what a camera has seen that looks that way; its upper edge is the face's first row. */
void environment_face_add(struct graph *graph, gpu_device *device, uint32_t side, uint32_t face, graph_image picture,
                          const struct environment_faces *faces);
/** Fills the cube of environment_prepare_cube() with what all six have seen, and maps->light. */
void environment_faces_filter(struct graph *graph, gpu_device *device, const struct environment_maps *maps, const struct environment_faces *faces);
/** Declares that a pass shades in compute or fragment shaders (GRAPH_READ_COMPUTE, GRAPH_READ_FRAGMENT). */
void environment_use(struct graph_pass *pass, const struct environment_light *light, enum graph_use use);
struct gpu_frame;
/** Tells a frame how the maps are read. Scale and turn are left alone. */
void environment_tell(gpu_device *device, struct gpu_frame *out);
/** Tells a frame's shaders where the maps are; `out` lies in memory of the frame (gpu_frame_allocate). */
void environment_put(struct graph *graph, const struct environment_light *light, struct gpu_frame *out);

#endif
