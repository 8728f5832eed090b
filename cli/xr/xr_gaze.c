/* SPDX-License-Identifier: MIT */
/* Where the user looks (XR_EXT_eye_gaze_interaction), for foveation. */
#include "xr/xr.h"

#include <stdio.h>

/*
 * Metres along the gaze at which its point is put. Eyes are 32 mm beside where the gaze begins, so a point 2 m away is seen within a degree of the gaze from either eye,
 * however far away is what it is aimed at, from 1 m on.
 */
static const float gaze_distance = 2;

bool xr_wants_gaze(const struct xr *x) {
    const fnl_frame *frame = &x->options->frame;
    return !x->options->no_gaze && frame->shading == FNL_SHADING_COARSE && frame->coarse.fovea > 0;
}

static bool make_action(struct xr *x) {
    XrActionCreateInfo info = {.type = XR_TYPE_ACTION_CREATE_INFO, .actionType = XR_ACTION_TYPE_POSE_INPUT};
    XrActionSetCreateInfo set = {.type = XR_TYPE_ACTION_SET_CREATE_INFO};
    snprintf(set.actionSetName, sizeof set.actionSetName, "eyes");
    snprintf(set.localizedActionSetName, sizeof set.localizedActionSetName, "Eyes");
    snprintf(info.actionName, sizeof info.actionName, "gaze");
    snprintf(info.localizedActionName, sizeof info.localizedActionName, "Where you look is sharpest");
    return xr_may(x, "xrCreateActionSet", xrCreateActionSet(x->instance, &set, &x->gaze_actions), "the gaze") &&
           xr_may(x, "xrCreateAction", xrCreateAction(x->gaze_actions, &info, &x->gaze_action), "the gaze");
}

static bool bind(struct xr *x) {
    XrActionSuggestedBinding binding = {.action = x->gaze_action};
    XrInteractionProfileSuggestedBinding info = {.type = XR_TYPE_INTERACTION_PROFILE_SUGGESTED_BINDING, .countSuggestedBindings = 1, .suggestedBindings = &binding};
    return xr_may(x, "xrStringToPath", xrStringToPath(x->instance, "/interaction_profiles/ext/eye_gaze_interaction", &info.interactionProfile), "the gaze") &&
           xr_may(x, "xrStringToPath", xrStringToPath(x->instance, "/user/eyes_ext/input/gaze_ext/pose", &binding.binding), "the gaze") &&
           xr_may(x, "xrSuggestInteractionProfileBindings", xrSuggestInteractionProfileBindings(x->instance, &info), "the gaze");
}

bool xr_start_gaze(struct xr *x) {
    if (!make_action(x) || !bind(x)) return false;
    const XrActionSpaceCreateInfo info = {.type = XR_TYPE_ACTION_SPACE_CREATE_INFO, .action = x->gaze_action, .poseInActionSpace = {{0, 0, 0, 1}, {0, 0, 0}}};
    return xr_may(x, "xrCreateActionSpace", xrCreateActionSpace(x->session, &info, &x->gaze_space), "the gaze");
}

void xr_find_gaze(struct xr *x, XrTime time) {
    const XrActionStateGetInfo info = {.type = XR_TYPE_ACTION_STATE_GET_INFO, .action = x->gaze_action};
    XrActionStatePose state = {.type = XR_TYPE_ACTION_STATE_POSE};
    XrSpaceLocation location = {.type = XR_TYPE_SPACE_LOCATION};
    x->gaze_known = false;
    if (!x->has_gaze || !x->placed) return;
    if (!xr_may(x, "xrGetActionStatePose", xrGetActionStatePose(x->session, &info, &state), "the gaze") ||
        (state.isActive && !xr_may(x, "xrLocateSpace", xrLocateSpace(x->gaze_space, x->space, time, &location), "the gaze"))) {
        x->has_gaze = false;
        return;
    }
    /* A direction that is not tracked is a guess, of a blink for instance. */
    const XrSpaceLocationFlags wanted = XR_SPACE_LOCATION_ORIENTATION_VALID_BIT | XR_SPACE_LOCATION_POSITION_VALID_BIT | XR_SPACE_LOCATION_ORIENTATION_TRACKED_BIT;
    if (!state.isActive || (location.locationFlags & wanted) != wanted || !xr_is_pose(x, XR_POSE_GAZE, &location.pose)) return;
    const fnl_rigid_pose eyes = xr_pose(x, &location.pose), pose = pose_mul(&x->rig, &eyes);
    x->gaze = add3(pose.position, quat_turn(pose.rotation, (fnl_vec3){0, 0, -gaze_distance * x->options->world_scale}));
    x->gaze_known = true;
}
