/* SPDX-License-Identifier: MIT */
/** What a frame did and took, in numbers. */
#ifndef FANAL_STATS_H
#define FANAL_STATS_H

#include "fanal/frame.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct fnl_pass_time {
    const char *name; /**< as the frame graph names it */
    double milliseconds;
} fnl_pass_time;

typedef struct fnl_frame_stats {
    /* ---- lights ---- */

    /** All point, spot and shaped lights, and those whose bounds touch the view; for `all` lists both are the same. */
    uint32_t lights_total, lights_in_view;
    /** Memory of the light lists; the part of it that this frame's lights and cells fill; pairs of a cell and a light. */
    uint64_t list_bytes, list_used_bytes, list_entries;
    /** Cells of the lists, and those whose lights did not fit into the pool in this frame: they use coarser lists, of about a hundredth of the
        screen. */
    uint32_t cells, overflow_cells;
    /** Always 0: no light is ever lost. */
    uint32_t lights_dropped;
    /** Whether the next five were counted (fnl_frame.count_lights). */
    bool evaluations_counted;
    /** Points shaded with coarser lists, or with all lights: in cells that overflowed, and with MSAA also off the surfaces of their cell or outside
        the view. Not counted by light-prepass, low-res and inferred. */
    uint64_t unserved_points;
    /** Lights visited by shaded fragments, and those of them that reach the surface: the least that any list could visit. Without directional
        lights. */
    uint64_t evaluations, evaluations_useful;
    /** Lights that a pixel visits, on average and at most. */
    double mean_per_pixel;
    uint32_t max_per_pixel;
    /** backface lists: lights in view that are behind the surfaces of every tile they touch. */
    uint64_t lights_behind;
    /** Paths that separate light from materials, or store layers of lights: memory of what replaces the G-buffer. Without depth and radiance, and
        without the ids of light-indexed, which are in list_bytes. */
    uint64_t light_bytes;
    /** deferred-volumes: draw calls of the volumes: 2, and 2 for each light that the shape stencil draws by itself. */
    uint32_t light_draws;

    /* ---- geometry ---- */

    /** Draw calls; an indirect one counts once. Those that draw several views at once count in the first of them. */
    uint32_t draws;
    /** Items, which are primitives of instances; those left after culling; those in view that are occluded (with occlusion). */
    uint64_t items, items_visible, items_occluded;
    /** Visible items drawn as a whole because a pool of culling was too small in this frame. */
    uint32_t items_whole;
    /** Visible items that the G-buffer layout cannot hold and a forward pass shades; known with count_lights. */
    uint64_t items_forward;
    /** Triangles of visible items, opaque and alpha-masked; known with count_lights. */
    uint64_t triangles_visible;
    /** Opaque and alpha-masked triangles of all instances, and with culling by clusters or triangles what became of them: drawn, outside the view,
        facing away, between samples, occluded. Objects that some lists draw in their own way (batches, multipass) count all the same. */
    uint64_t triangles_total, triangles_drawn, triangles_outside, triangles_back, triangles_small, triangles_occluded;
    /** Clusters of all instances, and those of which something is drawn. */
    uint64_t clusters_total, clusters_drawn;
    /** What drew the clusters: vertex or mesh. */
    fnl_geometry geometry;

    /* ---- what the shading paths did ---- */

    /** Memory of the G-buffer's targets, including its mask; without depth and radiance; 0 without a G-buffer. */
    uint64_t gbuffer_bytes;
    /** virtual-texturing: pages of the scene; room in the atlas; pages that the last frame wanted; pages in the atlas; pages filled for this frame;
        wanted pages without room; pages replaced by others; memory of the atlas. */
    uint32_t atlas_pages, atlas_capacity, atlas_wanted, atlas_resident, atlas_filled, atlas_missing, atlas_evicted;
    uint64_t atlas_bytes;
    /** deferred.class_blocks: blocks by class: bit 0 some pixel has lights, 1 some pixel is metal, 2 all pixels are shaded; [8]: nothing to shade. */
    uint32_t shading_blocks[9];
    /** Transparency linked: blended fragments that nothing opaque occludes, the most in one pixel, and pixels drawn as sorted because the pool was too
        small in this frame. Bytes: memory of linked and weighted besides the picture. */
    uint64_t blend_fragments, blend_bytes;
    uint32_t blend_longest, blend_overflow;
    /** visibility with sort or MSAA: classes that occur; pixels, or triangles of pixels, to shade. */
    uint32_t visibility_classes, visibility_entries;
    /** visibility: writes of the id pass; known with count_lights. */
    uint32_t visibility_fragments;
    /** MSAA in deferred, deferred texturing and visibility: pixels that show a surface in some sample, and pixels whose samples show more than one
        thing, sky being one. */
    uint32_t msaa_pixels, msaa_edge_pixels;
    /** Surfaces of all pixels, where msaa_groups and msaa_tolerance merge some into one; samples that show a surface; surfaces shaded, known with
        count_lights. In visibility each triangle is a surface. */
    uint64_t msaa_surfaces, msaa_samples, msaa_shaded;
    /** coarse: blocks that show a surface; blocks shaded once; blocks that are not, because of depths or triangles, normals, materials; pixels that
        show a surface; pixels and blocks shaded; with ao_radius, how often occlusion was computed. */
    uint32_t coarse_blocks, coarse_shared, coarse_by_depth, coarse_by_normal, coarse_by_material, coarse_pixels, coarse_shaded;
    uint32_t coarse_ao_shaded;
    struct fnl_dais_stats {
        uint64_t bytes;           /**< filled by this frame's references, triangles, cache and lists */
        uint32_t triangles;       /**< stored, including those that the cache had forgotten */
        uint32_t unique;          /**< different ones among them; known with count_lights */
        uint32_t cache_failures;  /**< stored again because a cache bucket stayed locked */
        uint32_t overflow;        /**< fragments that found a pool full; if any, the frame was shaded forward, and the pool grows for the next */
        uint32_t list_elements;   /**< FNL_DAIS_LIST: triangles that cover only part of their pixel */
        uint32_t shading_samples; /**< with multirate: places where ambient light was computed */
        uint32_t shaded;          /**< triangles of all pixels, each of which is shaded once; known with count_lights */
    } dais;
    /** mobile: the passes shared one scope, and tone mapping was in it. */
    bool mobile_merged, mobile_tonemapped;
    /** Decals that are shown, baked ones left out, and those whose bounds touch the view. */
    uint32_t decals_total, decals_in_view;
    /** Entries of the decal list, or of the tiles of decals over the G-buffer. */
    uint64_t decal_entries;
    /** Cells, or pixels of decals over the G-buffer, that tested all decals because the pool was too small in this frame. */
    uint32_t decal_overflow;

    /* ---- memory and time ---- */

    /** What the passes move between images and memory, computed from formats and load and store operations, not measured: an attachment that is loaded or
        stored, and an image that a shader reads or writes, counts as a whole each time. Copies, textures and buffers are left out.
        fnl_renderer_print() with FNL_PRINT_TRAFFIC lists it by pass. */
    uint64_t image_bytes_read, image_bytes_written;
    /** Attachments that never leave tile memory on GPUs that have it; lazily allocated memory among them, and what the driver had to back. */
    uint64_t tile_bytes, lazy_bytes, lazy_committed_bytes;
    /** Device memory in use, and its greatest amount so far. */
    uint64_t device_bytes, device_peak_bytes;
    /** Recording and submitting. */
    double cpu_milliseconds;
    /** Sum of all passes; 0 without timers. */
    double gpu_milliseconds;
    /** The exposure used, EV100. */
    float ev;

    /* ---- what the frame was rendered with ---- */

    /** The choice of auto, or what was asked for. Lists are mesh where these stand in for batches or multipass, which have no MSAA and a limited number
        of passes. */
    fnl_shading shading;
    fnl_light_lists lists;
    /** auto has not decided yet; false with pin_choice. */
    bool choosing;
    /** Pipelines of auto's candidates that are still being compiled in the background; until then it does not measure. */
    uint32_t pipelines_pending;
    /** Pipelines that the frame needed and had to compile itself or to wait for: a hitch. fnl_renderer_warm makes them ahead. */
    uint32_t pipelines_made;
    /** Pipelines made for the device so far, and those of them that the driver found in its cache file (0 where it does not tell). */
    uint32_t pipelines_total, pipelines_cached;
    /** What auto chose by, or "". Owned by the renderer, valid until the next call on it. */
    const char *choice;
    /** The passes in order. Owned by the renderer, valid until the next call on it. */
    uint32_t pass_count;
    const fnl_pass_time *passes;
    /** The numbers of each view of a frame with several: those of lights, geometry and shading paths, and ev, are the view's own, the rest is the frame's.
        Here outside are those of the first view. 0 and NULL for a frame with one. Owned by the renderer, valid until the next call on it. */
    uint32_t view_count;
    const struct fnl_frame_stats *views;
} fnl_frame_stats;

#ifdef __cplusplus
}
#endif
#endif
