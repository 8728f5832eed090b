/* SPDX-License-Identifier: MIT */
/** What a frame did and took, in numbers. */
#ifndef FANAL_STATS_H
#define FANAL_STATS_H

#include "fanal/frame.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct fnl_pass_time {
    const char *name;
    double milliseconds;
} fnl_pass_time;

typedef struct fnl_frame_stats {
    /** Light lists. Counts are exact and of this very frame. */
    uint32_t lights_total,
        lights_in_view; /**< in_view counts those whose bounds touch the view; for `all` lists it is the total */
    uint64_t list_bytes, list_entries;
    uint64_t list_used_bytes;       /**< the part of list_bytes that this frame's lights and cells fill */
    uint32_t cells,
        overflow_cells; /**< cells that used coarser lists, of about a hundredth of the screen, as the pool was too small in this frame */
    uint32_t lights_dropped;        /**< always 0: that is the contract */
    bool evaluations_counted;       /**< the next three, and mean and maximum, are only known with fnl_frame.count_lights */
    uint64_t unserved_points; /**< points shaded with coarser lists, or all lights: in cells that overflowed; with MSAA also off the surfaces of
                                 their cell or out of the view. Not counted by light-prepass, low-res and inferred */
    uint64_t evaluations;           /**< lights visited by shaded fragments, directional lights left out */
    uint64_t evaluations_useful; /**< those that reach the fragment's surface point: the least that any list could visit */
    uint64_t lights_behind;      /**< backface lists: lights in view that are behind the surfaces of every tile they touch */
    double mean_per_pixel;
    uint32_t max_per_pixel;
    uint32_t draws;                /**< draw calls (indirect ones count once) */
    uint64_t items, items_visible; /**< primitives of instances, and those left after culling */
    /**
     * Of what stands in place of a G-buffer where light is kept apart from materials, or in layers of lights: surfaces as lights need them,
     * sums of light, layers. Depth and radiance of the frame's size are left out; 0 with other orders. Ids of light-indexed are in list_bytes.
     */
    uint64_t light_bytes;
    uint32_t
        light_draws; /**< with deferred-volumes, draw calls of the volumes: 2, and 2 for each light that the shape stencil draws alone */
    uint64_t
        gbuffer_bytes; /**< of the G-buffer's targets in this frame, its mask included; depth and radiance are left out; 0 without one */
    /**
     * With FNL_SHADING_VIRTUAL_TEXTURING: pages that the scene has, that the atlas has room for, that the frame before wanted, that are
     * there, that were filled for this frame, that were wanted and found no room, and that gave way to others; bytes of the atlas.
     */
    uint32_t atlas_pages, atlas_capacity, atlas_wanted, atlas_resident, atlas_filled, atlas_missing, atlas_evicted;
    uint64_t atlas_bytes;
    uint64_t
        items_forward; /**< visible items that the G-buffer's layout cannot hold and a forward pass lights; known with count_lights */
    uint64_t triangles_visible; /**< of opaque and alpha-masked surfaces; known with count_lights */
    /**
     * Opaque and alpha-masked triangles of all instances, and with clusters or triangles of fnl_culling what became of them: drawn, out of the view,
     * facing away, between samples, occluded (with occlusion). Those of objects that one list or another draws in its own way (batches, multipass) count all the same.
     */
    uint64_t triangles_total, triangles_drawn, triangles_outside, triangles_back, triangles_small, triangles_occluded;
    uint64_t clusters_total, clusters_drawn; /**< clusters of all instances, those of which something is drawn */
    uint64_t items_occluded; /**< with occlusion: items in view that others hide */
    fnl_geometry geometry;   /**< what drew the clusters: vertex or mesh */
    uint32_t items_whole; /**< visible items that were drawn as a whole because a pool was too small in this frame */
    /** With class_blocks: blocks by class, bit 0 some pixel has lights, 1 some is metal, 2 all are shaded; [8]: nothing to shade. */
    uint32_t shading_blocks[9];
    /**
     * With FNL_TRANSPARENCY_LINKED: blended fragments that nothing opaque hides, the most in one pixel, and pixels that were
     * drawn as sorted because the pool was too small in this frame. Bytes: what linked and weighted take beside the picture.
     */
    uint64_t blend_fragments, blend_bytes;
    uint32_t blend_longest, blend_overflow;
    /** With FNL_SHADING_VISIBILITY and fnl_visibility_options.sort or MSAA: classes that occur, and pixels, or triangles of pixels, to shade. */
    uint32_t visibility_classes, visibility_entries;
    uint32_t visibility_fragments; /**< how often the id pass wrote; known with count_lights */
    /** With FNL_SHADING_DEFERRED and those of deferred texturing and MSAA, and FNL_SHADING_VISIBILITY, where each triangle is a surface. */
    uint32_t msaa_pixels,   /**< pixels that show a surface in some sample */
        msaa_edge_pixels;   /**< pixels whose samples show more than one thing, sky being one */
    uint64_t msaa_surfaces, /**< surfaces of all pixels; what msaa_groups and msaa_tolerance merge counts once */
        msaa_samples,       /**< samples that show a surface */
        msaa_shaded;        /**< how often a surface was shaded; known with count_lights */
    /** With FNL_SHADING_COARSE: blocks that show some surface; those lit once; those that are not for the sake of depths or triangles,
        normals, materials; pixels that show a surface; how often one was lit, for itself or its block. */
    uint32_t coarse_blocks, coarse_shared, coarse_by_depth, coarse_by_normal, coarse_by_material, coarse_pixels, coarse_shaded;
    uint32_t coarse_ao_shaded; /**< with ao_radius: how often occlusion was found */
    /** With FNL_SHADING_DAIS. */
    struct fnl_dais_stats {
        uint64_t bytes;           /**< of what this frame's references, triangles, cache and lists fill */
        uint32_t triangles;       /**< stored: each that is seen once, and those that the cache had forgotten */
        uint32_t unique;          /**< different ones among them; known with count_lights */
        uint32_t cache_failures;  /**< stored because a bucket of the cache stayed locked */
        uint32_t overflow;        /**< fragments that found a pool full and were shaded forward; the pool grows by the next frame */
        uint32_t list_elements;   /**< FNL_DAIS_LIST: triangles of pixels that they do not cover wholly */
        uint32_t shading_samples; /**< with multirate: places where ambient light was found */
        uint32_t shaded;          /**< triangles of all pixels, each of which is shaded once; known with count_lights */
    } dais;
    uint32_t decals_total,
        decals_in_view; /**< decals that are shown (baked ones left out); boxes and volumes whose bounds touch the view */
    uint64_t decal_entries; /**< of the list over them, and of the tiles of the G-buffer's way */
    uint32_t
        decal_overflow; /**< cells, or pixels of the G-buffer's way, that went through all decals as the pool was too small */
    /**
     * What the frame's passes move between images and memory, by formats and load and store operations and not measured: an attachment
     * that is loaded or stored, an image that a shader reads or writes, counts as a whole each time; copies, textures and buffers are
     * left out. fnl_renderer_print_traffic has it by passes.
     */
    uint64_t image_bytes_read, image_bytes_written;
    uint64_t tile_bytes; /**< of attachments that never leave tile memory on GPUs that have it */
    uint64_t lazy_bytes,
        lazy_committed_bytes; /**< lazily allocated memory of those, and what of it the driver had to back */
    bool mobile_merged;       /**< FNL_SHADING_MOBILE: the passes shared one scope */
    bool mobile_tonemapped;   /**< and tone mapping was in it */
    double cpu_milliseconds;  /**< recording and submitting */
    double gpu_milliseconds;  /**< sum of all passes; 0 without timers */
    float ev;                 /**< exposure used, EV100 */
    uint64_t device_bytes, device_peak_bytes;
    fnl_shading shading; /**< what the frame was rendered with: the choice of auto, or what was asked for */
    fnl_light_lists
        lists; /**< likewise; mesh where that stood in for batches or multipass, which have no MSAA and only so many passes */
    bool choosing;      /**< auto has not decided yet; false with pin_choice */
    /** Pipelines for candidates of auto that are still to be made in the background; as long as there are any it does not measure. */
    uint32_t pipelines_pending;
    const char *choice; /**< what auto chose by, or ""; owned by the renderer, valid until its next call */
    uint32_t pass_count;
    const fnl_pass_time *passes; /**< in order, owned by the renderer, valid until the next call on it */
} fnl_frame_stats;

#ifdef __cplusplus
}
#endif
#endif
