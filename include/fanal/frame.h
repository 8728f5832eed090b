/* SPDX-License-Identifier: MIT */
/** What a frame is rendered with. Options can also be set by name: fnl_frame_set() in fanal/options.h. */
#ifndef FANAL_FRAME_H
#define FANAL_FRAME_H

#include "fanal/energy.h"
#include "fanal/gbuffer.h"
#include "fanal/overlay.h"
#include "fanal/pixel.h"
#include "fanal/scene.h"
#include "fanal/shading.h"
#include "fanal/shading_options.h"
#include "fanal/shadows.h"
#include "fanal/stage.h"
#include "fanal/stereo.h"

#ifdef __cplusplus
extern "C" {
#endif

/** What is culled before it is drawn. The picture is the same. docs/techniques/culling.md compares them. */
typedef enum fnl_culling {
    FNL_CULLING_INSTANCES = 0, /**< instances outside the view */
    FNL_CULLING_CLUSTERS,      /**< also clusters of up to 124 triangles that are outside it, face away, or fall between samples */
    FNL_CULLING_TRIANGLES,     /**< also single triangles, by the same tests */
    FNL_CULLING_COUNT
} fnl_culling;

/** What draws the clusters that culling leaves. The picture is the same. docs/techniques/culling.md compares them. */
typedef enum fnl_geometry {
    FNL_GEOMETRY_VERTEX = 0, /**< vertex shaders, with an index buffer that culling writes */
    FNL_GEOMETRY_MESH,       /**< mesh shaders, a work group per cluster; needs fnl_device_info.mesh_shader and culling by clusters or triangles */
    FNL_GEOMETRY_AUTO,       /**< mesh shaders where a GPU has them; on CPU drivers they are several times slower, so vertex shaders there */
    FNL_GEOMETRY_COUNT
} fnl_geometry;

/** Whether occluded surfaces are culled. The picture is the same. docs/techniques/culling.md says what it costs and gains. */
typedef enum fnl_occlusion {
    FNL_OCCLUSION_OFF = 0,
    FNL_OCCLUSION_ON,
    FNL_OCCLUSION_AUTO, /**< on for scenes of a million triangles or more in 256 parts or more, in frames of one view without a debug view */
    FNL_OCCLUSION_COUNT
} fnl_occlusion;

/** Whether a frame draws several of its views at once (multiview). Pictures stay the same. docs/techniques/views.md compares the values. */
typedef enum fnl_multiview {
    FNL_MULTIVIEW_AUTO = 0, /**< neighbours of the array that see almost the same; not in forward-prepass */
    FNL_MULTIVIEW_OFF,      /**< each view by itself */
    FNL_MULTIVIEW_ON,       /**< up to 6 neighbours of the array, whatever they see */
    FNL_MULTIVIEW_COUNT
} fnl_multiview;

/** How blended surfaces (FNL_ALPHA_BLEND) that overlap in a pixel are composited. docs/techniques/transparency.md compares them. */
typedef enum fnl_transparency {
    FNL_TRANSPARENCY_SORTED = 0, /**< objects back to front by their centres: wrong where they intersect */
    FNL_TRANSPARENCY_WEIGHTED,   /**< in any order, by a mean weighted by distance; exact where one surface covers a pixel */
    FNL_TRANSPARENCY_LINKED,     /**< exact: the fragments of each pixel are listed and sorted */
    FNL_TRANSPARENCY_COUNT
} fnl_transparency;

/** How box and volume decals are applied to surfaces. Both ways give the same picture. docs/techniques/decals.md compares them. */
typedef enum fnl_decals {
    FNL_DECALS_LISTS = 0, /**< surfaces, blended ones too, look them up in a list while they are shaded */
    /** Boxes drawn over the finished G-buffer (in mobile close, not equal). Blended surfaces, paths without a G-buffer, and MSAA use lists all the same. */
    FNL_DECALS_GBUFFER,
    FNL_DECALS_OFF, /**< no decals, except those baked into textures */
    FNL_DECALS_COUNT
} fnl_decals;

/** What smooths edges besides MSAA. docs/techniques/antialiasing.md compares them. */
typedef enum fnl_antialiasing {
    FNL_ANTIALIASING_NONE = 0,
    FNL_ANTIALIASING_MLAA, /**< morphological antialiasing, as first published */
    FNL_ANTIALIASING_SMAA, /**< the same with diagonals, sharp corners and local contrast */
    FNL_ANTIALIASING_TAA,  /**< temporal: frames sample pixels at changing places and accumulate; no MSAA */
    FNL_ANTIALIASING_AUTO, /**< none with several samples per pixel (`msaa`), otherwise smaa */
    FNL_ANTIALIASING_COUNT
} fnl_antialiasing;

/** fnl_frame.msaa: 4 samples per pixel if device, shading path and other options support them, otherwise 1. */
enum { FNL_MSAA_AUTO = 0 };

/** The tone mapping curve. */
typedef enum fnl_tonemap {
    FNL_TONEMAP_NONE = 0,
    FNL_TONEMAP_KHRONOS_NEUTRAL,
    FNL_TONEMAP_ACES,
    FNL_TONEMAP_AGX,
    FNL_TONEMAP_COUNT
} fnl_tonemap;

typedef enum fnl_exposure {
    FNL_EXPOSURE_AUTO = 0, /**< metered from the frame, mostly surfaces and the center; preserves highlights */
    FNL_EXPOSURE_EV,       /**< from fnl_frame.ev: radiance is scaled by 1 / (1.2 * 2^ev) */
    FNL_EXPOSURE_NONE      /**< radiance is shown as it is */
} fnl_exposure;

/** Pictures of what goes on inside a frame. docs/techniques/debug-views.md shows them. */
typedef enum fnl_debug_view {
    FNL_DEBUG_NONE = 0,
    FNL_DEBUG_ALBEDO,
    FNL_DEBUG_NORMAL,
    FNL_DEBUG_DEPTH,
    FNL_DEBUG_ROUGHNESS,
    FNL_DEBUG_LIGHTS,         /**< heat map of the lights that each pixel visits, with a legend */
    FNL_DEBUG_CELLS,          /**< the tiles of the light list, or its depth slices in colours */
    FNL_DEBUG_OVERDRAW,       /**< fragments per pixel, occluded ones too, with a legend */
    FNL_DEBUG_TILE_NORMALS,   /**< backface lists: the mean normal of each tile */
    FNL_DEBUG_BACKFACES,      /**< backface lists: heat map of the lights that each tile drops, with a legend */
    FNL_DEBUG_OVERSHADING,    /**< fragment shader invocations per pixel of visible surfaces, helper lanes of 2x2 quads too, with a legend */
    FNL_DEBUG_LAYERS,         /**< heat map of the blended surfaces in each pixel, with a legend */
    FNL_DEBUG_DECALS,         /**< heat map of the box and volume decals that contain a pixel's surface, with a legend */
    FNL_DEBUG_GBUFFER_0,      /**< the fields of a render target of the G-buffer, as lighting reads them; several share the picture */
    FNL_DEBUG_GBUFFER_1,
    FNL_DEBUG_GBUFFER_2,
    FNL_DEBUG_GBUFFER_3,
    FNL_DEBUG_GBUFFER_4,
    FNL_DEBUG_MATERIAL_ID,    /**< a colour for each material id in the G-buffer */
    FNL_DEBUG_LIT_FORWARD,    /**< white where the layout cannot hold the material, which is therefore shaded forward */
    FNL_DEBUG_EDGES,          /**< MSAA: pixels that show several things: blue one surface and sky, green 2 surfaces, yellow 3, red more */
    FNL_DEBUG_MOTION,         /**< motion vectors: hue is direction, saturation is speed; grey stands still */
    FNL_DEBUG_HALOS,          /**< metals blue; metalness from 0.1 to 0.9 red, brighter where the colour is bright: the cause of halos */
    FNL_DEBUG_COARSE,         /**< coarse: green where a block is shaded once */
    FNL_DEBUG_COARSE_REASON,  /**< coarse: why others are not: depth or triangle red, normal blue, material yellow */
    FNL_DEBUG_DAIS_ADDRESSES, /**< dais: a colour for each stored triangle; white where there was no room for it */
    FNL_DEBUG_DAIS_TRIANGLES, /**< dais: different triangles in a pixel: 1 grey, 2 green, 3 yellow, more red */
    FNL_DEBUG_DAIS_FAILURES,  /**< dais: red where a triangle was stored again because its cache bucket stayed locked */
    FNL_DEBUG_CLUSTERS,       /**< a colour for each cluster of triangles; needs fnl_device_info.primitive_ids */
    FNL_DEBUG_ATLAS,          /**< virtual-texturing: the base colours in its atlas; hatched where it is empty */
    FNL_DEBUG_PAGES,          /**< virtual-texturing: a colour for each page, darker where coarser, striped where a finer one was wanted; 1 sample */
    FNL_DEBUG_SHADOW_PAGES,   /**< shadow maps: a colour for each page, of the light that gives most to the pixel, with page edges; magenta: none */
    FNL_DEBUG_SHADOW_LEVELS,  /**< shadow maps: the level of that page, finer is brighter, with a legend */
    FNL_DEBUG_SHADOW_TEXELS,  /**< shadow maps: a texel of that page against the pixel: up to its width green to blue, wider yellow to red */
    FNL_DEBUG_SHADOW_ERRORS,  /**< shadow maps against rays: red where light is that should not be, blue where it is missing */
    FNL_DEBUG_SHADOW_VARIANCE, /**< shadow.denoise: standard deviation of the part of the light that is seen, before it is filtered in space; brightest: a half */
    FNL_DEBUG_SHADOW_HISTORY, /**< shadow.denoise: frames that a pixel has collected; brightest: 32 */
    FNL_DEBUG_PROBE_LOOKUP, /**< cubemap shadows: texels of the cube map that are looked up for the light that gives most, a hue for each face; grey: none */
    FNL_DEBUG_PROBE_LEVELS, /**< cubemap shadows: the level of that look-up, finer is brighter, with a legend */
    FNL_DEBUG_REFLECTIONS,  /**< reflection probes: a colour for each, by its part of the light from all around; grey: none */
    FNL_DEBUG_SHADOW_RAYS, /**< rays, maps, hybrid, cubemap: heat map of the shadow rays of each pixel, with a legend */
    FNL_DEBUG_SHADOW_AGE,  /**< shadow maps: frames since the page of FNL_DEBUG_SHADOW_PAGES was drawn; striped where a finer one is wanted and not there */
    FNL_DEBUG_SHADOW_CLASSES, /**< fnl_shadow_options.classify: of the lights in a tile's list, those that left it, those that give no pixel light, some or all */
    FNL_DEBUG_TRIANGLES, /**< each triangle in its own color; needs fnl_device_info.primitive_ids */
    FNL_DEBUG_DEPTH_JUMPS, /**< tiles by the ratio of largest to smallest depth, with a legend; a high ratio means long light lists */
    FNL_DEBUG_LIGHT_VOLUMES, /**< surfaces in the hues of the lights that reach them; a line marks where a light's volume ends */
    FNL_DEBUG_COUNT
} fnl_debug_view;

/** What a frame keeps for fnl_renderer_read; bits. */
typedef enum fnl_output {
    FNL_OUTPUT_COLOR = 1,     /**< tone-mapped, sRGB-encoded RGBA8: the picture, or the debug view */
    FNL_OUTPUT_RADIANCE = 2,  /**< linear radiance in cd/m^2 before exposure and tone mapping, RGBA32F; alpha: the part of the pixel that surfaces cover */
    FNL_OUTPUT_SURFACE = 4,   /**< RGBA32F: base colour RGB and roughness of the nearest surface that is not blended */
    FNL_OUTPUT_NORMAL = 8,    /**< RGBA32F: world-space normal, view depth in metres; 0 where there is nothing */
    FNL_OUTPUT_POSITION = 16, /**< RGBA32F: world-space position, draw item id + 1; 0 where there is nothing */
    /**
     * RGBA32F. XY: how many pixels right and down an opaque surface, or the background, was in the last frame. Z: its view depth then in metres,
     * 1e30 for an empty background. W: 1 plus the part of the motion in pixels that is not the camera's, or 0 where it was behind the camera,
     * was not shown, or there was no last frame. Where several renderers share a scene, the last frame of this one counts as none unless it
     * had motion vectors too (this output, FNL_DEBUG_MOTION or temporal antialiasing) or nothing has moved since. No MSAA.
     */
    FNL_OUTPUT_MOTION = 32,
    /**
     * RGBA32F, four whole numbers for the nearest surface: the index of its instance (as queries take it) + 1; the primitive of its mesh; the index of its
     * material, -1 for glTF's default material; and a number that tells the triangles (lines, points) of the primitive apart, below their count: not their
     * order in the mesh, but the same in all frames until the mesh changes; 0 on devices without fnl_device_info.primitive_ids. All 0 where there is
     * nothing. Exact below 2^24. What is seen through a hole of a cutout is the surface behind it. Glass counts, and blended
     * surfaces do where their alpha is at least 1/16. Indices are those of the scene when the frame was rendered. Of the sample at the pixel's centre.
     */
    FNL_OUTPUT_OBJECT = 64
} fnl_output;

/** Views that a frame may have. */
enum { FNL_VIEWS_MAX = 64 };

/** Reflection probes (fnl_probe_params.reflection); docs/techniques/reflection-probes.md. */
typedef struct fnl_reflection_options {
    /** Probes that are captured anew for each frame, in turn, 0 .. 1024; 0 (default): none, each is captured once, and when it is set again. */
    uint32_t refresh;
    /**
     * How often light is reflected by surfaces that mirror, or get their light from all around, before it is seen: a probe that is captured for the first
     * time is captured so many times, 1 .. 8; default 1. Captures that refresh it go on from there.
     */
    uint32_t bounces;
    /** Follows reflections to the walls of the box; false: they are looked up as if these were infinitely far away. Default true. */
    bool parallax;
} fnl_reflection_options;

typedef struct fnl_frame {
    /** Size of the picture in pixels, 1 .. 16384. Default 1280 x 720. */
    uint32_t width, height;
    /** Default fnl_camera_default(). */
    fnl_camera camera;
    /**
     * Cameras of a frame with several views, `view_count` of them, 0 .. FNL_VIEWS_MAX. Each gives a picture of the frame's size, equal to the bit to that
     * of a frame with this camera alone; what does not depend on the camera is done once for all of them. `camera` is then ignored. The array belongs to
     * the caller and is read only during the call. Default NULL and 0: one view, of `camera`.
     * Every path and list takes several views, except virtual-texturing; it fails with FNL_ERROR_UNSUPPORTED, and so does light_lod. Auto stands for deferred
     * and clustered, and measures nothing. docs/techniques/views.md tells more.
     */
    const fnl_camera *views;
    uint32_t view_count;
    /**
     * What nobody sees of the views, one for each (of a frame without `views` one, for `camera`): those pixels are black and cost next to nothing. All others
     * are as without it, but for what looks at neighbours: `aa` within a few pixels of it, and exposure by metering, which passes over it. Read only during
     * the call. Of perspective cameras, in forward (but for the lists batches and multipass), forward-prepass, deferred and visibility (without grid); all others fail with
     * FNL_ERROR_UNSUPPORTED. Auto stands for deferred and clustered. Outputs other than COLOR and RADIANCE show what is hidden. Default NULL.
     */
    const fnl_hidden_area *hidden_areas;
    /**
     * The camera by whose picture levels of detail are chosen: that of a viewer, where several views, or frames on several devices, have to show the same
     * ones. It is read only during the call. Default NULL: the middle between the eyes of a display (`stereo`), else the first of `views`, or `camera`.
     */
    const fnl_camera *viewer;
    /**
     * The point in the world that the viewer looks at, for `coarse.fovea`; of all views. A direction is a point far away. Read only during the call. Default
     * NULL: straight ahead, along the axis of each view.
     */
    const fnl_vec3 *gaze;
    /**
     * Which views share draw calls, in forward-prepass, deferred and visibility: the depth prepass, the G-buffer and the ids are then drawn once into
     * several layers, with what any of the views sees. Where that does not work, views are drawn one by one, without an error: on devices without
     * fnl_device_info.multiview, with culling by clusters or triangles, decals, or occlusion where views are no eyes, and in visibility with grid,
     * barycentrics or count_lights. Default auto. For views that are eyes (stereo.eyes) stereo.path says it: anything but auto is then FNL_ERROR_INVALID.
     */
    fnl_multiview multiview;
    /** Which views are eyes of one viewer. Default none are. */
    fnl_stereo_options stereo;
    /** Default FNL_SHADING_DEFERRED. */
    fnl_shading shading;
    /** Default FNL_LISTS_AUTO. */
    fnl_light_lists lists;
    /** Default maps, which cost nothing in scenes without lights. */
    fnl_shadows shadows;
    fnl_shadow_options shadow;
    /** Samples per pixel: 1, 2, 4 or 8, up to fnl_device_info.max_msaa, or FNL_MSAA_AUTO, the default. */
    uint32_t msaa;
    /** Whether builtin:studio lights scenes without an environment or ambient light; default true. With 1 to FNL_STUDIO_FILL_LIGHTS lights it is a fill
        only: without its key light, and as bright as the lights on average. With more lights it is off. */
    bool studio;
    /** Default auto. */
    fnl_ground ground;
    /** Default auto. */
    fnl_background background;
    /** FNL_BACKGROUND_BLUR: blur angle of the environment, radians, 0 .. pi. Default 0.35 (20 degrees). */
    float background_blur;
    /** Default gltf. */
    fnl_energy energy;
    /** Default sorted. */
    fnl_transparency transparency;
    /** Most surfaces in a pixel that show what is behind them (fnl_transmission_params), 1 .. 8: the nearest. Frames draw as many layers as the one
        before would have needed. Default 4. */
    uint32_t transmission_layers;
    /** mlaa and smaa change only the color output; taa accumulates over the frames of a renderer. Default auto. */
    fnl_antialiasing aa;
    /** Moves the sample of each pixel right and down, pixels, -8 .. 8. The mean of frames with the places that fnl_jitter() gives is a picture with as
        many samples per pixel. Default 0. */
    fnl_vec2 jitter;
    /** Forgets what was accumulated from earlier frames: for camera cuts, which cannot be told from fast motion. Default false. */
    bool reset_history;
    /** Default FNL_TONEMAP_KHRONOS_NEUTRAL. */
    fnl_tonemap tonemap;
    /** Default FNL_EXPOSURE_AUTO. */
    fnl_exposure exposure;
    /** EV100 for FNL_EXPOSURE_EV, -64 .. 64. Default 0. */
    float ev;
    /** Default none. */
    fnl_debug_view debug;
    /** fnl_output bits. Default FNL_OUTPUT_COLOR. */
    uint32_t outputs;
    /** Counts light evaluations and more exactly, which is slower. Default false. */
    bool count_lights;
    /** Measures each pass on the GPU. Default true. */
    bool timers;
    /**
     * With FNL_SHADING_AUTO or FNL_LISTS_AUTO: do not use this frame for measuring. It tries no candidate, compiles no pipelines for one and adds no
     * timers. It takes the choice made so far, else the one remembered from an earlier run, else the best of what was measured, else the likely one. Set
     * in all frames, the renderer never measures, and a choice changes only with the scene, the size or what is asked for. For single frames, and where
     * every frame must cost the same. Default false.
     */
    bool pin_choice;
    /**
     * FNL_SHADING_AUTO also measures FNL_SHADING_VISIBILITY, often the fastest, where the device can do it (fnl_device_info.primitive_ids). Its
     * picture is close to that of the other candidates, not equal: textures are filtered in another way (docs/choosing.md has the differences).
     * Default false.
     */
    bool choose_close;
    /** Threads that record commands, 0 .. 1024; 0 (default): as many as the job system has. */
    uint32_t record_threads;
    /** Lights whose bounding sphere has a smaller radius on the screen, in pixels, >= 0, are drawn as points of equal brightness and light nothing;
        up to twice the size they fade. 0 (default): off. */
    float light_lod;
    /** Extra loop iterations each time a surface is lit, 0 .. 100000, to imitate a more expensive material; the picture is the same. inferred
        ignores it; light-prepass, pre-lighting, low-res, zioma, multipass lists and mobile.lights=volumes do for opaque surfaces. Default 0. */
    uint32_t shade_cost;

    /** Of opaque and alpha-masked surfaces. Default instances, which adds no passes. Large scenes gain from triangles. */
    fnl_culling culling;
    /** Default vertex. A frame with a pass that needs vertex shaders uses them for everything: motion and taa, stored barycentrics of visibility, the
        lists batches and multipass, mesh decals. fnl_frame_stats.geometry says what was used. */
    fnl_geometry geometry;
    /** Culls occluded surfaces too, by the depths of this very frame. The picture is the same; the debug view overdraw shows less. No effect in low-res,
        inferred and with visibility.grid, nor with MSAA where a debug view or an output looks at pixel centres. Default auto;
        fnl_frame_stats.occlusion says what was done. */
    fnl_occlusion occlusion;
    /** Front-to-back order of opaque instances, by bounding box; default false: scene order. Same picture except at
        coplanar surfaces and, with MSAA, edges. Only with FNL_CULLING_INSTANCES and one view at a time. */
    bool front_to_back;
    /** Path forward: minimum width or height of instances in a depth prepass, pixels, 0 .. 100000; default 0: no
        prepass. Same picture except at edges with MSAA. Not with the lists batches and multipass. */
    float prepass_pixels;
    /** Default lists. */
    fnl_decals decals;
    /** FNL_DECALS_GBUFFER: chooses mip levels by the slope of the surface, not by how positions differ between pixels, which draws fringes at
        silhouettes. False shows the fault. Default true. */
    bool decal_mip_fix;

    fnl_reflection_options reflections;

    /** What is drawn over the picture, in frames of one view: over FNL_OUTPUT_COLOR, or over the image of fnl_renderer_render_to, whose pixels it then
        counts in. Read only during the call. Default NULL: nothing. */
    const fnl_overlay *overlay;
    /** A pixel whose surface, lights and shadows are told: fnl_renderer_query_pixel(). Default none. */
    fnl_pixel_query pixel;

    /* Light lists, by the kinds that heed them (fanal/lights.h). */
    fnl_list_options list;
    fnl_tile_options tiles;
    fnl_cluster_options clusters;
    fnl_fine_options fine;
    fnl_raster_options raster;

    /* Shading paths (fanal/gbuffer.h, fanal/shading_options.h). */
    fnl_gbuffer_options gbuffer;
    fnl_deferred_options deferred;
    fnl_volume_shape volume_shape;
    /** deferred-volumes with FNL_VOLUME_FULLSCREEN: lights added per draw, 1 .. 64; each draw reads the G-buffer once. Default 1. */
    uint32_t volume_batch;
    fnl_light_buffer_options light_buffer;
    fnl_light_indexed_options light_indexed;
    fnl_visibility_options visibility;
    fnl_texturing_options texturing;
    fnl_coarse_options coarse;
    fnl_dais_options dais;
    fnl_mobile_options mobile;
} fnl_frame;

/** A frame with all defaults. */
FNL_API fnl_frame fnl_frame_default(void);
/** Place `index` of a sequence that fills the pixel evenly, each coordinate -0.5 .. 0.5; the first is the centre. */
FNL_API fnl_vec2 fnl_jitter(uint32_t index);

#ifdef __cplusplus
}
#endif
#endif
