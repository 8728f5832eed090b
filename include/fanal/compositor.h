/* SPDX-License-Identifier: MIT */
/**
 * From the pictures of the eyes to the display of a headset: late pose, lenses, layers. A runtime such as OpenXR's does this itself; this is for displays
 * without one, for tests, and to see what happens. docs/techniques/headset-display.md tells more.
 */
#ifndef FANAL_COMPOSITOR_H
#define FANAL_COMPOSITOR_H

#include "fanal/device.h"
#include "fanal/image.h"
#include "fanal/stereo.h"

#ifdef __cplusplus
extern "C" {
#endif

/**
 * A lens, with a polynomial for each colour: what the display has at the tangents q, measured as if there were no lens, shows the direction
 * center + (q - center) * (1 + k[0] r^2 + k[1] r^4 + k[2] r^6 + k[3] r^8), where r is the distance of q from the centre. All 0: no lens.
 */
typedef struct fnl_lens {
    fnl_vec2 center; /**< tangents */
    float k[3][4];   /**< red, green, blue */
} fnl_lens;

/**
 * Where an edge of the display is, as fnl_display_eye has it, so that what it shows in green is the tangent `edge`, on a line through the centre of
 * the lens: the inverse of the polynomial. For polynomials that grow with r. 0 where `lens` is NULL.
 */
FNL_API float fnl_lens_display_edge(const fnl_lens *lens, float edge, bool vertical);

/** How the lens is undone. */
typedef enum fnl_warp {
    FNL_WARP_MESH = 0, /**< a mesh of 48 x 48 quads, bent once for each colour */
    FNL_WARP_PIXEL,    /**< the polynomial for each pixel: the reference */
    FNL_WARP_OFF,      /**< not at all: the eye's picture fills its part of the display */
    FNL_WARP_COUNT
} fnl_warp;

typedef struct fnl_display_eye {
    fnl_eye eye; /**< what was rendered, and where the eye is in the head */
    fnl_lens lens;
    float left, right, down, up; /**< edges of its part of the display, tangents without lens */
    float visible_radius; /**< tangents around the lens's centre that are seen; all beyond is black. Default INFINITY */
} fnl_display_eye;

typedef struct fnl_compositor_params {
    uint32_t width, height; /**< pixels of the display for each eye, 1 .. 8192 */
    uint32_t eye_count;     /**< 1 or 2, side by side */
    fnl_display_eye eyes[2];
    fnl_warp warp; /**< default mesh */
    bool trim;     /**< leaves out quads that are all black; default true */
    bool count;    /**< counts pixels (fnl_compositor_stats), which is slower; default false */
} fnl_compositor_params;

/** Two eyes 64 mm apart with 90 degrees, 1080 x 1080 pixels each, without lenses. */
FNL_API fnl_compositor_params fnl_compositor_params_default(void);

typedef struct fnl_compositor fnl_compositor;

/** FNL_ERROR_INVALID where params are not as said. The device must outlive it. Calls on it belong to the thread that renders. */
FNL_API fnl_result fnl_compositor_create(fnl_device *device, const fnl_compositor_params *params, fnl_compositor **out);
FNL_API void fnl_compositor_destroy(fnl_compositor **compositor);

/** A finished frame. */
typedef struct fnl_eye_pictures {
    const fnl_image *color;  /**< RGBA8, sRGB: one below the other, as FNL_OUTPUT_COLOR has them */
    const fnl_image *normal; /**< FNL_OUTPUT_NORMAL of the same frame, whose W is depth; or NULL: only its rotation can be corrected */
    fnl_rigid_pose head;     /**< for which it was rendered */
} fnl_eye_pictures;

/** The newest finished frame, which is shown until the next. Its pictures are copied. */
FNL_API fnl_result fnl_compositor_submit(fnl_compositor *compositor, const fnl_eye_pictures *pictures);

/** A flat picture at a place: text, a menu. It is warped at its own resolution. */
typedef struct fnl_layer {
    const fnl_image *image; /**< RGBA8 in sRGB, alpha not premultiplied */
    uint64_t version;       /**< the image is sent when this number is another than the last time in this place of the array */
    fnl_rigid_pose pose;    /**< of its middle; it is seen from where its +Z points to */
    float width, height;    /**< metres, > 0 */
    bool head_locked;       /**< `pose` is in the space of the head, else of the world */
} fnl_layer;

enum { FNL_LAYERS_MAX = 8 };

/** How a frame of an older pose is brought to the newest. */
typedef enum fnl_reprojection {
    FNL_REPROJECTION_ROTATION = 0, /**< turned: right for what is far */
    FNL_REPROJECTION_DEPTH,        /**< moved by its depth too; without depth as rotation. What was hidden shows what it would be if it were far */
    FNL_REPROJECTION_OFF,          /**< not at all */
    FNL_REPROJECTION_COUNT
} fnl_reprojection;

/** Pictures of what goes on. */
typedef enum fnl_display_view {
    FNL_DISPLAY_VIEW_NONE = 0,
    FNL_DISPLAY_VIEW_MASK,    /**< what nobody sees is tinted where it is drawn, and black where trimming leaves it out */
    FNL_DISPLAY_VIEW_MESH,    /**< the quads of the mesh over the picture */
    FNL_DISPLAY_VIEW_FRINGES, /**< red and blue: how many pixels of the eye's picture these are apart from green, brightest 8 */
    FNL_DISPLAY_VIEW_COUNT
} fnl_display_view;

typedef struct fnl_composition {
    fnl_rigid_pose head; /**< the newest */
    fnl_reprojection reprojection;
    const fnl_layer *layers; /**< the first is drawn first; read during the call alone */
    uint32_t layer_count;    /**< 0 .. FNL_LAYERS_MAX */
    bool layers_first;       /**< blends them into the eyes' pictures before the lens is undone: cheaper, and less sharp */
    fnl_display_view view;
} fnl_composition;

/** Makes a picture for the display and waits for it: RGBA8, the eyes side by side, black before the first frame; free it with fnl_image_free. */
FNL_API fnl_result fnl_compositor_compose(fnl_compositor *compositor, const fnl_composition *composition, fnl_image *out);

typedef struct fnl_compositor_stats {
    uint32_t quads, quads_drawn; /**< of the meshes of all eyes; 0 without meshes */
    uint64_t pixels_shaded;      /**< of the last picture, with fnl_compositor_params.count */
    uint64_t submitted, composed; /**< frames, pictures */
    uint32_t repeated;           /**< how many pictures have shown the newest frame, the last included */
    uint32_t layers_uncomfortable; /**< of the last picture: their middles are nearer to the head than 0.75 m or farther away than 3.5 m; the log tells of the first */
} fnl_compositor_stats;

FNL_API fnl_result fnl_compositor_query_stats(const fnl_compositor *compositor, fnl_compositor_stats *out);

#ifdef __cplusplus
}
#endif
#endif
