/* SPDX-License-Identifier: MIT */
/** Contact shadows: beside any method, a march along the view's depth (shaders/lighting/visibility_contact.glsl). */
#include "render/orders/order.h"
#include "render/shadows/contact.h"
#include "render/shadows/maps.h"
#include "render/step.h"

graph_image shadows_depth(struct frame_state *f) {
    if (frame_is(f->frame, SHADING_PREPASS) || shading_order(f->frame->shading)->draw) return f->depth;
    if (f->shadows.depth.id) return f->shadows.depth;
    f->shadows.depth = frame_create_image(f, "shadow depth", GEOMETRY_DEPTH_FORMAT, f->frame->msaa);
    geometry_depth_add(f->graph, "shadow depth", &f->scene->geometry, &f->draws, f->view_address, f->shadows.depth);
    return f->shadows.depth;
}

void shadow_contact_add(struct frame_state *f) {
    if (!(f->frame->shadow.contact_length > 0)) return;
    f->lighting.shadows.contact = shadows_depth(f);
    f->lighting.shadows.contact_length = f->frame->shadow.contact_length;
}
