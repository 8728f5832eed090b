/* SPDX-License-Identifier: MIT */
/**
 * Eyes: what a headset, or a wall that is looked through, says about a view, and the camera that it makes. A stereo frame has one camera for each eye
 * (fnl_frame.views).
 */
#ifndef FANAL_STEREO_H
#define FANAL_STEREO_H

#include "fanal/camera.h"
#include "fanal/image.h"

#ifdef __cplusplus
extern "C" {
#endif

/** A place and a direction. Without rotation +X is right, +Y up, and -Z ahead. */
typedef struct fnl_rigid_pose {
    fnl_vec3 position; /**< metres */
    fnl_vec4 rotation; /**< unit quaternion x, y, z, w */
} fnl_rigid_pose;

/** One eye, in the space of the head. */
typedef struct fnl_eye {
    fnl_rigid_pose pose;                /**< seen from the head; of two eyes that look straight ahead: half the distance between them along X, no rotation */
    float left, right, down, up; /**< edges of the picture: tangents of their angles to the eye's axis; left < right, down < up. -1, 1, -1, 1: 90 degrees */
} fnl_eye;

/** What the light lists of two eyes are made for. docs/techniques/stereo.md compares them. */
typedef enum fnl_stereo_lists {
    FNL_STEREO_LISTS_EYE = 0, /**< one for each eye */
    FNL_STEREO_LISTS_HEAD,    /**< one for both, over all that either sees: of the kinds clustered, clustered-cpu, bvh, zbin and raster; others as eye */
    FNL_STEREO_LISTS_AUTO,    /**< as head where the frustum that holds what all eyes see has no more pixels than they have together, else as eye */
    FNL_STEREO_LISTS_COUNT
} fnl_stereo_lists;

/**
 * How what needs no lists is drawn for the eyes of a display: in forward-prepass, deferred and visibility the depth prepass, the G-buffer and the ids.
 * Pictures are the same to the bit. docs/techniques/stereo.md compares them.
 */
typedef enum fnl_stereo_path {
    FNL_STEREO_PATH_AUTO = 0,  /**< multiview; eyes in forward-prepass, where sharing the prepass gains nothing */
    FNL_STEREO_PATH_EYES,      /**< all for one eye, then all for the next */
    FNL_STEREO_PATH_OBJECTS,   /**< a draw call for each eye, one after the other, with the states of the first */
    FNL_STEREO_PATH_INSTANCES, /**< one draw call, with an instance for each eye */
    FNL_STEREO_PATH_MULTIVIEW, /**< one draw call that the device repeats for each eye */
    FNL_STEREO_PATH_COUNT
} fnl_stereo_path;

/**
 * Views of a frame (fnl_frame.views) that are the eyes of one viewer, before one display. They are culled together, by one frustum that holds all of
 * theirs; they share shadow maps, exposure, and the choice of levels of detail, which goes by the middle between them. With an exposure that is given
 * pictures equal those of each eye alone to the bit, but for single pixels at the edges of shadows from maps, which round by where in their image pages lie.
 */
typedef struct fnl_stereo_options {
    /** Every so many views are the eyes of a display: 2 .. 6, of which view_count is a multiple; 0 (default): views have nothing to do with one another. */
    uint32_t eyes;
    /** The picture is the same. Default auto. */
    fnl_stereo_lists lists;
    /**
     * Default auto. Where eyes cannot be drawn at once they are drawn one by one, without an error: with culling by clusters or triangles, decals, and in
     * visibility with grid, barycentrics or count_lights. On devices without fnl_device_info.vertex_layers multiview stands in for objects and
     * instances, and on those without fnl_device_info.multiview eyes for multiview; the log says so.
     */
    fnl_stereo_path path;
    /** Degrees by which the common frustum is wider on each side, 0 .. 20: heads may turn so far after culling. Default 0. */
    float margin;
    /**
     * Metres, 0 .. 1e6: opaque surfaces beyond a plane so far away, at right angles to where the head looks, are drawn once for all eyes of a display, from
     * the middle between them; those that cross the plane are drawn by both. Each is seen within half the distance between the eyes / mono_distance *
     * focal length, in pixels, of where the eye would see it: 1.7 with 64 mm, 10 m and 540 pixels. What is nearer, transparent, or sky is as without it. In forward-prepass,
     * deferred and visibility (without grid), of one sample, without TAA, culling by clusters or triangles, occlusion, debug views, pixel queries, and outputs other than COLOR and RADIANCE; all else fails with
     * FNL_ERROR_UNSUPPORTED. The numbers of each display's mono view stand behind those of the views (fnl_frame_stats.views). Default 0: off.
     */
    float mono_distance;
} fnl_stereo_options;

/**
 * The camera of an eye for a picture of width x height pixels, 1 .. 16384. `head` is the head's pose in the world. near_distance: metres, > 0. Fails with
 * FNL_ERROR_INVALID where an argument other than `host` is NULL or not as above.
 */
FNL_API fnl_result fnl_eye_query_camera(const fnl_host *host, const fnl_eye *eye, const fnl_rigid_pose *head, uint32_t width, uint32_t height,
                                        float near_distance, fnl_camera *out);

/** What nobody sees of an eye's picture, as headsets tell it: the lens does not show its corners. */
typedef struct fnl_hidden_area {
    /** Corners of triangles of either winding, three by three: tangents of the angles to the eye's axis, right and up. They may reach beyond the picture. */
    const fnl_vec2 *corners;
    uint32_t corner_count; /**< a multiple of 3; 0: all is seen */
} fnl_hidden_area;

/** Corners that fnl_hidden_area_round() makes with so many segments. */
#define FNL_HIDDEN_ROUND_CORNERS(segments) (6 * (segments))
/**
 * All that lies outside of a circle of the radius `radius` (tangents, > 0) around `center`; the circle is a regular
 * polygon around it with `segments` sides, 3 .. 1024, so that a bit more than the circle is seen. Writes FNL_HIDDEN_ROUND_CORNERS(segments) corners to
 * `corners`, which is the caller's, and points `out` to them. FNL_ERROR_INVALID where an argument other than `host` is NULL or not as said.
 */
FNL_API fnl_result fnl_hidden_area_round(const fnl_host *host, const fnl_eye *eye, fnl_vec2 center, float radius, uint32_t segments, fnl_vec2 *corners,
                                         fnl_hidden_area *out);

/** A rectangle of an eye's picture that is rendered as a picture of its own. */
typedef struct fnl_eye_cell {
    fnl_eye eye;                              /**< for fnl_eye_query_camera(), with the rendered size */
    uint32_t x, y, width, height;             /**< in the eye's picture, pixels from its upper left corner */
    uint32_t rendered_width, rendered_height; /**< pixels that are shaded for it, at least 1 */
} fnl_eye_cell;

/**
 * Multi-resolution: 3 x 3 cells in reading order. The middle one, `inner` of the width and of the height (0 < inner <= 1, but each border is at least a pixel), has
 * as many pixels as the picture has there; the borders have `scale` times as many across (0 < scale <= 1). Cells of one size can be views of one frame: the
 * corners, left and right, top and bottom. width and height: 3 .. 16384.
 */
FNL_API fnl_result fnl_eye_query_cells(const fnl_host *host, const fnl_eye *eye, uint32_t width, uint32_t height, float inner, float scale,
                                       fnl_eye_cell cells[9]);

/**
 * Divides the picture of `eye` (width x height pixels, 2 .. 16384 each) for lens-matched shading: 4 quadrants in reading order, each rendered on a tilted
 * plane. w grows from 1 at the eye's axis by strength.x |x| + strength.y |y|, where x and y are 1 at the edges of the picture, as with
 * VK_NV_clip_space_w_scaling. A rendered pixel covers one pixel of the eye at the axis and about w^3 elsewhere. All quadrants have the same rendered size,
 * so one frame can render them as views. strength: 0 .. 1 each; 0.3 is typical. Edges of the eye: left < 0 < right, down < 0 < up. Depth values of
 * different quadrants are not comparable. FNL_ERROR_INVALID if an argument is NULL or out of range, or if quadrants would need more than 16384 pixels.
 */
FNL_API fnl_result fnl_eye_query_quadrants(const fnl_host *host, const fnl_eye *eye, uint32_t width, uint32_t height, fnl_vec2 strength,
                                           fnl_eye_cell cells[4]);

/**
 * Assembles the picture of `eye` from the pictures of its cells, as fnl_eye_query_cells() or fnl_eye_query_quadrants() returned them. pictures[i] has the
 * rendered size of cells[i]; all are RGBA8 (sRGB) or all RGBA32F. `out` has the same format and reaches as far as the cells do; pixels outside all cells
 * are black. Free it with fnl_image_free(). Values are interpolated linearly, RGBA8 in linear light; where a pixel of the eye is exactly a pixel
 * of a cell, its value is unchanged. cell_count: 1 .. 64. FNL_ERROR_INVALID if an argument is NULL, out of range, or a picture does not fit its cell.
 */
FNL_API fnl_result fnl_eye_join_cells(const fnl_host *host, const fnl_eye *eye, const fnl_eye_cell *cells, uint32_t cell_count, const fnl_image *pictures,
                                      fnl_image *out);

#ifdef __cplusplus
}
#endif
#endif
